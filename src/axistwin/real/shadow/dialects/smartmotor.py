"""The answers of a SmartMotor beside a real one."""

from collections.abc import Iterator
from functools import lru_cache

from axistwin.controllers.smartmotor.language.language import read as parse
from axistwin.real.probing.smartmotor.still import report
from axistwin.real.shadow.dialects.dialect import Dialect, Reading, Taken, number
from axistwin.real.shadow.talk import Command, Words
from axistwin.real.shadow.twin import Twin

MOVING, OFF, INDEX = 0x01, 0x80, 0x100
REAL_TIME = MOVING | INDEX | 0x08
"""Bits of the status word that change by themselves: trajectory in progress, index level, index captured."""
FAULTS = {0x20: "a position error", 0x40: "overheat", 0x4000: "an over-current", 0x8000: "a damaged program"}
SIDES = {"C": 0x0202, "D": 0x0404}  # The bits of the right and of the left limit: now, and latched.
POSITION_GRAIN = 8.0  # Counts by which a servo at rest may stand off its target.
STARTS = ("G", "RUN", "GOSUBn", "GOTOn", "RUN?")
OWN = ("RCLK", "RTEMP", "RCTR", "RLEN", "RI")  # Values that no twin can know.
FREE = ("RPE", "RV")  # Values that are compared at rest only, and roughly.
FOLLOWING = ("MF", "MS")
PINS = {f"RU{pin}A": pin for pin in "ABCDEFG"} | {f"RU{pin}I": pin for pin in "ABCDEFG"}


class SmartMotor(Dialect):
    """Reports are lines; W and S contain the limits and faults that only the machine knows."""

    stop = b"S "

    def __init__(self, twin: Twin) -> None:
        super().__init__(twin)
        self._words = Words(b" \r")
        self._echo = False

    def commands(self, data: bytes) -> Iterator[Command]:
        for word in self._words.receive(data):
            text = bytes(byte for byte in word if byte < 0x80).decode("ascii").strip()
            if not text:
                continue
            code, chapter, answers = _known(text)
            if code.startswith(FOLLOWING):
                self.machine_positions = True
            elif code == "MP":
                self.machine_positions = False
            name = text if answers else code or text[:16]
            yield Command(name, chapter, word, answers=answers, starts=code in STARTS, words=text[:40])
            self._echo = {"ECHO": True, "ECHO_OFF": False}.get(code, self._echo)

    def clear(self) -> None:
        self._words.clear()

    @property
    def echo(self) -> bool:
        return False  # An echo comes without a terminator, and is compared in order with the rest.

    def read(self, command: Command | None, data: bytes) -> Reading:
        name = "" if command is None else command.name
        if name == "RPW" and (both := _both(data)):
            return self._word(both[1])._replace(position=both[0], grain=POSITION_GRAIN, moving_grain=POSITION_GRAIN)
        value = number(data)
        if value is None or not name:
            return Reading(data)
        if name == "RBt":
            return Reading(busy=bool(value))
        if name in ("RW", "RS"):
            return self._word(value)
        if name == "RP":
            return Reading(position=value, grain=POSITION_GRAIN, moving_grain=POSITION_GRAIN)
        if name in OWN or name in FREE:
            return Reading()
        return Reading(value, soft=name.startswith(("RU", "RBp", "RBm", "RMODE")))

    @staticmethod
    def _word(value: int) -> Reading:
        return Reading(value & ~REAL_TIME, busy=bool(value & MOVING))

    def take(self, command: Command, machine: bytes, twin: bytes) -> list[Taken]:
        if command.name == "RPW" and (both := _both(machine)) and (mine := _both(twin)):
            return list(self._status(both[1], both[1] ^ mine[1]))
        theirs, ours = number(machine), number(twin)
        if theirs is None or ours is None:
            return []
        if command.name in ("RW", "RS"):
            return list(self._status(theirs, theirs ^ ours))
        if command.name in PINS and {theirs, ours} == {0, 1}:
            pin = PINS[command.name]
            self.twin.drive(pin, bool(theirs))
            return [Taken(f"the machine says pin {pin} {'high' if theirs else 'low'}", pin)]
        if command.name == "RP" and self._off:
            return [Taken(f"the shaft was turned by {theirs - ours} counts while the motor was off", "shaft")]
        return []

    @property
    def _off(self) -> bool:
        value = self.twin.controller.registers["RS"].read()
        return isinstance(value, int) and bool(value & OFF)

    def _status(self, theirs: int, changed: int) -> Iterator[Taken]:
        for bit, name in FAULTS.items():
            if changed & theirs & bit:
                yield Taken(f"the machine reports {name}", name, fault=True, stops=True)
        for pin, bits in SIDES.items():
            if changed & bits:
                on = bool(theirs & changed & bits)
                self.twin.drive(pin, on)
                side = "right" if pin == "C" else "left"
                yield Taken(f"the machine says {side} limit {'open' if on else 'closed'}", f"limit {pin}", stops=on)

    def set_position(self, command: Command, position: int) -> bool:
        if command.name not in ("RP", "RPW") or self.twin.busy or not self.twin.idle:
            return False
        self.twin.private(b"O=%d\r" % position)
        return True


def _both(data: bytes) -> tuple[int, int] | None:
    """Return the position and the status word in an answer to RPW; None if these are not in it."""
    position, word = map(number, data.split(b",")) if data.count(b",") == 1 else (None, None)
    return None if position is None or word is None else (position, word)


@lru_cache(maxsize=1000)
def _known(text: str) -> tuple[str, str, int]:
    """Return the code, the chapter and the number of answers of a command."""
    command = parse(text).command
    if command is None:
        return "", "", 0
    return str(command.code), command.chapter, int(report(command))
