"""Diagnostics of programs for the 1810 and 1811."""
