r"""Codecs: convert data to readable text and back.

Characters on a serial line: printable text, and `\r`, `\n`, `\\` or `\xNN` for the rest.
Commands and messages on a bus: hex.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from axistwin.bench import rules
from axistwin.bench.typography import refuse
from axistwin.controllers.product import Language, Product
from axistwin.core.errors import ProgramError

_SHOWN = [chr(byte) if 0x20 <= byte < 0x7F else f"\\x{byte:02X}" for byte in range(256)]
_SHOWN[ord("\r")], _SHOWN[ord("\n")], _SHOWN[ord("\\")] = r"\r", r"\n", r"\\"
_BLANK = r"\x20"
_MEANT = {"r": b"\r", "n": b"\n", "\\": b"\\"}
_WRITTEN = re.compile(r"\\x[0-9A-Fa-f]{2}|\\.|.")
_ESCAPE = re.compile(r"\\(?:x(?P<hex>[0-9A-Fa-f]{2})|(?P<letter>.?))", re.DOTALL)

NAMES = {
    0x00: "NUL", 0x07: "BEL", 0x08: "BS", 0x09: "TAB", 0x0A: "LF", 0x0D: "CR", 0x11: "XON", 0x13: "XOFF", 0x1B: "ESC",
    0x7F: "DEL",
}  # fmt: skip
"""Names of control characters as in the manuals: `<CR>`."""


class Characters:
    """Codec for RS232 characters, which become printable text."""

    def show(self, data: bytes) -> str:
        """Return bytes as text; spaces at the start and at the end are escaped."""
        text = "".join([_SHOWN[byte] for byte in data])
        middle = text.strip(" ")
        before = len(text) - len(text.lstrip(" "))
        return _BLANK * before + middle + _BLANK * (len(text) - len(middle) - before)

    def read(self, text: str) -> bytes:
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
                refuse(text)
                raise ProgramError(
                    rf"{text[at]!r} is not a printable ASCII character: write \xNN with two hex digits, e.g. \x1B",
                    column=at + 1,
                    code=rules.NO_ASCII.code,
                )
        return bytes(out)

    hear = read

    def places(self, text: str) -> Iterator[tuple[int, int]]:
        return ((found.start(), len(found[0])) for found in _WRITTEN.finditer(text))

    def words(self, data: bytes, by_host: bool) -> str:  # noqa: ARG002
        return ""


@dataclass(frozen=True)
class Hex:
    """Converts commands and messages on a bus to hex and back; a command can also be written by its name."""

    language: Language

    def show(self, data: bytes) -> str:
        return data.hex(" ").upper()

    def read(self, text: str) -> bytes:
        refuse(text)
        return self.language.read(text)

    def hear(self, text: str) -> bytes:
        """Convert a message in hex to bytes.  If bytes are missing at the end, append zero bytes."""
        refuse(text)
        return self.language.message(text)

    def places(self, text: str) -> Iterator[tuple[int, int]]:
        return ((placed.column, placed.width) for placed in self.language.placed(text))

    def words(self, data: bytes, by_host: bool) -> str:
        return self.language.explain(data) if by_host else self.language.explain_message(data)


def _escaped(escape: re.Match[str], at: int) -> bytes:
    if escape["hex"] is not None:
        return bytes.fromhex(escape["hex"])
    try:
        return _MEANT[escape["letter"]]
    except KeyError:
        raise ProgramError(
            rf"{escape.group()} is not an escape sequence: expected \r, \n, \\ or \xNN with two hex digits",
            column=at + 1, code=rules.NO_ESCAPE.code, width=len(escape.group()),
        ) from None  # fmt: skip


Codec = Characters | Hex
CHARACTERS = Characters()


def unpadded(message: bytes) -> bytes:
    """Remove the zero bytes at the end of a board's message.  `Codec.hear` appends the zero bytes again."""
    return message.rstrip(b"\0") or message[:1]


def codec_of(product: Product) -> Codec:
    return CHARACTERS if product.language is None else Hex(product.language)


def word(byte: int) -> str:
    return chr(byte) if 0x20 <= byte < 0x7F else f"<{NAMES.get(byte) or f'{byte:02X}'}>"


def show_controls(text: str) -> str:
    """Replace the control characters in a text by their names; a text of one space becomes `<SP>`."""
    return "<SP>" if text == " " else "".join(word(ord(c)) if ord(c) < 0x80 else c for c in text)
