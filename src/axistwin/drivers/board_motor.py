"""The axis of a Compumotor 1810 or 1811."""

from typing import TYPE_CHECKING

from axistwin.drivers.axis import Fault, Status
from axistwin.drivers.core import BOTH_LIMITS, AxisCore
from axistwin.drivers.errors import BusyError, RefusedError
from axistwin.drivers.steps import Clock, Pause, Procedure

if TYPE_CHECKING:
    from axistwin.drivers.board import Board

POLL_S = 0.002
MOVE_ID = 50
"""Number of the predefined move that `move_at` uses."""
BEGIN_S = 0.1
"""Seconds after which a motion that has not begun counts as refused; a motion begins within 20 ms."""
STREAM_UPDATES = 8
"""Number of updates that may pass at velocity 0 at the end of a stream: a command has seven."""
RANGES = (1.0, 0.1, 0.01, 0.001)
NOT_FOUND = Fault("home not found", "check the home switch and home_definition, then call clear_faults")
FAIL = Fault("board failure", "call reset, or switch its power off and on; the position is then lost")


class FailedError(RefusedError):
    """Exception: the failure bit in the board's status byte is 1."""


def signed(value: bytes) -> int:
    return int.from_bytes(value, "big", signed=True)


def four(value: int) -> bytes:
    return value.to_bytes(4, "big", signed=True)


class Motor(AxisCore):
    """The stepper motor of a board 1810 or 1811.  Positions are in pulses that the board sends to the motor."""

    def __init__(self, board: "Board") -> None:
        super().__init__("motor", velocity=10_000.0, acceleration=100_000.0)
        self.max_velocity, self._board = 546_133.0, board
        self._profile: tuple[int, int] | None = None
        self._homing, self._home_failed = False, False
        self._begin_by: float | None = None
        self._streaming = False
        self._tail_s = 0.0
        """Longest pause in a motion that consists of several: a search for home, or a stream, which ends with zeros."""
        self._has_moved, self._home_from = False, 0

    def _aim(self, target: int | None, *, seeking: bool = False, faults: tuple[Fault, ...] = ()) -> None:
        super()._aim(target, seeking=seeking, faults=faults)
        self._homing, self._tail_s = False, 0.0

    def forget(self) -> None:
        """Discard the driver's data about the motion, because a reset of the board has ended the motion."""
        self._profile, self._begin_by, self._homing, self._streaming = None, None, False, False

    def _numbers(self, velocity: float) -> tuple[int, bytes]:
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
        yield from self.at_rest()
        yield from self._board._command(0x31, 0, ranges, *numbers)

    def at_rest(self) -> Procedure[None]:
        """Leave a streaming mode.  Raises BusyError during a motion, and while the last velocities of a stream pass."""
        busy = (yield from self._bits()) & 0x10
        if self._streaming and not busy:
            yield from self._board._command(0x50)
            busy = self._streaming = (yield from self._board.request(0x90))[0] != 0x50
        if busy:
            raise BusyError("the motor is moving: wait for the end of the motion, or stop the motor")

    def stream(self, update_ms: int) -> None:
        self._streaming, self._tail_s = True, STREAM_UPDATES * update_ms / 1000

    def _bits(self) -> Procedure[int]:
        return (yield from self._board.request(0x88))[0]

    def _position(self) -> Procedure[int]:
        return signed((yield from self._board.request(0x83))[:6])

    def move_to(self, target: int) -> Procedure[None]:
        if self._board._lost:
            Status(0, 0, 0, False, lost=self._board._lost).known_position()
        yield from self._set_profile()
        distance = target - (yield from self._position())
        if not -(2**31) < distance < 2**31:
            raise RefusedError(f"the distance of {distance} pulses is too long: expected at most 2147483647 pulses")
        if distance:
            bits = yield from self._bits()
            if bits & 3 == 3:
                raise RefusedError(BOTH_LIMITS)
            if bits & (1 if distance > 0 else 2):
                raise RefusedError(f"the {'+' if distance > 0 else '-'} limit is active: move in the other direction")
        self._aim(target, faults=self._own_faults())
        if distance:
            yield from self._board._command(0x33, *four(distance))
            self._begin_by = (yield Clock()) + BEGIN_S
        self.setpoint = target

    def move_by(self, distance: int) -> Procedure[None]:
        """Begin a relative move: the new target is the present position plus `distance`."""
        yield from self.move_to((yield from self._position()) + distance)

    def move_at(self, velocity: float) -> Procedure[None]:
        """Run at a signed velocity until `stop`; a running motor only changes its velocity."""
        if not velocity:
            yield from self.stop()
            return
        ranges, numbers = self._numbers(abs(velocity))
        if self._streaming:
            yield from self.at_rest()
        yield from self._board.command(0xCE, MOVE_ID, ranges, *numbers, 0 if velocity > 0 else 1)
        yield from self._board.command(0x40, MOVE_ID)
        self._begin_by = (yield Clock()) + BEGIN_S

    def stop(self) -> Procedure[None]:
        yield from self._board.command(0x70)

    def abort(self) -> Procedure[None]:
        """Stop the pulses immediately, without deceleration."""
        yield from self._board.command(0x78)

    def home(self, direction: int) -> Procedure[None]:
        """Begin a search for the home switch.  At the end of the search, the position of the switch becomes 0."""
        yield from self._set_profile()
        self._home_from = yield from self._position()
        self._aim(None, seeking=True)
        self._homing, self._home_failed, self._has_moved, self._tail_s = True, False, False, BEGIN_S
        yield from self._board._command(0x38, *self._board.home_definition)
        yield from self._board._command(0x39, 0 if direction > 0 else 1)
        self._begin_by = (yield Clock()) + BEGIN_S

    def status(self) -> Procedure[Status]:
        board = self._board
        try:
            bits = yield from self._bits()
            position = yield from self._position()
            moving = bool(bits & 0x10)
            if not moving:  # A position is exact only if the motor is at rest before and after the position is read.
                moving = bool((yield from self._bits()) & 0x10)
            velocity = (yield from self._velocity()) if moving else 0.0
            moving = yield from self._pending(moving, position)
        except FailedError:
            return self._judged(Status(0, 0, 0, False, faults=(FAIL,), lost="the board has failed"))
        if not moving and self._homing:
            self._has_moved |= position != self._home_from
            yield from self._homed()
            position = yield from self._position()
        return self._judged(Status(
            position, self.setpoint, 0.0 - velocity if bits & 8 else velocity, moving, False, bool(bits & 1),
            bool(bits & 2), bool(bits & 4), self._own_faults(), board._lost,
        ))  # fmt: skip

    def _own_faults(self) -> tuple[Fault, ...]:
        return (NOT_FOUND,) if self._home_failed else ()

    def _velocity(self) -> Procedure[float]:
        found = yield from self._board.request(0x85)
        code = found[0] >> 4
        return signed(found[1:5]) * (RANGES[code] if code < 4 else 1 / 60 if code == 4 else 1.0)

    def _pending(self, moving: bool, position: int) -> Procedure[bool]:
        if moving:
            self._has_moved = True
            self._begin_by = (yield Clock()) + self._tail_s if self._tail_s else None
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
