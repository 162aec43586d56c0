"""Protocol core of Animatics SmartMotors with firmware 4.76: one motor, a daisy chain, or an RS485 line."""

import re
from collections.abc import Iterable, Sequence

from axistwin.drivers.arguments import ascii_text, integer, items
from axistwin.drivers.axis import Fault, Status
from axistwin.drivers.core import BOTH_LIMITS, AxisCore, Core, Line, shown
from axistwin.drivers.errors import RefusedError, SilentError, WrongAnswerError
from axistwin.drivers.steps import Pause, Procedure, Write

SAMPLE_S = 245.76e-6
SCALE = 65536
TRAJECTORY, RIGHT, LEFT, INDEX, WRAP, ERROR, HEAT, OFF = 1, 2, 4, 8, 16, 32, 64, 128
AT_INDEX, NOW_RIGHT, NOW_LEFT, SYNTAX, CURRENT, PROGRAM = 256, 512, 1024, 8192, 16384, 32768
LEAVE_LIMIT = "call clear_faults, move away from the limit, then call clear_faults again"
FAULTS = {
    RIGHT: Fault("positive limit", LEAVE_LIMIT),
    LEFT: Fault("negative limit", LEAVE_LIMIT),
    WRAP: Fault("position wrap", "call clear_faults and set_position"),
    ERROR: Fault("position error", "remove the load that blocks the shaft, then call clear_faults"),
    HEAT: Fault("overheat", "let the motor cool down, then call clear_faults"),
    CURRENT: Fault("over-current", "check the load, then call clear_faults"),
    PROGRAM: Fault("stored program", "load the program again"),
}
MOTION = re.compile(r"G|X|S|Z|END|OFF|RUN\??|M[CDFST]\S*|O=\S*|GO(?:SUB|TO)\S*")
"""Commands that begin or end a motion, or define the position."""
ACKNOWLEDGE, END = b"\x06", b"\xff\xff"
ALL = 0
"""Address byte that selects all motors of a line."""


