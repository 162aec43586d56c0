"""Hosts of boards on a bus: C programs at the bus socket (`c/`), and an 8086 in this process (`x86.py`)."""

from pathlib import Path

C_FILES = Path(__file__).parent / "c"
"""Where `axistwin_bus.c` and `axistwin_bus.h` are."""
