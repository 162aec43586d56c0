"""Documents of an editor: their text, and places in the text.

In the protocol, columns are in UTF-16 units and the first line is 0.
"""

from pathlib import Path

from lsprotocol import types as lsp
from pygls.workspace import TextDocument

from axistwin.scenes.diagnostics.checking import product_for
from axistwin.ui.editor.answers import Editing
from axistwin.ui.editor.compumotor import Commands
from axistwin.ui.editor.digiplan import CommandLines
from axistwin.ui.editor.scene import Scenes
from axistwin.ui.editor.smartmotor import SourceEditing
from axistwin.ui.editor.talk import Conversations

LIMIT = 1 << 17  # Largest number of characters of a text that is checked while the user types.
_ODD_ENDS = str.maketrans(dict.fromkeys("\x0b\x0c\x1c\x1d\x1e\x85\u2028\u2029", " "))
"""Characters that end a line in Python but not in the protocol."""


class Text:
    """A document that is open in the editor.  Its text may contain changes that the user has not saved yet."""

    def __init__(self, document: TextDocument) -> None:
        self.document = document
        self.path = Path(document.path or document.uri)
        self.suffix = self.path.suffix.lower()
        try:
            self.text = document.source.translate(_ODD_ENDS)
        except (OSError, UnicodeDecodeError):  # If the file of a closed document cannot be read, use an empty text.
            self.text = ""
        self.lines = self.text.splitlines() or [""]
        if self.text.endswith(("\n", "\r")):
            self.lines.append("")

    @property
    def editing(self) -> Editing | None:
        """Help for the document's file type; None for an unknown type, or if the text is too long."""
        if self.too_long:
            return None
        match self.suffix:
            case ".if1":
                return CommandLines()
            case ".181x":
                return Commands(product_for(".181x", self.text))
            case ".sms":
                return SourceEditing()
            case ".talk":
                return Conversations()
            case ".toml":
                return Scenes()
        return None

    @property
    def too_long(self) -> bool:
        return len(self.text) > LIMIT

    def position(self, line: int, column: int) -> lsp.Position:
        """Convert a line and a column, both from 1, to a `Position` of the Language Server Protocol."""
        here = lsp.Position(min(line, len(self.lines)) - 1, column - 1)
        if self.lines[here.line].isascii():
            return here  # In a line of ASCII text, column numbers are the same in UTF-8 and UTF-16.
        return self.document.position_codec.position_to_client_units(self.lines, here)

    def span(self, begin: tuple[int, int], end: tuple[int, int]) -> lsp.Range:
        """Convert start and end, pairs of line and column from 1, to a range of the protocol."""
        return lsp.Range(self.position(*begin), self.position(*end))

    def at(self, position: lsp.Position) -> tuple[int, int]:
        """Return the line, from 1, and the character index, from 0, of an editor's position."""
        here = self.document.position_codec.position_from_client_units(self.lines, position)
        line = min(here.line, len(self.lines) - 1)
        return line + 1, min(here.character, len(self.lines[line]))
