"""Protocol core of the Compumotor 1810 and 1811, on the text lines of a bus socket.

Each access to the board is one line: `r OFFSET [COUNT]`, `w OFFSET HH …`, `s 1` for reports of the interrupt line as `!
1`.  Offset 0: the
data buffers, 1: control and status.
"""

from collections import deque
from collections.abc import Iterable

from axistwin.drivers.axis import Fault, Status
from axistwin.drivers.core import AxisCore, Core, shown
from axistwin.drivers.errors import BusyError, RefusedError, SilentError, WrongAnswerError
from axistwin.drivers.steps import Clock, Pause, Procedure, Read, Write

COMMAND_READY, RESET, INTERRUPTS, TAKEN = 0x10, 0x20, 0x40, 0x80
MESSAGE, READY, FAILED = 0x08, 0x10, 0x20
POLL_S = 0.002
STARTUP_S = 0.1
MOVE_ID = 50
"""Number of the predefined move that `move_at` uses."""
BEGIN_S = 0.1
"""Seconds after which a motion that has not begun counts as refused; a motion begins within 20 ms."""
SEVEN, STREAM_BYTES = 7, 14
"""Velocities in one command (E1h), and their bytes in the streaming buffer."""
MOTIONS = range(0x32, 0x80)
"""Commands that begin or end a motion."""
RANGES = (1.0, 0.1, 0.01, 0.001)
NOT_FOUND = Fault("home not found", "check the home switch and home_definition, then call clear_faults")
FAIL = Fault("board failure", "call reset; the position is then lost")


class FailedError(RefusedError):
    """Exception: the failure bit in the board's status byte is 1."""


def signed(value: bytes) -> int:
    """Decode a signed number, most significant byte first."""
    return int.from_bytes(value, "big", signed=True)


def four(value: int) -> bytes:
    """Encode a signed number as four bytes, most significant byte first."""
    return value.to_bytes(4, "big", signed=True)


