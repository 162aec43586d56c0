"""Programs: command lines, hex commands and stored programs, and running them on a bench."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.programs.command_lines import read_command_lines, run_until_quiet, send_lines
    from axistwin.programs.hex_commands import command_strings, language_of, send_commands
    from axistwin.programs.keyboards import KEYBOARDS, to_codes, to_glyphs
    from axistwin.programs.running import Outcome, load, options
else:
    __getattr__ = lazy(
        __name__,
        command_lines="read_command_lines run_until_quiet send_lines",
        hex_commands="command_strings language_of send_commands",
        keyboards="KEYBOARDS to_codes to_glyphs",
        running="Outcome load options",
    )

__all__ = [
    "KEYBOARDS", "Outcome", "command_strings", "language_of", "load", "options", "read_command_lines",
    "run_until_quiet", "send_commands", "send_lines", "to_codes", "to_glyphs",
]  # fmt: skip
