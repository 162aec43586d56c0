"""The chapters of the SmartMotor manuals, one module each."""
