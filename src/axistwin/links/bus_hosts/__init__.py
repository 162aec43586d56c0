"""Hosts of bus boards: C files for programs at the bus socket (`c/`), and an emulated 8086 (`x86.py`)."""

from pathlib import Path

C_FILES = Path(__file__).parent / "c"  # Directory of `axistwin_bus.c` and `axistwin_bus.h`.
