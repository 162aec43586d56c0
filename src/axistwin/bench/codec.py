r"""How what is said is shown to people.

Characters on a serial line: printable text, and `\r \n \\ \xNN` for the rest.  Commands and messages on a bus: hex.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from axistwin.bench import rules
from axistwin.controllers.product import Language, Product
from axistwin.errors import ProgramError

_SHOWN = {ord("\r"): r"\r", ord("\n"): r"\n", ord("\\"): r"\\"}
_BLANK = r"\x20"
_MEANT = {"r": b"\r", "n": b"\n", "\\": b"\\"}
_WRITTEN = re.compile(r"\\x[0-9A-Fa-f]{2}|\\.|.")  # one character, once it has been read
_ESCAPE = re.compile(r"\\(?:x(?P<hex>[0-9A-Fa-f]{2})|(?P<letter>.?))", re.DOTALL)


class Codec(Protocol):
    """How a family's messages stand in a line of text."""

    def show(self, data: bytes) -> str:
        """Bytes as text."""

    def read(self, text: str) -> bytes:
        """What a host says, as bytes.  Raises ProgramError with the column."""

    def hear(self, text: str) -> bytes:
        """What a controller says, as bytes.  Raises ProgramError with the column."""

    def places(self, text: str) -> Iterator[tuple[int, int]]:
        """The column from 0 of each byte that a host says, and how many columns it takes up."""

    def words(self, data: bytes, by_host: bool) -> str:
        """What it means, if that cannot be seen."""


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
                message = rf"{text[at]!r} is no printable ASCII character: write \xNN"
                raise ProgramError(message, column=at + 1, code=rules.NO_ASCII.code)
        return bytes(out)

    hear = read

    def places(self, text: str) -> Iterator[tuple[int, int]]:
        """Where each character is written."""
        return ((found.start(), len(found[0])) for found in _WRITTEN.finditer(text))

    def words(self, data: bytes, by_host: bool) -> str:  # noqa: ARG002
        """Characters speak for themselves."""
        return ""


@dataclass(frozen=True)
class Hex:
    """Commands and messages of a board on a bus, one on a line; a command also by its name."""

    language: Language

    def show(self, data: bytes) -> str:
        """Two hex digits for each byte."""
        return data.hex(" ").upper()

    def read(self, text: str) -> bytes:
        """A command."""
        return self.language.read(text)

    def hear(self, text: str) -> bytes:
        """A message; zeros at its end need not be written."""
        return self.language.message(text)

    def places(self, text: str) -> Iterator[tuple[int, int]]:
        """Where each byte is written."""
        return ((placed.column, placed.width) for placed in self.language.placed(text))

    def words(self, data: bytes, by_host: bool) -> str:
        """The command or message in words."""
        return self.language.explain(data) if by_host else self.language.explain_message(data)


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
            rf"{escape.group()} means nothing: there are \r, \n, \\ and \xNN (two hex digits)",
            column=at + 1,
            code=rules.NO_ESCAPE.code,
            width=len(escape.group()),
        ) from None


CHARACTERS = Characters()


def codec_of(product: Product) -> Codec:
    """How what is said to and by this product is written."""
    return CHARACTERS if product.language is None else Hex(product.language)
