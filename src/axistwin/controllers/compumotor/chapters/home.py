"""Chapter Home: commands 38h, 39h, 3Ah.

The edges of the home input and the final approach are told in the physical directions CW (+1) and CCW (-1), the start
of the search in + or -.  Legs of a search, for the CW edge approached CW and found travelling CCW:

    CCW ────────────────[ active ]──────────────── CW
                                 ◄───────────────●     search at the default velocity, to the edge
                       ◄─────────                      overshoot: the ramp down
                       ──────────►                     recovery: back to where the edge was seen
                              ◄──                      if it is on the wrong side for what follows: past the edge
                              ───►                     final approach at its percentage, without a ramp
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

from simpy import Interrupt

from axistwin.controllers.compumotor.chapters.moves import Move
from axistwin.controllers.compumotor.chapters.profiles import Speed, continuous, preset, stopping
from axistwin.controllers.compumotor.chapters.pulses import Phase, VelocityProfile
from axistwin.controllers.compumotor.chapters.ranges import VelocityRange
from axistwin.motion.profile import Segment
from axistwin.sim.clock import Clock, Procedure
from axistwin.sim.pins import Pin

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board


@dataclass(frozen=True)
class HomeDefinition:
    """Command 38h.  `edge`: on which side of the active region HOME is; `final`: the direction of the last approach."""

    active_high: bool
    edge: int
    percent: int
    final: int

    def rate(self, move: Move, velocities: VelocityRange) -> Fraction:
        """The velocity of the final approach in pulses/s, as the range can give it out, and never zero."""
        unit = velocities.resolution
        wish = move.velocity * velocities.unit * self.percent / 100
        return max(unit, (2 * wish + unit) // (2 * unit) * unit)


@dataclass(frozen=True)
class Mark:
    """What is looked for: one edge of an input.

    `steady_ns`: how long a level must last to be seen; `valid`: whether an edge counts at this moment.
    """

    pin: Pin
    active_level: bool
    edge: int
    steady_ns: int
    valid: Callable[[], bool]

    def level_behind(self, direction: int) -> bool:
        """The level of the pin once the edge has been passed in this direction."""
        return self.active_level if direction == -self.edge else not self.active_level


class EdgeWatch:
    """Watches a pin until it has gone to a level and stayed there."""

    def __init__(self, clock: Clock, mark: Mark, level: bool) -> None:
        self.clock, self.seen = clock, clock.event()
        self._mark, self._level, self._changes = mark, level, 0
        self.close = mark.pin.subscribe(self._look)

    def _look(self, pin: Pin) -> None:
        self._changes += 1
        if pin.level is self._level and self._mark.valid():
            self.clock.call_later(self._mark.steady_ns, partial(self._respond, self._changes))

    def _respond(self, change: int) -> None:
        if change == self._changes and not self.seen.triggered:
            self.seen.succeed()


class Search:
    """One search for HOME."""

    def __init__(self, board: "Board", definition: HomeDefinition, move: Move, speed: Speed, mark: Mark) -> None:
        self._board, self._final, self._speed, self._mark = board, definition.final, speed, mark
        slow = Segment(definition.rate(move, speed.range), None)
        self._slow = VelocityProfile(((Phase.CONSTANT, (slow,)),), speed.range.maximum, of_move=False)

    def perform(self, start: int) -> Procedure:
        """All of it, beginning in this physical direction.  HOME is where it was unless the edge has been found."""
        seen_at = yield from self._seek(start)
        if seen_at is None and self._at_limit(start):
            seen_at = yield from self._seek(-start)
        if seen_at is None:
            return
        yield from self._slow_down()
        if not (yield from self._recover(seen_at)):
            return
        mark = self._mark
        if mark.pin.level is mark.level_behind(self._final) and not (yield from self._approach(-self._final)):
            return
        if (yield from self._approach(self._final)):
            self._board.home = self._board.pulses.position

    @property
    def _stopped(self) -> bool:
        """Whether the host has stopped or killed the motion since this began."""
        return self._board.motion.stopped

    def _sign(self, direction: int) -> int:
        return direction if self._board.pulses.cw_is_plus else -direction

    def _at_limit(self, direction: int) -> bool:
        return self._board.limits.blocks(self._sign(direction)) and not self._stopped

    def _seek(self, direction: int) -> Procedure:
        """At the default velocity: the position where the edge was seen, or None."""
        return (yield from self._until_seen(continuous(self._speed), direction))

    def _slow_down(self) -> Procedure:
        pulses = self._board.pulses
        pulses.change(stopping(pulses.rate, self._speed))
        yield from self._rest()

    def _recover(self, target: int) -> Procedure:
        """Back by the overshoot; whether the motor has come there."""
        pulses = self._board.pulses
        distance = target - pulses.position
        if distance and not self._stopped:
            yield self._board.occupy(self._board.start_ns)
            sign = 1 if distance > 0 else -1
            if not self._board.blocked(sign):
                pulses.start(preset(self._speed, abs(distance)), sign)
                yield from self._rest()
        return pulses.position == target and not self._stopped

    def _approach(self, direction: int) -> Procedure:
        """At the final velocity past the edge, and stop there; whether it has been found."""
        seen_at = yield from self._until_seen(self._slow, direction)
        if seen_at is not None:
            self._board.pulses.kill()
        return seen_at is not None

    def _until_seen(self, velocity_profile: VelocityProfile, direction: int) -> Procedure:
        """Move until the edge is seen: the position there, or None if the motion has ended before."""
        board, pulses, sign = self._board, self._board.pulses, self._sign(direction)
        yield board.occupy(board.start_ns)
        if self._stopped or board.blocked(sign):
            return None
        watch = EdgeWatch(board.clock, self._mark, self._mark.level_behind(direction))
        try:
            pulses.start(velocity_profile, sign)
            while pulses.moving and not watch.seen.triggered:
                yield watch.seen | pulses.changed()
            return pulses.position if pulses.moving and not self._stopped else None
        finally:
            watch.close()

    def _rest(self) -> Procedure:
        while self._board.pulses.moving:
            yield self._board.pulses.changed()


# Commands


def define_home(board: "Board", active_high: bool, ccw_edge: bool, percent: int, final_ccw: bool) -> None:
    """Command 38h: which edge of which level of the home input is HOME, and how it is approached.

    `percent` of the default velocity.  For 3Ah the level is that of HOME ENABLE, and the edge means nothing.
    """
    board.home_definition = HomeDefinition(active_high, -1 if ccw_edge else +1, percent, -1 if final_ccw else +1)


def go_home(board: "Board", minus: bool) -> Procedure:
    """Command 39h: search for HOME at default velocity and acceleration, first in + or -.

    Ignored without 38h or 31h, while moving or shut down, and with the joystick enabled.
    """
    definition = board.home_definition
    if definition is not None:
        pin = board.pins["home"]
        mark = Mark(pin, definition.active_high, definition.edge, board.home_ns, lambda: True)
        yield from _go(board, minus, definition, mark)


def go_encoder_home(board: "Board", minus: bool) -> Procedure:
    """Command 3Ah: search for the channel Z mark that comes while HOME ENABLE is active.

    HOME is the edge where the mark begins in the direction of the final approach.  Ignored as 39h, and while position
    is not maintained (18h).
    """
    definition = board.home_definition
    if definition is not None and board.maintaining:
        enable, z_active = board.pins["home"], not board.options.invert_z
        mark = Mark(
            board.pins["channel_z"], z_active, -definition.final, 1, lambda: enable.level is definition.active_high
        )
        yield from _go(board, minus, definition, mark)


def _go(board: "Board", minus: bool, definition: HomeDefinition, mark: Mark) -> Procedure:
    default = board.library.default
    speed = default.speed(board.start_stop)
    if speed is None or not speed.rate or board.occupied or board.shut_down:
        return
    yield board.occupy(board.library.calculation_ns)
    move = replace(default, target=int(minus))
    board.begin_move(move, speed, None)
    search = Search(board, definition, move, speed, mark)
    board.loop.hold(True)
    try:
        yield from search.perform(-1 if minus is board.pulses.cw_is_plus else +1)
    except Interrupt:
        board.pulses.hold()
        raise
    finally:
        board.loop.hold(False)
