"""The answers of an 1810 or 1811 beside a real one, and what goes through its bus socket."""

from collections import deque
from collections.abc import Callable, Iterator

from axistwin.controllers.compumotor.commands import COMMANDS_1811
from axistwin.controllers.compumotor.registers import Control
from axistwin.real.shadow.dialects.dialect import Dialect, Reading, Taken
from axistwin.real.shadow.talk import Command
from axistwin.real.shadow.twin import Twin

MESSAGE = 16
POSITIONS = {0x80: 4, 0x81: 4, 0x82: 6, 0x83: 6, 0x98: 4, 0x9A: 4}  # Requests for positions, with their sizes in bytes.
ENCODER = (0x98, 0x9A)
ENCODER_GRAIN = 3.0
SOFT = (0x84, 0x85, 0x86, 0x8B, 0x8D, 0x8E, 0x8F, 0x90, 0x99, 0xE2)
MOVING = 0x8C
ENDS = (0xA4, 0xA5)
STARTS = frozenset((*range(0x32, 0x38), 0x39, 0x3A, 0x40, 0x41, 0x42, 0x48))
STICK_OFF, STICK_ON, STICK, DEFINE = 0x10, 0x11, 0x95, 0x2E
SILENT = (0x91, 0x92)  # Requests with no message, or several.
LIMITS, HOME, TRIGGERS, STATUS, SLIP, OUTPUTS = 0x89, 0x8A, 0x94, 0x88, 0x9B, 0x97
SIDES = {"cw_limit": (0x01, 0xF0), "ccw_limit": (0x02, 0x0F)}  # The bits of each limit in 88h and in 89h.


class Compumotor(Dialect):
    """Messages of 16 bytes, which begin with the opcode of their request."""

    message_size = MESSAGE
    stop = b"\x78"

    def __init__(self, twin: Twin) -> None:
        super().__init__(twin)
        self._opcodes = {int(command.code): command for command in COMMANDS_1811}

    def commands(self, data: bytes) -> Iterator[Command]:
        """`data` is one whole command."""
        code = data[0] if data else 0
        found = self._opcodes.get(code)
        asked = found is not None and (0x80 <= code <= 0x9F or code in (0x01, 0xE2, 0xFD)) and code not in SILENT
        if code in (STICK_OFF, STICK_ON):
            self.machine_positions = code == STICK_ON
        section = "" if found is None else found.chapter
        words = data[:12].hex(" ").upper()
        yield Command(_name(data), section, data, answers=int(asked), starts=code in STARTS, words=words)

    def show(self, data: bytes) -> str:
        return data.rstrip(b"\0").hex(" ").upper() or "00"

    def read(self, command: Command | None, data: bytes) -> Reading:  # noqa: ARG002  # the message names its request
        code = data[0] if data else 0
        if code in POSITIONS:
            number = int.from_bytes(data[1 : 1 + POSITIONS[code]], "big", signed=True)
            encoder = code in ENCODER
            grain = ENCODER_GRAIN if encoder else 0.0
            rest = data[1 + POSITIONS[code] :]
            return Reading(rest, position=number, grain=grain, moving_grain=grain + 2, encoder=encoder)
        if code == MOVING:
            return Reading((data[1] in (0x00, 0xFF), data[2:]), busy=bool(data[1]))
        if code == STATUS:
            return Reading((data[1] & 0x07, data[2:]), busy=bool(data[1] & 0x10))
        if code in ENDS:
            return Reading(data, busy=False)
        return Reading(data, soft=code in SOFT)

    def take(self, command: Command, machine: bytes, twin: bytes) -> list[Taken]:  # noqa: ARG002
        code = machine[0]
        if code != twin[0]:
            return []
        theirs, changed = machine[1], machine[1] ^ twin[1]
        if code in (LIMITS, STATUS):
            found = [
                taken for side in SIDES for taken in self._limit(side, SIDES[side][code == LIMITS], changed, theirs)
            ]
            if code == STATUS and changed & 0x04:
                found += self._pin("home", not self.twin.level("home"))
            return found
        if code == HOME and changed:
            return self._pin("home", not self.twin.level("home"))
        if code == TRIGGERS:
            bits = [number for number in range(2, 6) if changed >> number & 1]
            return [it for n in bits for it in self._pin(f"trigger{n}", bool(theirs >> n & 1))]
        if code == STICK:
            return [Taken("the joystick's position is the machine's own", "joystick")]
        if code == SLIP and theirs and not twin[1]:
            return [Taken("the machine reports a stall", "slip", fault=True)]
        return []

    def _limit(self, pin: str, mask: int, changed: int, theirs: int) -> Iterator[Taken]:
        if changed & mask:
            active = bool(theirs & mask)
            self.twin.drive(pin, active)
            yield Taken(f"the machine says {pin} is {'active' if active else 'clear'}", pin, stops=active)

    def _pin(self, pin: str, level: bool) -> list[Taken]:
        self.twin.drive(pin, level)
        return [Taken(f"the machine says {pin} {'high' if level else 'low'}", pin)]

    def set_position(self, command: Command, position: int) -> bool:
        if command.name != "83h" or self.machine_positions or self.twin.busy or not self.twin.idle:
            return False
        self.twin.private(bytes((DEFINE,)) + position.to_bytes(6, "big", signed=True)[-4:])
        return True


