"""The command line: one module per command, in a folder per task; `program.py` has the table of commands.

The commands import large modules inside functions, so that the program `axistwin` starts fast.
"""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.cli.program import COMMANDS, axistwin, execute, main
else:  # Import program.py only on first use, because program.py also imports this package.
    __getattr__ = lazy(__name__, program="COMMANDS axistwin execute main")

__all__ = ["COMMANDS", "axistwin", "execute", "main"]
