"""The machine that the controllers drive: axes, motors, encoders, switches, loads."""
