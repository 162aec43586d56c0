"""Chapter Home: commands 38h, 39h, 3Ah.

The edges of the home input and the final approach have physical directions, CW (+1) and CCW (-1).  The first direction
of the search is + or -.  Legs of a search in CCW direction for the CW edge, with final approach CW:

    CCW ────────────────[ active ]──────────────── CW
                                 ◄───────────────●     search at the default velocity, to the edge
                       ◄─────────                      overshoot: the ramp down
                       ──────────►                     recovery: back to the position of the edge
                              ◄──                      if needed: to the other side of the edge
                              ───►                     final approach at its percentage, without a ramp
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from axistwin.controllers.compumotor.chapters.moves import NO_DEFAULT
from axistwin.controllers.compumotor.parts.library import HomeDefinition, Move
from axistwin.controllers.compumotor.parts.profiles import Speed, continuous, preset, stopping
from axistwin.controllers.compumotor.parts.pulses import Phase, VelocityProfile
from axistwin.controllers.compumotor.parts.tracking import Use
from axistwin.controllers.compumotor.state import IN_MOTION, SHUT_DOWN, State, ns
from axistwin.sim.clock import Clock, Interrupt, Procedure
from axistwin.sim.motion.profile import Segment
from axistwin.sim.pins import Pin

NO_HOME = "38 (define home) must be sent first"


@dataclass(frozen=True)
class Mark:
    """The target of a search for HOME: one edge of an input.

    `steady_ns`: time for which a new level must last; `valid`: returns True while edges are accepted.
    """

    pin: Pin
    active_level: bool
    edge: int
    steady_ns: int
    valid: Callable[[], bool]

    def level_behind(self, direction: int) -> bool:
        """Return the level that the pin has after the motor has passed the edge in this direction."""
        return self.active_level if direction == -self.edge else not self.active_level


class EdgeObserver:
    """Triggers the event `seen` when a pin has changed to `level` and has kept this level for the required time."""

    def __init__(self, clock: Clock, mark: Mark, level: bool) -> None:
        self.clock, self.seen = clock, clock.event()
        self._mark, self._level, self._changes = mark, level, 0
        self.close = mark.pin.subscribe(self._changed)

    def _changed(self, pin: Pin) -> None:
        self._changes += 1
        if pin.level is self._level and self._mark.valid():
            self.clock.call_later(self._mark.steady_ns, partial(self._respond, self._changes))

    def _respond(self, change: int) -> None:
        if change == self._changes and not self.seen.triggered:
            self.seen.succeed()


class Search:
    """Performs one search for HOME after command 39h or 3Ah."""

    def __init__(self, board: State, definition: HomeDefinition, move: Move, speed: Speed, mark: Mark) -> None:
        self._board, self._final, self._speed, self._mark = board, definition.final, speed, mark
        slow = Segment(definition.rate(move, speed.range), None)
        self._slow = VelocityProfile(((Phase.CONSTANT, (slow,)),), speed.range.maximum, of_move=False)

    def perform(self, start: int) -> Procedure:
        """Perform the search, at first in physical direction `start`.  HOME changes only if the edge is found."""
        board, pulses, fast = self._board, self._board.pulses, continuous(self._speed)
        seen_at = yield from self._until_seen(fast, start)
        if seen_at is None and board.limits.blocks(self._sign(start)) and not board.motion.stopped:
            seen_at = yield from self._until_seen(fast, -start)
        if seen_at is None:
            return
        pulses.change(stopping(pulses.rate, self._speed))
        yield from self._rest()
        if not (yield from self._recover(seen_at)):
            return
        mark = self._mark
        if mark.pin.level is mark.level_behind(self._final) and not (yield from self._approach(-self._final)):
            return
        if (yield from self._approach(self._final)):
            board.home = pulses.position

    def _sign(self, direction: int) -> int:
        return direction if self._board.pulses.cw_is_plus else -direction

    def _recover(self, target: int) -> Procedure:
        """Move back by the overshoot.  Return True if the motor has reached `target`."""
        board, pulses = self._board, self._board.pulses
        distance = target - pulses.position
        if distance and not board.motion.stopped:
            yield board.occupy(board.start_ns)
            sign = 1 if distance > 0 else -1
            if not board.blocked(sign):
                pulses.start(preset(self._speed, abs(distance)), sign)
                yield from self._rest()
        return pulses.position == target and not board.motion.stopped

    def _approach(self, direction: int) -> Procedure:
        """Move slowly until an edge of the home signal is detected, and stop.  Return True if an edge was detected."""
        seen_at = yield from self._until_seen(self._slow, direction)
        if seen_at is not None:
            self._board.pulses.kill()
        return seen_at is not None

    def _until_seen(self, profile: VelocityProfile, direction: int) -> Procedure:
        """Move until the edge is found.  Return its position, or None if the motion ended before."""
        board, pulses, sign = self._board, self._board.pulses, self._sign(direction)
        yield board.occupy(board.start_ns)
        if board.motion.stopped or board.blocked(sign):
            return None
        observer = EdgeObserver(board.clock, self._mark, self._mark.level_behind(direction))
        try:
            pulses.start(profile, sign)
            while pulses.moving and not observer.seen.triggered:
                yield observer.seen | pulses.changed()
            return pulses.position if pulses.moving and not board.motion.stopped else None
        finally:
            observer.close()

    def _rest(self) -> Procedure:
        while self._board.pulses.moving:
            yield self._board.pulses.changed()


def define_home(board: State, active_high: bool, ccw_edge: bool, percent: int, final_ccw: bool) -> None:
    """Command 38h: define HOME by an edge and the active level of the home input, and the final approach to this edge.

    `percent`: velocity of the approach in percent of the default velocity.  For 3Ah the level is that of HOME ENABLE,
    and the edge has no effect.
    """
    board.home_definition = HomeDefinition(active_high, -1 if ccw_edge else +1, percent, -1 if final_ccw else +1)


def go_home(board: State, minus: bool) -> Procedure:
    """Command 39h: search for HOME at default velocity and acceleration.

    The search begins in the - direction if `minus` is True, otherwise in the + direction.  Commands 38h and 31h must
    precede this command.  The command is ignored while the motor is moving or shut down, or the joystick is enabled.
    """
    definition = board.home_definition
    if definition is None:
        return NO_HOME
    pin = board.pins["home"]
    mark = Mark(pin, definition.active_high, definition.edge, max(1, ns(board.options.home_ms)), lambda: True)
    return (yield from _go(board, minus, definition, mark))


def go_encoder_home(board: State, minus: bool) -> Procedure:
    """Command 3Ah: move the motor until the index mark of the encoder (channel Z) is found.

    A mark counts only while the input HOME ENABLE is active.  HOME is the edge where the mark begins in the direction
    of the final approach.  The command is ignored under the conditions of command 39h, and while position maintenance
    (18h) is off.
    """
    definition = board.home_definition
    if definition is None:
        return NO_HOME
    if not board.loop.on:
        return "position maintenance is off: send 18 01 first"
    enable, z_active = board.pins["home"], not board.options.invert_z
    mark = Mark(board.pins["channel_z"], z_active, -definition.final, 1, lambda: enable.level is definition.active_high)
    return (yield from _go(board, minus, definition, mark))


def _go(board: State, minus: bool, definition: HomeDefinition, mark: Mark) -> Procedure:
    default = board.library.default
    speed = default.speed(board.start_stop)
    if speed is None or not speed.rate:
        return NO_DEFAULT
    if board.occupied or board.shutdown.on:
        return SHUT_DOWN if board.shutdown.on else IN_MOTION
    yield board.occupy(board.library.calculation_ns)
    move = replace(default, target=int(minus))
    board.begin_move(move, speed, None)
    search = Search(board, definition, move, speed, mark)
    _use(board, Use.SEARCH)
    try:
        yield from search.perform(-1 if minus is board.pulses.cw_is_plus else +1)
    except Interrupt:
        board.pulses.hold()
        raise
    finally:
        _use(board, Use.OPEN_LOOP)
    return None


def _use(board: State, use: Use) -> None:
    board.loop.use = use
    board.loop.give_way()
