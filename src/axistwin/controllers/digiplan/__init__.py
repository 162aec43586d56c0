"""Digiplan IF1 and IF2: RS232 stepper motor interfaces of 1986."""
