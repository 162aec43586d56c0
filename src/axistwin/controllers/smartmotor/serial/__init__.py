"""The SmartMotor's serial channels and its program storage commands."""