def _name(data: bytes) -> str:
    code = data[0] if data else 0
    return f"{code:02X}h {data[1]:02X}" if code == 0x91 and len(data) > 1 else f"{code:02X}h"


NOBODY = b"ff"  # Status byte that a host reads while no board drives the bus.


class BusTalk:
    """Cuts the requests and answers of a bus socket into whole commands and messages."""

    def __init__(
        self, command: Callable[[bytes], object], message: Callable[[bytes], object],
        absent: Callable[[], object] = lambda: None,
    ) -> None:  # fmt: skip
        self._command, self._message, self._absent = command, message, absent
        self._host, self._board = b"", b""
        self._asked: deque[str] = deque(maxlen=64)  # For each request without an answer: the register that it reads.
        self._written, self._read = bytearray(), bytearray()

    def host(self, data: bytes) -> None:
        *lines, self._host = (self._host + data).split(b"\n")
        self._host = self._host[-1024:]
        for line in lines:
            self._request(line.decode("ascii", "replace").split())

    def board(self, data: bytes) -> None:
        *lines, self._board = (self._board + data).split(b"\n")
        self._board = self._board[-1024:]
        for line in filter(None, map(bytes.strip, lines)):
            if not line.startswith(b"!"):
                self._answer(line)

    def _request(self, words: list[str]) -> None:
        if not words:
            return
        self._asked.append(words[1] if words[0] == "r" and len(words) > 1 else "")
        try:
            values = bytes(int(word, 16) for word in words[2:]) if words[0] == "w" else b""
        except ValueError:
            return
        if words[:2] == ["w", "0"]:
            self._written += values
        elif words[:2] == ["w", "1"]:
            self._control(values)

    def _control(self, values: bytes) -> None:
        for value in values:
            if value & Control.RESET:
                self._written.clear()
            elif value & Control.COMMAND_READY:
                command = bytes(self._written[:MESSAGE])
                self._written.clear()
                self._command(command)
            if value & Control.MESSAGE_TAKEN:
                self._read.clear()

    def _answer(self, line: bytes) -> None:
        register = self._asked.popleft() if self._asked else ""
        if register == "1" and line.lower() == NOBODY:
            self._absent()
        if register != "0":
            return
        try:
            self._read += bytes.fromhex(line.decode("ascii"))
        except (ValueError, UnicodeDecodeError):
            return
        if len(self._read) >= MESSAGE:
            message = bytes(self._read[:MESSAGE])
            self._read.clear()
            self._message(message)
