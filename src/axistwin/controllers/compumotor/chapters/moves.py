"""Chapters Indexer mode, Pre-defined moves and Move zero: commands 2Eh to 34h, 40h, C8h to CEh, D6h, D7h."""

from dataclasses import dataclass, replace
from enum import IntEnum
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

from simpy import Interrupt

from axistwin.controllers.compumotor.chapters.profiles import Speed, changed, continuous, preset, stopping
from axistwin.controllers.compumotor.chapters.pulses import RAMPS, Phase, VelocityProfile
from axistwin.controllers.compumotor.chapters.ranges import VELOCITY_RANGES, acceleration
from axistwin.sim.clock import Clock, Procedure

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board

MOST_MOVES = 0x32
FARTHEST_ABSOLUTE = 0x3FFF_FFFF


class Kind(IntEnum):
    """The types of moves: the opcodes that define them."""

    RELATIVE = 0xC8
    ABSOLUTE = 0xCB
    CONTINUOUS = 0xCE
    RELATIVE_ENCODER = 0xD4
    ABSOLUTE_ENCODER = 0xD5


CLOSED_LOOP = (Kind.RELATIVE_ENCODER, Kind.ABSOLUTE_ENCODER)


@dataclass(frozen=True)
class Move:
    """A move as it was defined.  `target`: pulses, a position, or for continuous moves the direction byte."""

    kind: Kind
    ranges: tuple[int, int]
    velocity: int
    acceleration: int
    target: int = 0

    @cached_property
    def rate(self) -> Fraction | None:
        """Pulses/s; None: beyond the range."""
        return VELOCITY_RANGES[self.ranges[0]].rate(self.velocity)

    @property
    def xy(self) -> int:
        """The byte with both ranges."""
        return self.ranges[0] << 4 | self.ranges[1]

    def speed(self, start_stop: int) -> Speed | None:
        """How to move; None: it cannot be, for there is no acceleration."""
        slope = acceleration(self.ranges, self.acceleration)
        if self.rate is None or not slope:
            return None
        return Speed(self.rate, slope, VELOCITY_RANGES[self.ranges[0]], Fraction(start_stop))

    def definition(self, number: int) -> bytes:
        """As it was sent: type, number, ranges, velocity, acceleration, target."""
        numbers = b"".join(n.to_bytes(4, "big") for n in (self.velocity, self.acceleration))
        target = (
            bytes([self.target, 0, 0, 0])
            if self.kind is Kind.CONTINUOUS
            else self.target.to_bytes(4, "big", signed=True)
        )
        return bytes([self.kind, number, self.xy]) + numbers + target


NO_MOVE = Move(Kind.CONTINUOUS, (0, 0), 0, 0)
"""Move zero after reset, and what is reported where no move has begun yet."""


class Library:
    """The pre-defined moves.  The processor "crunches" them one after the other, when it finds time."""

    def __init__(self, clock: Clock, calculation_ns: int) -> None:
        self.clock, self.calculation_ns = clock, calculation_ns
        self.default = NO_MOVE
        """Move zero (31h), which is not calculated in advance.  Without acceleration it is not defined."""
        self._moves: dict[int, Move] = {}
        self._ready_ns: dict[int, int] = {}
        self._idle_ns = 0

    def __getitem__(self, number: int) -> Move | None:
        return self.default if number == 0 else self._moves.get(number)

    def define(self, number: int, move: Move) -> None:
        """Define a move, or define it again."""
        self._moves[number] = move
        self._idle_ns = max(self._idle_ns, self.clock.now) + self.calculation_ns
        self._ready_ns[number] = self._idle_ns

    def delete(self, number: int) -> None:
        """There is no such move any more."""
        self._moves.pop(number, None)
        self._ready_ns.pop(number, None)

    @property
    def crunched(self) -> bool:
        """Whether all moves have been calculated."""
        return all(ready_ns <= self.clock.now for ready_ns in self._ready_ns.values())

    def calculate_ns(self, number: int) -> int:
        """How long the calculation takes before this move can begin; it is then done with."""
        ready_ns = self._ready_ns.get(number)
        if ready_ns is None:
            return self.calculation_ns
        needed = min(self.calculation_ns, max(0, ready_ns - self.clock.now))
        self._ready_ns[number] = self.clock.now
        return needed


@dataclass
class Motion:
    """What is known of the present or the most recent move."""

    move: Move | None = None
    speed: Speed | None = None
    end: int | None = None
    """Where a preset move ends, in the pulse generator's count."""
    begun: int = 0
    """How many moves have begun since reset."""
    sign: int = +1
    """The direction of a preset move, also when a correction has gone the other way since."""
    stopped: bool = False
    """Whether it was stopped or killed, so that nothing of it is still to come."""
    at_limit: bool = False
    """True if it has hit a limit."""
    streamed: bool = False
    """True if a stream has been performed since."""


# Definitions


def set_default(board: "Board", ranges: tuple[int, int], velocity: int, acceleration: int) -> None:
    """Command 31h: default velocity and acceleration, in the units of their ranges; both 0 until then.

    Ignored if the velocity is beyond its range.  Chapter Move zero.
    """
    move = Move(Kind.CONTINUOUS, ranges, velocity, acceleration)
    if move.rate is not None:
        board.library.default = move


def define(  # one argument for each parameter of the command
    kind: Kind, board: "Board", number: int, ranges: tuple[int, int], velocity: int, acceleration: int, target: int
) -> None:
    """Commands C8h, CBh, CEh, D4h, D5h: define move 1 to 50; whatever it was before is forgotten.

    Numbers 51 to 255 are accepted and not kept (X2).  Ignored if the velocity is beyond its range.
    """
    move = Move(kind, ranges, velocity, acceleration, target)
    if move.rate is not None and number <= MOST_MOVES:
        board.library.define(number, move)