class SmartMotors(Core):
    """One motor with the axis `shaft`, or the motors of a line with the axes `shaft1` and so on.

    `addresses`: the addresses of the motors on a daisy chain or an RS485 line; () for one motor without an address.
    `chain`: give the motors of an RS232 daisy chain their addresses, in this order, if they do not answer.  `limits`:
    the limit switches are wired to pins C and D; False makes these pins inputs.  `rs485`: the line has one pair of
    wires, on which a motor must not answer while the host sends.
    """

    line = Line(9600)

    def __init__(
        self, timeout: float = 0.5, *, addresses: Sequence[int] = (), chain: bool = True, limits: bool = False,
        rs485: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(timeout)
        given = [integer("address", address, 1, 120) for address in items("addresses", addresses, "[1, 2]")]
        if len(set(given)) < len(given):
            raise RefusedError(f"invalid addresses {given}: expected different numbers, e.g. [1, 2]")
        self.addresses, self.chain, self.limits, self.rs485 = tuple(given), chain and not rs485, limits, rs485
        self.echo = False
        self._shafts = [Shaft(self, address) for address in self.addresses or (None,)]
        self.axes = {shaft.name: shaft for shaft in self._shafts}

    def shaft(self, name: str | None = None) -> "Shaft":
        """Return the axis with this name, or the first axis if no name is given."""
        for shaft in self._shafts:
            if name in (None, shaft.name):
                return shaft
        raise RefusedError(f"no axis {name!r}: expected one of {', '.join(self.axes)}")

    # Synchronisation of the driver with the motors

    def synchronise(self) -> Procedure[None]:
        """Find each motor, and restore the settings of motors whose power was cut."""
        yield from self._discard(0.0)
        first, *_ = self._shafts
        found = yield from self._find(first)
        if not found and self.addresses and self.chain:
            yield from self._address_chain()
            found = yield from self._find(first)
        for shaft in self._shafts:
            if not (found if shaft is first else (yield from self._find(shaft))):
                raise SilentError(
                    f"no answer from {shaft.name} to RSP: check the port, the cable and the baud rate, "
                    "and the motor's power and address"
                )
            yield from shaft.prepare()

    def _find(self, shaft: "Shaft") -> Procedure[bool]:
        """Return True if the motor answers, and set `echo` if it echoes received characters."""
        for _ in range(2):
            # Try twice, because an incomplete command in the buffer of the motor spoils the first request.
            yield Write(b"\r" + shaft.prefix + b"RSP\r")
            answer = yield from self._discard(min(self.timeout, 0.3))
            *before, last = answer.rstrip(b"\r").split(b"\r")
            period, slash, version = last.rpartition(b"/")
            if slash and period[-5:].isdigit() and version:
                self.echo = any(part.endswith(b"RSP") for part in before)
                return True
            if answer and not answer.rstrip(b"\r").endswith(b"RSP"):
                raise WrongAnswerError(
                    f"the answer to RSP is {shown(answer)}: expected a sample period and a version, e.g. 24576/476"
                )
        return False

    def _address_chain(self) -> Procedure[None]:
        everybody = bytes([0x80 + ALL])
        for address in self.addresses:
            mine = bytes([0x80 + address])
            for command in (everybody + b"SADDR%d\r" % address, mine + b"ECHO\r", mine + b"SLEEP\r"):
                yield Write(command)
                yield from self._discard(0.05)
        yield Write(everybody + b"WAKE\r")
        yield from self._discard(0.05)

    # Sending commands and reading reports

    def send(self, prefix: bytes, text: str) -> Procedure[None]:
        """Send commands to a motor, and check the echo if the motor echoes."""
        data = prefix + text.encode("ascii") + b"\r"
        yield Write(data)
        if self.echo and (echo := (yield from self._take(len(data), text))) != data:
            raise WrongAnswerError(
                f"the motor returned the wrong echo {shown(echo)} for {text}: check the line for noise or a second host"
            )

    @property
    def one_by_one(self) -> bool:
        """True if the driver must wait for each answer before the next request."""
        return self.echo or self.rs485

    def ask(self, prefix: bytes, *reports: str) -> Procedure[list[str]]:
        """Send report commands to a motor and return the answers."""
        found = b""
        for lines in [[report] for report in reports] if self.one_by_one else [reports]:
            yield from self.send(prefix, " ".join(lines))
            for line in lines:
                found += (yield from self._until(b"\r", line)) + b"\r"
        return found.decode("ascii", "replace").split("\r")[:-1]

    def command(self, text: str, axis: str | None = None) -> Procedure[None]:
        """Send commands to a motor, e.g. "UA=1 UAO".  Raises RefusedError for an invalid command."""
        shaft = self.shaft(axis)
        ascii_text("command", text, "UA=1 UAO")
        if any(map(MOTION.fullmatch, text.split())):
            shaft._aim(None)
        yield from self.send(shaft.prefix, text)
        if (yield from self.number("RBs", axis)):
            yield from self.send(shaft.prefix, "Zs")
            raise RefusedError(f"the motor refused {text!r}: expected valid commands, e.g. UA=1 UAO")

    def number(self, text: str, axis: str | None = None) -> Procedure[int]:
        """Send a report command, e.g. "RTEMP", and return the number in the answer."""
        (answer,) = yield from self.ask(self.shaft(axis).prefix, ascii_text("report", text, "RTEMP"))
        return whole(answer, text)

    # Functions that only a SmartMotor has

    def outputs(self, axis: str | None = None, **levels: bool) -> Procedure[None]:
        """Configure pins as outputs, and set the levels of these pins, e.g. `outputs(A=True)`."""
        for pin, level in levels.items():
            yield from self.command(f"U{pin}={bool(level):d} U{pin}O", axis)

    def inputs(self, axis: str | None = None) -> Procedure[dict[str, bool]]:
        """Return the levels of pins A to G."""
        bits = yield from self.number("RU", axis)
        return {pin: bool(bits >> number & 1) for number, pin in enumerate("ABCDEFG")}

    def cam(self, table: Sequence[int], base: int, axis: str | None = None) -> Procedure[None]:
        """Store a cam table in the motor, and begin to follow the master encoder.

        `base`: counts of the master encoder for the whole table.
        """
        words = [integer("point", point, -(2**15), 2**15 - 1) for point in items("table", table, "[0, 100, 0]")]
        integer("length of the table", len(words), 1, 102)
        base = integer("base", base, 1, 2**31 - 1)
        for begin in range(0, len(words), 8):
            part = " ".join(map(str, words[begin : begin + 8]))
            yield from self.command(f"aw[{begin}] {part}.", axis)
        yield from self.command(f"BASE={base} SIZE={len(words)} MC G", axis)

    def load(self, source: str, axis: str | None = None) -> Procedure[None]:
        """Store the source text of a program in a motor; `command("RUN")` starts the program."""
        shaft = self.shaft(axis)
        data = ascii_text("program", source, "'a=1 END'").replace("\r\n", "\n").encode()
        yield from self._discard(0.0)
        yield Write(shaft.prefix + b"LOAD ")
        yield from self._acknowledged()
        for begin in range(0, len(data), 8):
            block = data[begin : begin + 8]
            yield Write(block)
            if len(block) == 8:
                yield from self._acknowledged()
        yield Write(END + b" ")
        yield from self._discard(0.1)
        if (yield from self.number("RBk", axis)):
            raise RefusedError("the motor did not store the program: load the program again")

    def _acknowledged(self) -> Procedure[None]:
        yield from self._until(ACKNOWLEDGE, "LOAD")

    def program(self, axis: str | None = None) -> Procedure[str]:
        """Return the source text of the program that a motor has stored."""
        shaft = self.shaft(axis)
        yield Write(shaft.prefix + b"UPLOAD\r")
        text = b""
        while not text.endswith(b"\xff"):
            part = yield from self._discard(0.1)
            if not part:
                raise SilentError(
                    "the motor did not send its complete program: "
                    "check the cable, and check whether the command LOCKP has locked the program"
                )
            text += part
            if not text.endswith(b"\xff"):
                yield Write(ACKNOWLEDGE)
        return text.removeprefix(shaft.prefix + b"UPLOAD\r").rstrip(b"\xff").decode("ascii", "replace")

    def stream(self, points: Iterable[tuple[int, int]], axis: str | None = None) -> Procedure[None]:
        """Send at most 16 points (clock value, position) of a path, and begin the motion (host mode)."""
        shaft = self.shaft(axis)
        pairs = [items("point", point, "(256, 100)", 2) for point in items("points", points, "[(256, 100)]")]
        path = [
            (integer("clock", clock, 0, 2**32 - 1), integer("position", position, -(2**31), 2**31 - 1))
            for clock, position in pairs
        ]
        _, word = yield from shaft._state()
        shaft._aim(None)
        if path:  # where the mode after host mode finds its target, so that the motion ends
            yield from self.send(shaft.prefix, f"MP V={abs(shaft._speed(shaft.velocity))} P={path[-1][1]}")
        yield from self.send(shaft.prefix, "MD")
        for clock, position in path:
            yield Write(b"\xfa" + position.to_bytes(4, "big", signed=True) + b"\r")
            yield Write(b"\xfb" + clock.to_bytes(4, "big") + b"\r")
        if self.echo:
            yield from self._discard(0.05)
        yield from self.send(shaft.prefix, "G")
        shaft._aim(path[-1][1] if path else None, faults=shaft._faults(word))


class Shaft(AxisCore):
    """The axis of a SmartMotor, with positions in encoder counts."""

    def __init__(self, line: SmartMotors, address: int | None) -> None:
        super().__init__("shaft" if address is None else f"shaft{address}", velocity=4000.0, acceleration=20_000.0)
        self.max_velocity = 300_000.0
        self.prefix = b"" if address is None else bytes([0x80 + address])
        self._line, self._set_acceleration, self._homing, self._lost = line, 0, 0, ""
        self._setting = 0
        """Acceleration that is being set; 0 if none is.  Without an answer, the motor may have it or not."""

    def _aim(self, target: int | None, *, seeking: bool = False, faults: tuple[Fault, ...] = ()) -> None:
        super()._aim(target, seeking=seeking, faults=faults)
        self._homing = 0

    def prepare(self) -> Procedure[None]:
        """Restore the settings that the motor has lost in a power cut."""
        _, _, acceleration = yield from self._read()
        if self._setting:
            if acceleration not in (self._set_acceleration, self._setting):
                acceleration = 0  # the power was cut
            self._set_acceleration, self._setting = acceleration or self._set_acceleration, 0
        if self._set_acceleration and acceleration:
            return
        if self._set_acceleration:
            self._lost, self._homing = f"the power of {self.name} was cut", 0
        pins = "UCP UDM" if self._line.limits else "UCI UDI"
        if not acceleration:
            yield from self._line.send(self.prefix, f"{pins} ZS")
        elif self._line.limits:
            yield from self._line.send(self.prefix, pins)
        self._set_acceleration = max(acceleration, self._units())
        yield from self._line.send(self.prefix, f"A={self._set_acceleration}")
        yield from self._read()  # the motor has received it

    def _units(self) -> int:
        return max(round(self.acceleration * SCALE * SAMPLE_S**2), 2)

    def _speed(self, velocity: float) -> int:
        if not abs(velocity) <= self.max_velocity:
            raise RefusedError(f"velocity {velocity:g} counts/s: expected at most {self.max_velocity:g} counts/s")
        return round(velocity * SCALE * SAMPLE_S)

    def _read(self) -> Procedure[tuple[int, int, int]]:
        first, second = yield from self._line.ask(self.prefix, "RPW", "RA")
        position, _, word = first.partition(",")
        return whole(position, "RPW"), whole(word, "RPW"), whole(second, "RA")

    def _state(self) -> Procedure[tuple[int, int]]:
        """Return position and status word; detect a power cut."""
        position, word, acceleration = yield from self._read()
        if not acceleration:
            yield from self.prepare()
            position, word, _ = yield from self._read()
        return position, word

    def _go(self, text: str, target: int | None) -> Procedure[None]:
        _, word = yield from self._state()
        if self._lost and target is not None:
            Status(0, 0, 0, False, lost=self._lost).known_position()
        yield from self._set_profile()
        self._aim(target, faults=self._faults(word))
        yield from self._line.send(self.prefix, f"{text} G")
        position, word = yield from self._state()
        if not word & TRAJECTORY and position != target and (faults := self._faults(word)):
            self._aim(None)
            if word & NOW_RIGHT and word & NOW_LEFT:
                raise RefusedError(f"{BOTH_LIMITS}; without switches, call command('UCI UDI') before")
            raise RefusedError(f"{self.name} does not move because of faults: {'; '.join(map(str, faults))}")

    def _set_profile(self) -> Procedure[None]:
        """Send the acceleration, unless the motor has it, as a difference that reveals a power cut.

        `A=A+50` changes 100 to 150, but 0, the value after a power cut, to 50: neither the old nor the new one, even if
        only a part has arrived.  Twice the old value is increased by 1, because `A=A+100` would change 0 to the old
        value, 100.
        """
        before, units = self._set_acceleration, self._units()
        if units == before:
            return
        if units == 2 * before:
            units += 1
        self._setting = units
        (found,) = yield from self._line.ask(self.prefix, f"A=A{units - before:+} RA")
        self._setting = 0
        if whole(found, "RA") != units:
            yield from self._line.send(self.prefix, "A=0")
            yield from self.prepare()
            raise RefusedError(
                f"the position of {self.name} is lost, because {self._lost}: "
                "home the axis, or call set_position, then repeat the motion"
            )
        self._set_acceleration = units

    def move_to(self, target: int) -> Procedure[None]:
        """Begin a move to a position, even if a motion is in progress."""
        if not -(2**31) <= target < 2**31:
            raise RefusedError(f"position {target}: expected -2147483648 to 2147483647 counts")
        yield from self._go(f"MP V={abs(self._speed(self.velocity))} P={target}", target)
        self.setpoint = target

    def move_by(self, distance: int) -> Procedure[None]:
        """Begin a move relative to the last target; after a stop relative to the present position."""
        _, word = yield from self._state()
        base = self.setpoint if word & TRAJECTORY else (yield from self._state())[0]
        yield from self.move_to(base + distance)

    def move_at(self, velocity: float) -> Procedure[None]:
        yield from self._go(f"MV V={self._speed(velocity)}", None)

    def stop(self) -> Procedure[None]:
        yield from self._end("X")

    def abort(self) -> Procedure[None]:
        """Stop the trajectory immediately."""
        yield from self._end("S")

    def _end(self, text: str) -> Procedure[None]:
        """Send a stop command.  Then request a report, to check that the motor has received the stop command."""
        self._aim(None)
        yield from self._line.send(self.prefix, text)
        yield from self._read()

    def home(self, direction: int) -> Procedure[None]:
        """Begin a search for the encoder's index pulse, whose position becomes 0."""
        # The command RI reads the captured index position, and then arms the capture of the next index pulse.
        yield from self._line.ask(self.prefix, "RI")
        yield from self._go(f"MV V={self._speed(self.velocity) * direction}", None)
        self._homing, self._seeking = direction, True

    def status(self) -> Procedure[Status]:
        position, word = yield from self._state()
        if self._homing:
            position, word = yield from self._home_further(position, word)
        velocity = 0.0
        if word & TRAJECTORY:
            (answer,) = yield from self._line.ask(self.prefix, "RV")
            velocity = whole(answer, "RV") / (SCALE * SAMPLE_S)
        status = Status(
            position, self.setpoint, velocity, bool(word & TRAJECTORY) or bool(self._homing), False,
            bool(word & NOW_RIGHT), bool(word & NOW_LEFT), bool(word & AT_INDEX), self._faults(word), self._lost,
        )  # fmt: skip
        return self._judged(status, off=(yield from self._off_target(status)))

    def _off_target(self, status: Status) -> Procedure[float]:
        """Return how far the trajectory has ended from the target: the shaft itself may rest a little beside it."""
        off = 0.0 if self.target is None else abs(status.position - self.target)
        if status.moving or not off:
            return 0.0
        (error,) = yield from self._line.ask(self.prefix, "RPE")
        return max(off - abs(whole(error, "RPE")) - 1, 0.0)  # 1: between both readings the shaft may move by a count

    def _home_further(self, position: int, word: int) -> Procedure[tuple[int, int]]:
        """Continue a search: stop after the index pulse, then set the pulse's position to 0."""
        if not word & TRAJECTORY and not word & INDEX:
            self._homing = 0  # A limit switch or a fault has ended the search for the index pulse.
        elif word & INDEX and word & TRAJECTORY:
            yield from self._line.send(self.prefix, "X")
        elif word & INDEX:
            (index,) = yield from self._line.ask(self.prefix, "RI")
            yield from self._line.send(self.prefix, f"O=@P-{whole(index, 'RI')}".replace("--", "+"))
            self._homing, self._lost, self._seeking = 0, "", False
            position, word = yield from self._state()
            self.setpoint = position
        return position, word

    def _faults(self, word: int) -> tuple[Fault, ...]:
        return tuple(fault for bit, fault in FAULTS.items() if word & bit)

    def set_position(self, position: int) -> Procedure[None]:
        yield from self._line.send(self.prefix, f"O={position}")
        self.setpoint, self._lost = position, ""
        self._aim(None)

    def clear_faults(self) -> Procedure[None]:
        """Clear the faults whose cause has gone, and acknowledge a limit."""
        yield from self._line.send(self.prefix, "ZS")
        yield Pause(0.005)


def whole(text: str, report: str) -> int:
    """Return the number in an answer to `report`, e.g. RPW.  Raises WrongAnswerError if it is none."""
    try:
        return int(text)
    except ValueError:
        raise WrongAnswerError(
            f"the SmartMotor answered {shown(text.encode())} to the command {report}: "
            "expected a whole number, e.g. 4000"
        ) from None
