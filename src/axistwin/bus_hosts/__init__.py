"""Hosts of bus boards: C files for programs at the bus socket (`c/`), and an emulated 8086 (`x86.py`)."""

from pathlib import Path
from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.bus_hosts.x86 import Computer
else:  # Import x86.py only when the class `Computer` is used, because x86.py needs the optional package unicorn.
    __getattr__ = lazy(__name__, x86="Computer")

__all__ = ["C_FILES", "Computer"]

C_FILES = Path(__file__).parent / "c"  # Directory of `axistwin_bus.c` and `axistwin_bus.h`.