def delete(board: "Board", number: int) -> None:
    """Command D7h: delete move 1 to 255.  Nothing happens if there is none."""
    board.library.delete(number)


def set_start_stop(board: "Board", velocity: int) -> None:
    """Command D6h: the start/stop velocity of all moves from now on, in pulses/s; 0 after reset."""
    board.start_stop = velocity


# Absolute zero


def define_position(board: "Board", position: int) -> None:
    """Command 2Eh: the present absolute position is `position`, signed pulses.  Ignored while moving."""
    if not board.occupied:
        board.zero = board.pulses.position - position


def define_zero(board: "Board") -> None:
    """Command 30h: here is absolute zero, for both counts.  Ignored while moving or with the joystick enabled."""
    define_position(board, 0)
    if not board.occupied:
        board.loop.define(0)


# Performing


def go_relative(board: "Board", distance: int) -> Procedure:
    """Command 33h: `distance` signed pulses at default velocity and acceleration.

    Ignored if there is no default move (31h), while moving, shut down or maintaining position.
    """
    yield from perform_default(board, Kind.RELATIVE, distance)


def go_absolute(board: "Board", position: int) -> Procedure:
    """Command 34h: to an absolute position within ±(2³⁰-1), at default velocity and acceleration.

    Ignored as 33h, and if the present position is outside of that range.
    """
    yield from perform_default(board, Kind.ABSOLUTE, position)


def go_on(board: "Board", minus: bool) -> Procedure:
    """Command 32h: the default move as a continuous one.  Ignored without default move (31h)."""
    yield from perform_default(board, Kind.CONTINUOUS, int(minus))


def perform_default(board: "Board", kind: Kind, target: int) -> Procedure:
    """A move at default velocity and acceleration.  Ignored without default move (31h)."""
    move = replace(board.library.default, kind=kind, target=target)
    yield from perform(board, move, board.library.calculation_ns)


def perform_move(board: "Board", number: int) -> Procedure:
    """Command 40h: perform pre-defined move 1 to 50.  Ignored if it is not defined or a move is being performed."""
    move = board.library[number]
    if move is not None:
        yield from perform(board, move, board.library.calculate_ns(number))


def perform(board: "Board", move: Move, calculation_ns: int) -> Procedure:
    """Perform a move once the processor is ready for it; over when it is no longer being performed."""
    speed = move.speed(board.start_stop)
    if speed is None or not may_perform(board, move):
        return
    yield board.occupy(calculation_ns + board.start_ns)
    board.loop.give_way()
    if move.kind in CLOSED_LOOP:
        yield from board.loop.perform(move, speed)
    elif move.kind is Kind.CONTINUOUS:
        yield from _perform_continuous(board, move, speed)
    elif (distance := preset_distance(board, move)) and speed.rate:
        end = board.pulses.position + distance
        yield from excursion(board, move, speed, distance // abs(distance), preset(speed, abs(distance)), end)


def may_perform(board: "Board", move: Move) -> bool:
    """A preset move needs the motor at rest; a continuous one needs it not on a ramp."""
    if board.shut_down or board.joystick.enabled:
        return False
    if move.kind is Kind.CONTINUOUS:
        return board.pulses.phase not in RAMPS
    if move.kind in CLOSED_LOOP:
        return not board.pulses.moving or board.loop.correcting
    return not board.pulses.moving and not board.maintaining


def preset_distance(board: "Board", move: Move) -> int:
    """How many pulses a relative or absolute move is from here; 0: nothing is to be done."""
    if move.kind is Kind.RELATIVE:
        return move.target
    if abs(board.absolute) > FARTHEST_ABSOLUTE:
        return 0
    return move.target - board.absolute


def excursion(
    board: "Board", move: Move, speed: Speed, sign: int, velocity_profile: VelocityProfile, end: int | None = None
) -> Procedure:
    """From zero velocity, until the move is no longer being performed.  Ignored if blocked in that direction."""
    if board.blocked(sign):
        return
    board.begin_move(move, speed, end)
    board.pulses.start(velocity_profile, sign)
    yield from _until_performed(board, move)


def _perform_continuous(board: "Board", move: Move, speed: Speed) -> Procedure:
    sign, pulses = (-1 if move.target else +1), board.pulses
    if not pulses.moving:
        if speed.rate:
            yield from excursion(board, move, speed, sign, continuous(speed))
        return
    before = VELOCITY_RANGES[board.motion.move.ranges[0]] if board.motion.move else speed.range
    board.begin_move(move, speed, None)
    if speed.rate and sign == pulses.sign:
        pulses.change(changed(pulses.rate, before, speed))
        yield from _until_performed(board, move)
        return
    pulses.change(stopping(pulses.rate, speed))
    yield from _until(board, Phase.REST)
    ended = board.motion.stopped or board.motion.at_limit
    if speed.rate and not (ended or board.blocked(sign)):
        pulses.start(continuous(speed), sign)
        yield from _until_performed(board, move)


def _until_performed(board: "Board", move: Move) -> Procedure:
    if move.kind is Kind.CONTINUOUS:
        yield from _until(board, Phase.REST, Phase.CONSTANT)
    else:
        yield from _until(board, Phase.REST)


def _until(board: "Board", *phases: Phase) -> Procedure:
    """Wait for one of these phases.  A move that is discontinued leaves the motor at the velocity of that instant."""
    try:
        while board.pulses.phase not in phases:
            yield board.pulses.changed()
    except Interrupt:
        board.pulses.hold()
        raise