class Board(Core):
    """Implements the protocol of an 1810 or 1811.

    The only axis is `motor`.

    `interrupts`: wait for messages by the interrupt line instead of polling the status byte.  `marker_bit`: the user
    bit, 0 to 2, that is set to detect a reset of the board by another program; None: no detection.  `home_active_high`,
    `home_edge_ccw`, `home_percent`: the definition of HOME (38h).
    """

    remedy = "check the board's power and the address of the bus socket (bus://)"

    def __init__(
        self,
        timeout: float = 1.0,
        *,
        interrupts: bool = False,
        marker_bit: int | None = 2,
        home_active_high: bool = True,
        home_edge_ccw: bool = False,
        home_percent: int = 10,
    ) -> None:
        super().__init__(timeout)
        if marker_bit not in (None, 0, 1, 2):
            raise ValueError(f"invalid marker_bit {marker_bit}: expected 0, 1, 2 or None")
        if not 1 <= home_percent <= 100:
            raise ValueError(
                f"invalid home_percent {home_percent} (final velocity of a home search, in % of the default velocity): "
                "expected 1 to 100, e.g. 10"
            )
        self.interrupts, self.marker_bit = interrupts, marker_bit
        self.home_definition = bytes([home_active_high, home_edge_ccw, home_percent, 0])
        self.messages: deque[bytes] = deque(maxlen=256)
        """Messages of the board that are not answers to requests, oldest first: events, alarms, markers."""
        self._known = False
        self._lost = ""
        self.motor = Motor(self)
        self.axes = {"motor": self.motor}

    # Bus lines

    def _ask(self, request: str) -> Procedure[str]:
        """Send a request to the bus socket and return the answer."""
        yield Write(f"{request}\n".encode())
        while True:
            answer = (yield from self._until(b"\n", f"'{request}'")).decode("ascii", "replace").strip()
            if not answer.startswith("!"):
                break
        if answer.startswith("error"):
            raise WrongAnswerError(
                f"the answer to the bus request {request!r} is {answer!r}: expected 'ok' or hex digits, e.g. 50"
            )
        return answer

    def _read(self, count: int) -> Procedure[bytes]:
        return self._bytes((yield from self._ask(f"r 0 {count}")), count)

    def _bytes(self, answer: str, count: int) -> bytes:
        try:
            found = bytes.fromhex(answer)
        except ValueError:
            found = b""
        if len(found) != count:
            raise WrongAnswerError(
                f"the bus socket answered {shown(answer.encode())} to a read request: expected {count} hex bytes"
            )
        return found

    def _write(self, offset: int, data: Iterable[int]) -> Procedure[None]:
        answer = yield from self._ask(f"w {offset} " + " ".join(f"{value:02x}" for value in data))
        if answer != "ok":
            raise WrongAnswerError(f"the bus socket answered {shown(answer.encode())} to a write request: expected ok")

    def _control(self, bits: int) -> Procedure[None]:
        yield from self._write(1, [bits | (INTERRUPTS if self.interrupts else 0)])

    def _status_byte(self) -> Procedure[int]:
        """Read the status byte, and detect a reset or a failure of the board."""
        status = self._bytes((yield from self._ask("r 1")), 1)[0]
        if status & FAILED:
            raise FailedError(f"the 1811 has reported a failure: {FAIL.remedy}")
        if self._known and self.marker_bit is not None and status & READY and not status >> self.marker_bit & 1:
            self._known = False
            self._lost = "the board was reset or its power was cut"
            yield from self._prepare()
        return status

    # Synchronisation

    def synchronise(self) -> Procedure[None]:
        """Wait until the board is ready, and discard old messages from the board."""
        yield from self._discard(0.0)
        yield Write(b"\n")  # A line feed ends the incomplete request that an earlier host may have sent.
        yield from self._discard(0.02)
        if self.interrupts:
            yield from self._ask("s 1")
        yield from self._status_until(READY, STARTUP_S)
        while (yield from self._status_byte()) & MESSAGE:
            yield from self._message()
        if not self._known:
            yield from self._prepare()

    def _prepare(self) -> Procedure[None]:
        """Restore the settings that the board has lost in a reset."""
        self.motor.forget()
        if self.marker_bit is not None:
            yield from self._status_until(READY)
            yield from self._send_command(0x09, self.marker_bit)
            yield from self._status_until(READY)
            # The board answers request 8Ch only after command 09h has set the marker bit of the status byte.
            yield from self._request(0x8C)
        self._known = True

    def _status_until(self, bit: int, poll: float = POLL_S) -> Procedure[None]:
        end = (yield Clock()) + self.timeout + 1.0
        while not (yield from self._status_byte()) & bit:
            if (yield Clock()) > end:
                raise SilentError("the board is not ready for a command: check its power, or call reset")
            yield Pause(poll)

    # Commands

    def command(self, opcode: int, *parameters: int) -> Procedure[None]:
        """Send a command, e.g. `command(0x0B, 1)` to set output 1."""
        yield from self._status_until(READY)
        if opcode in MOTIONS:
            self.motor._aim(None)
        yield from self._send_command(opcode, *parameters)

    def _send_command(self, opcode: int, *parameters: int) -> Procedure[None]:
        yield from self._write(0, [opcode, *parameters])
        yield from self._control(COMMAND_READY)

    def request(self, opcode: int, *parameters: int) -> Procedure[bytes]:
        """Send a request to the board, and return the board's answer: the 15 bytes after the opcode."""
        yield from self._status_until(READY)
        return (yield from self._request(opcode, *parameters))

    def _request(self, opcode: int, *parameters: int) -> Procedure[bytes]:
        yield from self._send_command(opcode, *parameters)
        end = (yield Clock()) + self.timeout
        while True:
            status = self._bytes((yield from self._ask("r 1")), 1)[0]
            if status & MESSAGE:
                message = yield from self._message()
                if message[0] == opcode:
                    return message[1:]
                self.messages.append(message)
            elif (yield Clock()) > end:
                raise SilentError(
                    f"no answer to the request {opcode:02X}h within {self.timeout:g} s: "
                    "check the conditions for this request in the board's manual"
                )
            else:
                yield from self._wait_for_message()

    def _wait_for_message(self) -> Procedure[None]:
        if not self.interrupts:
            yield Pause(POLL_S)
        elif (yield from self._ask("i")) != "1":
            # Wait for at most 0.05 s until the server reports an interrupt of the board.
            data: bytes = yield Read(min(self.timeout, 0.05))
            self._received += data

    def _message(self) -> Procedure[bytes]:
        message = yield from self._read(16)
        yield from self._control(TAKEN)
        return message

    def take_messages(self) -> Procedure[list[bytes]]:
        """Return and clear the received messages that are not answers to requests, e.g. alarms."""
        while (yield from self._status_byte()) & MESSAGE:
            self.messages.append((yield from self._message()))
        found = list(self.messages)
        self.messages.clear()
        return found

    def reset(self) -> Procedure[None]:
        """Reset the board, which loses its position, moves and sequences."""
        yield from self._write(1, [RESET])
        self._known, self._lost = False, "the board was reset"
        yield Pause(0.01)
        yield from self._status_until(READY, STARTUP_S)
        yield from self._prepare()

    # Functions that only the boards 1810 and 1811 have

    def outputs(self, first: bool, second: bool) -> Procedure[None]:
        """Set the levels of both programmable outputs."""
        yield from self.command(0x0D, first << 1 | second << 2)

    def triggers(self) -> Procedure[dict[int, bool]]:
        """Return the signal levels at the board's trigger inputs 2 to 5."""
        bits = (yield from self.request(0x94))[0]
        return {number: bool(bits >> number & 1) for number in range(2, 6)}

    def define_sequence(self, number: int, commands: Iterable[bytes]) -> Procedure[None]:
        """Store commands as the sequence `number` (1 to 15).

        `command(0x41, number)` performs the sequence.
        """
        yield from self.command(0xDA, number)
        yield from self.command(0xD9, number)
        for one in commands:
            yield from self.command(*one)
        yield from self.command(0xD8)

    def closed_loop(self, ratio: tuple[int, int], resolution: int, sigma: int, teeth: int = 50) -> Procedure[None]:
        """Set the motor pulses per encoder pulse, the encoder resolution, the backlash and the number of rotor teeth.

        `ratio`: motor pulses per encoder pulse, as a fraction.  `sigma`: the backlash.
        """
        yield from self.command(0xB0, *ratio[0].to_bytes(2, "big"), *ratio[1].to_bytes(2, "big"))
        yield from self.command(0xB1, *four(resolution))
        yield from self.command(0xB2, *four(sigma))
        yield from self.command(0xB4, *four(teeth))

    def encoder(self) -> Procedure[int]:
        """Return the absolute encoder count."""
        return signed((yield from self.request(0x9A))[:4])

    def stream_times(self, update_ms: int, clock: int, divisor: int, velocities: Iterable[int]) -> Procedure[None]:
        """Run the motor at several velocities, one after the other, each for `update_ms` milliseconds.

        The commands are 52h and E1h.

        A negative velocity is CCW; the last velocity must be 0.  Returns when the last velocities are in the buffer of
        about 300.  If the board has used up its buffer before the next velocities arrive, stops the motor and raises
        RefusedError.
        """
        values = list(velocities)
        if values[-1:] != [0] or any(abs(value) > 0x7FFF for value in values):
            raise RefusedError(
                "invalid velocities: expected numbers from -32767 to 32767, and 0 as the last number, e.g. [100, 0]"
            )
        alarm = (0xFF, 0xFF, 0xFF, 0xFF)
        yield from self.command(0x52, clock, divisor, *alarm, *update_ms.to_bytes(2, "big"))
        values += [0] * (-len(values) % SEVEN)
        size = free = yield from self._free_bytes()
        begun = False
        while values:
            count = (free - 1) // STREAM_BYTES * SEVEN
            yield from self._stream(values[:count])
            del values[:count]
            if not begun:
                yield from self.command(0x42)
            elif not count:
                yield Pause(update_ms * SEVEN / 1000)
            before, free = free, (yield from self._free_bytes())
            is_empty = free == size  # The board's velocity buffer has run empty.
            is_stuck = not count and free == before
            if begun and (is_empty or is_stuck):
                for kill in (0x7B, 0x78):
                    yield from self.command(kill)
                raise RefusedError(
                    "the motor was stopped, because the next velocities arrived at the board too late: "
                    "expected a larger update_ms, i.e. a longer time for each velocity"
                )
            begun = True

    def _free_bytes(self) -> Procedure[int]:
        return int.from_bytes((yield from self.request(0xE2))[2:4], "big")

    def _stream(self, values: list[int]) -> Procedure[None]:
        for begin in range(0, len(values), SEVEN):
            words = [abs(value) | (0x8000 if value < 0 else 0) for value in values[begin : begin + SEVEN]]
            yield from self.command(0xE1, *(byte for word in words for byte in word.to_bytes(2, "big")))


