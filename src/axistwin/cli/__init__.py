"""The command line: one module per command, in a folder per task; `program.py` has the table of commands."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.cli.program import COMMANDS, axistwin, execute, main
else:  # lazy import: an eager import would be circular, because `program` imports modules of `axistwin.cli`
    __getattr__ = lazy(__name__, program="COMMANDS axistwin execute main")

__all__ = ["COMMANDS", "axistwin", "execute", "main"]
