"""The terminal of `axistwin term`: its screen, its commands, and its connection to a controller or a port."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.terminal.commands import LocalCommands
    from axistwin.terminal.editor import LineEditor, Words, history, meaning_of
    from axistwin.terminal.screen import Screen
    from axistwin.terminal.virtual import SerialEnd
else:
    __getattr__ = lazy(
        __name__,
        commands="LocalCommands",
        editor="LineEditor Words history meaning_of",
        screen="Screen",
        virtual="SerialEnd",
    )

__all__ = ["LineEditor", "LocalCommands", "Screen", "SerialEnd", "Words", "history", "meaning_of"]