class Motor(AxisCore):
    """The stepper motor of a board 1810 or 1811.  Positions are in pulses that the board sends to the motor."""

    def __init__(self, board: Board) -> None:
        super().__init__("motor", velocity=10_000.0, acceleration=100_000.0)
        self.max_velocity = 546_133.0
        self._board = board
        self._profile: tuple[int, int] | None = None
        self._homing, self._home_failed = False, False
        self._begin_by: float | None = None
        self._has_moved = False
        self._home_from = 0

    def forget(self) -> None:
        """Discard the driver's data about the motion, because a reset of the board has ended the motion."""
        self._profile, self._begin_by, self._homing = None, None, False

    def _numbers(self, velocity: float) -> tuple[int, bytes]:
        """Encode the velocity and the acceleration of a move for a command.

        Return the code of the velocity range, and the bytes of velocity and acceleration in this range.
        """
        if not 0 < velocity <= self.max_velocity:
            raise RefusedError(
                f"invalid velocity {velocity:g} pulses/s: "
                f"expected more than 0 and at most {self.max_velocity:g} pulses/s"
            )
        if not 1 <= self.acceleration < 2**31:
            raise RefusedError(
                f"invalid acceleration {self.acceleration:g} pulses/s²: expected 1 to 2147483647 pulses/s²"
            )
        code = 0 if velocity >= 50_000 or self.acceleration * 10 >= 2**31 else 1
        unit = RANGES[code]
        return code << 4, four(max(round(velocity / unit), 1)) + four(round(self.acceleration / unit))

    def _set_profile(self) -> Procedure[None]:
        ranges, numbers = self._numbers(self.velocity)
        if (yield from self._bits()) & 0x10:
            raise BusyError("the motor is moving: wait for the end of the motion, or stop the motor")
        yield from self._board.command(0x31, 0, ranges, *numbers)

    def _bits(self) -> Procedure[int]:
        return (yield from self._board.request(0x88))[0]

    def _position(self) -> Procedure[int]:
        return signed((yield from self._board.request(0x83))[:6])

    def move_to(self, target: int) -> Procedure[None]:
        """Begin a move to a position."""
        if self._board._lost:
            Status(0, 0, 0, False, lost=self._board._lost).known_position()
        yield from self._set_profile()
        distance = target - (yield from self._position())
        if not -(2**31) < distance < 2**31:
            raise RefusedError(f"the distance of {distance} pulses is too long: expected at most 2147483647 pulses")
        if distance:
            bits = yield from self._bits()
            if bits & (1 if distance > 0 else 2):
                sign = "+" if distance > 0 else "-"
                raise RefusedError(f"the {sign} limit is active: move in the other direction")
            yield from self._board.command(0x33, *four(distance))
            self._begin_by = (yield Clock()) + BEGIN_S
        self._aim(target, faults=self._own_faults())
        self.setpoint = target

    def move_by(self, distance: int) -> Procedure[None]:
        """Begin a relative move: the new target is the present position plus `distance`."""
        yield from self.move_to((yield from self._position()) + distance)

    def move_at(self, velocity: float) -> Procedure[None]:
        """Run the motor at a signed velocity until `stop` is called.

        If the motor is running, only its velocity changes.
        """
        if not velocity:
            yield from self.stop()
            return
        ranges, numbers = self._numbers(abs(velocity))
        yield from self._board.command(0xCE, MOVE_ID, ranges, *numbers, 0 if velocity > 0 else 1)
        yield from self._board.command(0x40, MOVE_ID)
        self._begin_by = (yield Clock()) + BEGIN_S

    def stop(self) -> Procedure[None]:
        """Decelerate the motor to a standstill."""
        yield from self._board.command(0x70)
        self._homing = False

    def abort(self) -> Procedure[None]:
        """Stop the pulses immediately, without deceleration."""
        yield from self._board.command(0x78)
        self._homing = False

    def home(self, direction: int) -> Procedure[None]:
        """Begin a search for the home switch.  At the end of the search, the position of the switch becomes 0."""
        yield from self._set_profile()
        start = yield from self._position()
        yield from self._board.command(0x38, *self._board.home_definition)
        yield from self._board.command(0x39, 0 if direction > 0 else 1)
        self._homing, self._home_failed, self._has_moved = True, False, False
        self._home_from = start
        self._aim(None, seeking=True)
        self._begin_by = (yield Clock()) + BEGIN_S

    def status(self) -> Procedure[Status]:
        """Return the state of the motor."""
        board = self._board
        try:
            bits = yield from self._bits()
            position = yield from self._position()
            moving = bool(bits & 0x10)
            if not moving:  # A position is exact only if the motor is at rest before and after the position is read.
                again = yield from self._bits()
                moving = bool(again & 0x10)
            velocity = (yield from self._velocity()) if moving else 0.0
            moving = yield from self._pending(moving, position)
        except FailedError:
            return self._judged(Status(0, 0, 0, False, faults=(FAIL,), lost="the board has failed"))
        if not moving and self._homing:
            self._has_moved |= position != self._home_from
            yield from self._homed()
            position = yield from self._position()
        return self._judged(
            Status(
                position,
                self.setpoint,
                0.0 - velocity if bits & 8 else velocity,
                moving,
                False,
                bool(bits & 1),
                bool(bits & 2),
                bool(bits & 4),
                self._own_faults(),
                board._lost,
            )
        )

    def _own_faults(self) -> tuple[Fault, ...]:
        return (NOT_FOUND,) if self._home_failed else ()

    def _velocity(self) -> Procedure[float]:
        found = yield from self._board.request(0x85)
        code = found[0] >> 4
        return signed(found[1:5]) * (RANGES[code] if code < 4 else 1 / 60 if code == 4 else 1.0)

    def _pending(self, moving: bool, position: int) -> Procedure[bool]:
        """Return True while a commanded motion is in progress.

        The motion is in progress from the command, even if the motor has not begun to move yet.
        """
        if moving:
            self._has_moved = True
            # A search for HOME consists of several motions, so the end of a motion may not be the end of the search.
            self._begin_by = (yield Clock()) + BEGIN_S if self._homing else None
        elif self._begin_by is not None and position != self.target and (yield Clock()) < self._begin_by:
            yield Pause(POLL_S)
            return True
        else:
            self._begin_by = None
        return moving

    def _homed(self) -> Procedure[None]:
        """Set the present position to 0 if the search has found HOME; otherwise store a fault."""
        self._homing = False
        if signed((yield from self._board.request(0x82))[:6]) == 0 and self._has_moved:
            yield from self._define(0)
            self.setpoint, self._seeking = 0, False
        else:
            self._home_failed = True

    def _define(self, position: int) -> Procedure[None]:
        yield from self._board.command(0x2E, *four(position))
        self._board._lost = ""

    def set_position(self, position: int) -> Procedure[None]:
        """Set the present position to a new value without a move; the motor must be at rest."""
        if (yield from self._bits()) & 0x10:
            raise BusyError("the motor is moving: the position can only be set at rest")
        yield from self._define(position)
        self.setpoint = position
        self._aim(None)

    def clear_faults(self) -> Procedure[None]:
        """Clear the fault `home not found`, which the driver reports after an unsuccessful homing."""
        self._home_failed = False
        yield from ()
