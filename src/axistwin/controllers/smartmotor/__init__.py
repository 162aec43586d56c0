"""Animatics SmartMotor with firmware 4.76: a servo motor that runs its own language."""
