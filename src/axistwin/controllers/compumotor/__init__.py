"""Compumotor 1810 and 1811: Multibus motor controllers of 1984."""
