"""Explains the commands and the replies of an IF1 or IF2 to the user."""

import re
from collections.abc import Iterator

from axistwin.controllers.digiplan.chapters.data_format import read_format
from axistwin.controllers.digiplan.chapters.faults import INPUT_BITS
from axistwin.scenes.reasons.digiplan import DigiplanReasons
from axistwin.ui.teaching.guide import Guide, described

_COMMAND = re.compile(r"\D[+-]?[\d,]*|.")

PARITIES = {"N": "no", "O": "odd", "E": "even"}


def _input_names(value: int) -> str:
    return ", ".join(f"{bit} {name}" for name, bit in INPUT_BITS.items() if value & bit)


class DigiplanGuide(DigiplanReasons, Guide):
    """Explains an IF1 or IF2."""

    accepted = b"(", b"U", b"V"
    single_characters = True

    def answer(self, request: bytes, reply: bytes) -> str:
        text, asked = reply.rstrip(b"\r\n").decode("latin-1"), request.strip().decode("latin-1")[-1:]
        if asked == "Q" and len(reply) == 1:
            return f"{reply[0]}: {self.bits('Q', reply[0], 'at rest, no fault')}"
        if text == "U" and not self.ready:
            return "the baud rate has been measured; now the data format is expected, e.g. U61"
        if asked in ("K", "F") and text.isdecimal():
            return self._status(asked, int(text))
        if asked == "I" and text.isdecimal():
            return self._inputs(int(text))
        return self.shown(asked, text) if asked in ("E", "N", "O") else ""

    def notes(self, line: bytes) -> Iterator[str]:
        """Yield a note about a move command that does not end with the start command `$`."""
        text = line.strip().decode("latin-1")
        if text[:1] in ("X", "Y", "Z") and not text.endswith("$"):
            yield f"nothing moves without $ at the end: type  {text}$"

    def number(self, value: int) -> Iterator[str]:
        """Yield the meanings of a number: as an answer to K, to F and to I."""
        if 0 <= value <= 0xFF:
            yield f"answer to K: {self._status('K', value)}"
            yield f"answer to F: {self._status('F', value)}"
            yield f"answer to I: {self._inputs(value)}"

    def _status(self, asked: str, value: int) -> str:
        source, none = ("Q", "at rest, no fault") if asked == "K" else ("F", "no communication fault")
        return self.bits(source, value, none)

    @staticmethod
    def _inputs(value: int) -> str:
        without = _input_names(value)
        return f"no current flows in {without}" if without else "current flows in every input"

    def command(self, text: str) -> Iterator[str]:
        seen = set()
        for piece in _COMMAND.findall(text.replace(" ", "")):
            found = self.controller.product.commands.get(piece[0])
            if found is not None and piece[0] not in seen:
                seen.add(piece[0])
                yield described(found)
                yield from self._values(piece)

    def _values(self, piece: str) -> Iterator[str]:
        match piece[0]:
            case "K" | "Q":
                yield f"answer: 0 at rest, no fault; or the sum of {self.bits('Q', 0xFF)}"
            case "F":
                yield f"answer: 0 no communication fault; or the sum of {self.bits('F', 0xFF)}"
            case "I":
                yield f"answer: the sum of the inputs without current: {_input_names(0xFF)}"
            case "E":
                yield "answer: C clear, a new command is performed at once; E busy"
            case "=":
                yield "times: how often the steps are repeated after the first time; 0: endlessly"
            case "U" | "V" if (frame := read_format(piece, ord("\r" if piece[0] == "U" else "\n"))) is not None:
                size, parity, stop_bits = frame.uart
                echo = ", echo" * frame.echo + ", X-on/X-off" * frame.x_on_x_off
                stops = f"{stop_bits} stop bit{'s' * (stop_bits > 1)}"
                yield f"{piece}: {size} data bits, {PARITIES[parity]} parity, {stops}{echo}"
