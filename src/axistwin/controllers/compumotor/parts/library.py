"""Definitions of moves and of HOME, the library of pre-defined moves, and the present or most recent move."""

from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from functools import cached_property

from axistwin.controllers.compumotor.parts.profiles import Speed
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES, VelocityRange, acceleration
from axistwin.sim.clock import Clock


class Kind(IntEnum):
    """Types of moves, each with the opcode of the command that defines such a move."""

    RELATIVE = 0xC8
    ABSOLUTE = 0xCB
    CONTINUOUS = 0xCE
    RELATIVE_ENCODER = 0xD4
    ABSOLUTE_ENCODER = 0xD5


CLOSED_LOOP = (Kind.RELATIVE_ENCODER, Kind.ABSOLUTE_ENCODER)


@dataclass(frozen=True)
class Move:
    """The definition of a move.  `target` is a distance, a position, or the direction byte of a continuous move."""

    kind: Kind
    ranges: tuple[int, int]
    velocity: int
    acceleration: int
    target: int = 0

    @cached_property
    def rate(self) -> Fraction | None:
        """Velocity in pulses/s; None if it is beyond the velocity range."""
        return VELOCITY_RANGES[self.ranges[0]].rate(self.velocity)

    @property
    def xy(self) -> int:
        """Parameter byte XY of a move, in which X is the velocity range and Y the acceleration range."""
        return self.ranges[0] << 4 | self.ranges[1]

    def speed(self, start_stop: int) -> Speed | None:
        """Return the velocity and acceleration of the move, or None if a value is invalid."""
        per_second = acceleration(self.ranges, self.acceleration)
        if self.rate is None or not per_second:
            return None
        return Speed(self.rate, per_second, VELOCITY_RANGES[self.ranges[0]], Fraction(start_stop))

    def definition(self, number: int) -> bytes:
        """Return the bytes of 91h that define the move: type, number, ranges, velocity, acceleration, target."""
        continuous = self.kind is Kind.CONTINUOUS
        target = bytes([self.target, 0, 0, 0]) if continuous else self.target.to_bytes(4, "big", signed=True)
        numbers = self.velocity.to_bytes(4, "big") + self.acceleration.to_bytes(4, "big")
        return bytes([self.kind, number, self.xy]) + numbers + target


NO_MOVE = Move(Kind.CONTINUOUS, (0, 0), 0, 0)  # Move zero after reset, which requests report until a first move begins.


class Library:
    """The pre-defined moves.  The processor calculates ("crunches") them one by one while it is idle."""

    def __init__(self, clock: Clock, calculation_ns: int) -> None:
        self.clock, self.calculation_ns = clock, calculation_ns
        self.default = NO_MOVE  # Move zero (31h), not calculated in advance; not performed while its acceleration is 0.
        self._moves: dict[int, Move] = {}
        self._ready_ns: dict[int, int] = {}
        self._idle_ns = 0

    def __getitem__(self, number: int) -> Move | None:
        return self.default if number == 0 else self._moves.get(number)

    def define(self, number: int, move: Move) -> None:
        self._moves[number] = move
        self._idle_ns = max(self._idle_ns, self.clock.now) + self.calculation_ns
        self._ready_ns[number] = self._idle_ns

    def delete(self, number: int) -> None:
        self._moves.pop(number, None)
        self._ready_ns.pop(number, None)

    @property
    def crunched(self) -> bool:
        """True if all moves have been calculated ("crunched")."""
        return all(ready_ns <= self.clock.now for ready_ns in self._ready_ns.values())

    def calculate_ns(self, number: int) -> int:
        """Return the calculation time before this move can begin, and count the move as calculated."""
        ready_ns = self._ready_ns.get(number)
        if ready_ns is None:
            return self.calculation_ns
        needed = min(self.calculation_ns, max(0, ready_ns - self.clock.now))
        self._ready_ns[number] = self.clock.now
        return needed


@dataclass
class Motion:
    """The present or most recent move."""

    move: Move | None = None
    speed: Speed | None = None
    end: int | None = None  # End position of a preset move, in the pulse generator's count.
    begun: int = 0
    sign: int = +1  # Direction of a preset move, which corrections do not change.
    stopped: bool = False  # True after a stop or kill: the remaining parts of the move are not performed.
    at_limit: bool = False
    streamed: bool = False


@dataclass(frozen=True)
class HomeDefinition:
    """The definition of HOME (38h).  `edge`: side of the active region; `final`: direction of the final approach."""

    active_high: bool
    edge: int
    percent: int
    final: int

    def rate(self, move: Move, velocities: VelocityRange) -> Fraction:
        """Return the velocity of the final approach in pulses/s: a multiple of the resolution, never 0."""
        unit = velocities.resolution
        wish = move.velocity * velocities.unit * self.percent / 100
        return max(unit, (2 * wish + unit) // (2 * unit) * unit)
