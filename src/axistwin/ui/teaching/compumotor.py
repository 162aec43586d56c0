"""Explains the commands, the replies and the state of an 1810 or 1811 to the user."""

import re
from collections.abc import Iterator

from axistwin.bench.acts import Act, Wait
from axistwin.controllers.compumotor.card import BEING_DEFINED
from axistwin.controllers.compumotor.checker.texts import LAYOUTS, name_of
from axistwin.controllers.compumotor.language import Opcode
from axistwin.controllers.compumotor.registers import Status
from axistwin.controllers.compumotor.rules import NOT_GIVEN
from axistwin.controllers.compumotor.state import INDEXER
from axistwin.core.units import S
from axistwin.ui.teaching.guide import Guide, Reason, Term, described
from axistwin.ui.teaching.remedies import at_limit

_HEX = re.compile(r"(?:[0-9A-Fa-f]{2}\s*)+")
MOVE_STATUS, POSITION_REQUEST = 0x88, 0x83
GO_RELATIVE = b"\x33\0\0\0\x01"
DEFAULTS = "default_velocity_and_acceleration 00 25000 250000"


class CompumotorGuide(Guide):
    """Explains an 1810 or 1811."""

    suggestions = (
        (DEFAULTS, "velocity and acceleration of default moves (31h)"),
        ("go_relative 25000", "one revolution of a 25000 step motor (33h)"),
        ("position_from_absolute_zero", "report the position (83h)"),
        ("move_status", "report limits, home, motion (88h)"),
        ("stop", "decelerate to a stop (70h)"),
    )

    @property
    def ready(self) -> bool:
        return bool(int(self.value("status")) & Status.INPUT_READY)

    def reasons(self) -> Iterator[Reason]:
        """Yield why the board cannot start a move; it may ignore a later remedy until the earlier ones are applied."""
        pins = self.controller.pins
        if not self.controller.powered:
            yield Reason("the power is off", self.remedies.power("on"))
            return
        if int(self.value("status")) & Status.FAILED:
            yield Reason("the board has failed (status bit 5)", self.remedies.power("off", "on"))
            return
        yield from self._sequences()
        if pins["remote_acknowledge"].level:
            yield Reason("the joystick controls the motor (11h)", "type  disable_joystick")
        if pins["shutdown"].level and not pins["shutdown_in"].level:
            yield Reason("the motor is shut down by its input (13h)", self.restored("shutdown_in", "high"))
        elif pins["shutdown"].level:
            yield Reason("the motor is shut down (12h)", "type  remote_power_shutdown off")
        reversed_ = self._reversed
        for pin, clockwise in (("cw_limit", True), ("ccw_limit", False)):
            if pins[pin].level:
                side = "plus" if clockwise is not reversed_ else "minus"
                yield Reason(
                    f"the {side} limit is active: only moves away from it begin", self._opened(pin, side, reversed_)
                )
        if int(self.value("mode")) != INDEXER:
            yield Reason(f"the board is in streaming mode {int(self.value('mode')):02X}h", "type  indexer_mode")
        elif any(found.code == NOT_GIVEN.code for found in self.refused(GO_RELATIVE)):
            yield Reason("a move needs velocity and acceleration: 31h has not been given", f"type  {DEFAULTS}")

    def _sequences(self) -> Iterator[Reason]:
        """Yield the reasons why the board stores or ignores the commands of the host."""
        if any(listing.title.endswith(BEING_DEFINED) for listing in self.controller.programs.values()):
            yield Reason("the board stores commands in a sequence (D9h)", "type  end_sequence_definition")
        if number := int(self.value("sequence")):
            yield Reason(
                f"sequence {number} is being performed, and stands at its command {self.value('command')}",
                "type  kill_sequence",
            )

    @property
    def _reversed(self) -> bool:
        """True if CCW is the plus direction (14h), as far as one active limit shows it in the bits of 88h."""
        cw, ccw = self.controller.pins["cw_limit"].level, self.controller.pins["ccw_limit"].level
        return cw is not ccw and bool(int(self.value("move")) & 1) is ccw

    def _opened(self, pin: str, side: str, reversed_: bool) -> str:
        found, other = at_limit(self.controller, pin == "cw_limit"), {"plus": "minus", "minus": "plus"}[side]
        if found is None:
            return self.restored(pin, "low")
        move = f"go_relative {-found[2] if reversed_ else found[2]}"
        return self.restored(pin, "low", away=f"the slide stands on the switch: move away in {other}: type  {move}")

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

    def initialisation(self) -> Iterator[Act]:
        """Yield an action that waits 1 s for the end of the self-test; nothing if the board is ready."""
        if not self.ready:
            yield Wait(S)

    def words(self) -> list[Term]:
        opcodes = (each for each in self.controller.product.commands if isinstance(each, Opcode))
        return [Term(name_of(each), f"{each.opcode:02X}h {each.name}", each.syntax) for each in opcodes]
