"""Diagnostics of SmartMotor programs."""
