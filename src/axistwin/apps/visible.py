r"""How characters on a serial line are shown to people: printable text, and `\r \n \\ \xNN` for the rest."""

import re
from typing import Protocol

from axistwin.errors import ProgramError

_SHOWN = {ord("\r"): r"\r", ord("\n"): r"\n", ord("\\"): r"\\"}
_BLANK = r"\x20"
_MEANT = {"r": b"\r", "n": b"\n", "\\": b"\\"}
_ESCAPE = re.compile(r"\\(?:x(?P<hex>[0-9A-Fa-f]{2})|(?P<letter>.?))", re.DOTALL)


class Codec(Protocol):
    """How a family's messages stand in a line of text."""

    def show(self, data: bytes) -> str:
        """Bytes as text."""

    def read(self, text: str) -> bytes:
        """Text as bytes.  Raises ProgramError with the column."""


class Characters:
    """RS232 characters as printable text."""

    def show(self, data: bytes) -> str:
        """Bytes as text; blanks at either end are written out, as nobody sees them there."""
        text = "".join(map(_show, data))
        middle = text.strip(" ")
        before = len(text) - len(text.lstrip(" "))
        after = len(text) - len(middle) - before
        return _BLANK * before + middle + _BLANK * after

    def read(self, text: str) -> bytes:
        """Text as bytes."""
        out = bytearray()
        at = 0
        while at < len(text):
            if text[at] == "\\":
                escape = _ESCAPE.match(text, at)
                assert escape is not None
                out += _escaped(escape, at)
                at = escape.end()
            elif " " <= text[at] <= "~":
                out += text[at].encode()
                at += 1
            else:
                raise ProgramError(rf"{text[at]!r} is no printable ASCII character: write \xNN", column=at + 1)
        return bytes(out)


def _show(byte: int) -> str:
    if byte in _SHOWN:
        return _SHOWN[byte]
    return chr(byte) if 0x20 <= byte < 0x7F else f"\\x{byte:02X}"


def _escaped(escape: re.Match[str], at: int) -> bytes:
    if escape["hex"] is not None:
        return bytes.fromhex(escape["hex"])
    try:
        return _MEANT[escape["letter"]]
    except KeyError:
        raise ProgramError(
            rf"{escape.group()} means nothing: there are \r, \n, \\ and \xNN (two hex digits)", column=at + 1
        ) from None


CHARACTERS = Characters()
