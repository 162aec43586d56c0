"""Explains the commands and the replies of an 1810 or 1811 to the user."""

import re
from collections.abc import Iterator

from axistwin.controllers.compumotor.checker.texts import LAYOUTS, name_of
from axistwin.controllers.compumotor.language import Opcode
from axistwin.scenes.reasons.compumotor import CompumotorReasons
from axistwin.ui.teaching.guide import Guide, Term, described

_HEX = re.compile(r"(?:[0-9A-Fa-f]{2}\s*)+")
MOVE_STATUS, POSITION_REQUEST = 0x88, 0x83


class CompumotorGuide(CompumotorReasons, Guide):
    """Explains an 1810 or 1811."""

    def answer(self, request: bytes, reply: bytes) -> str:  # noqa: ARG002  # each message contains its opcode
        """Return an explanation of the bits in an answer to request 88h; "" for any other message."""
        return self.bits("move", reply[1], "at rest, no limit, not at home") if reply[0] == MOVE_STATUS else ""

    def number(self, value: int) -> Iterator[str]:
        """Yield the two possible meanings of a byte: a status byte, or an answer to request 88h (move status)."""
        if 0 <= value <= 0xFF:
            yield f"status byte: {self.bits('status', value)}"
            yield f"answer to 88h: {self.bits('move', value)}"

    def command(self, text: str) -> Iterator[str]:
        """Yield the meaning of a name or hex `text`, e.g. "88", which can also be a message of the board."""
        commands, language = self.controller.product.commands, self.controller.product.language
        assert language is not None, "a board has a language"
        if not _HEX.fullmatch(text):
            named = [each for each in commands if isinstance(each, Opcode) and name_of(each) == text.split()[0]]
            yield from map(described, named)
            return
        data = bytes.fromhex(text)
        found = commands.get(data[0])
        if not isinstance(found, Opcode):
            return
        yield described(found)
        if LAYOUTS.get(data[0]) and len(data) > 1:
            yield f"as a message: {language.explain_message(data.ljust(16, bytes(1)))}"
            yield from self._fields(data)
        elif data[0] == MOVE_STATUS and len(data) > 1:
            yield f"as a message: {self.bits('move', data[1])}"
        elif len(data) > 1:
            yield f"as a command: {language.explain(data)}"

    @staticmethod
    def _fields(data: bytes) -> Iterator[str]:
        yield f"  {data[:1].hex().upper()}: the request that the board answers"
        at = 1
        for field in LAYOUTS[data[0]]:
            part = data[at : at + field.size].ljust(field.size, b"\0")
            value = int.from_bytes(part, "big", signed=field.signed)
            yield f"  {part.hex(' ').upper()}: {field.name} {value} {field.unit}".rstrip()
            at += field.size
        if any(data[at:]) or len(data) > at:
            yield f"  {data[at:].hex(' ').upper()}: fills the message up to 16 bytes"

    def words(self) -> list[Term]:
        opcodes = (each for each in self.controller.product.commands if isinstance(each, Opcode))
        return [Term(name_of(each), f"{each.opcode:02X}h {each.name}", each.syntax) for each in opcodes]
