"""The motion of an axis by trapezoids in whole pulses, which can be changed and stopped while they run."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from axistwin.core.units import MS
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Event, Procedure, Process, kill
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.sim.motion.trapezoid import FINE, Limits
from axistwin.sim.pins import Pin

SIDES = {-1: "minus", +1: "plus"}


@dataclass(eq=False)
class Positioner:
    """An axis of a device; all figures in steps (with `servo` in encoder counts) and seconds, and settable at any time.

    `velocity` is that of moves, `start_velocity` the one from which a motor starts and stops without a ramp.
    `deceleration`: None means `acceleration`.  `minus`, `plus`, `home`: names of the input pins of its switches; the
    limit inputs open beyond the option `limits` of the axis, the home input is high within `home`.  `servo`: the axis
    has an encoder and is driven back to where it should be; more than `following_error` counts behind, it stops.
    """

    velocity: float = 1000
    acceleration: float = 10_000
    deceleration: float | None = None
    start_velocity: float = 0
    minus: str = ""
    plus: str = ""
    home: str = ""
    servo: bool = False
    following_error: int | None = None
    target: int = field(default=0, init=False)  #: Where the present or latest move ends.
    stopped_by: str = field(default="", init=False)
    """ "minus limit", "plus limit", "following error"; "" after the next start."""

    def connect(self, axis: StepperAxis, pins: dict[str, Pin], at_limit: Callable[[int], object]) -> "Positioner":
        """Return a positioner with these settings that moves an axis; its position is 0 there."""
        live = copy(self)
        live._axis, live._clock, live._at_limit = axis, axis.clock, at_limit
        axis.unit = "counts" if self.servo else "pulses"
        live._origin, live._encoder_origin = axis.pulses, axis.position
        live._drop_end, live._watch = None, None
        live._goal, live._ended = None, None
        live._pins = {side: pins[name] for side, name in ((-1, self.minus), (+1, self.plus)) if name}
        live._home = pins[self.home] if self.home else None
        live._ends = [pin.subscribe(lambda _: live._check_limits()) for pin in live._pins.values()]
        if self.servo:
            live._ends.append(axis.on_motion.subscribe(live._disturbed))
        return live

    _axis: StepperAxis = field(init=False, repr=False)
    _clock: Clock = field(init=False, repr=False)
    _at_limit: Callable[[int], object] = field(init=False, repr=False)
    _pins: dict[int, Pin] = field(init=False, repr=False)
    _home: Pin | None = field(init=False, repr=False)
    _ends: list[Callable[[], None]] = field(init=False, repr=False)
    _origin: int = field(init=False, repr=False)
    _encoder_origin: int = field(init=False, repr=False)
    _watch: Process | None = field(init=False, repr=False)  # What drives a servo back to where it should be.
    _goal: Any = field(init=False, repr=False)  # A position, a signed rate of an endless motion, or None: stop.
    _drop_end: Callable[[], None] | None = field(init=False, repr=False)  # Drops the event of the end of the motion.
    _ended: Event | None = field(init=False, repr=False)

    # What is asked

    @property
    def position(self) -> int:
        """Position that the controller knows: the steps made since it was 0; with `servo` that of the encoder."""
        return self._axis.position - self._encoder_origin if self.servo else self.commanded

    @property
    def commanded(self) -> int:
        """Position of the trajectory; `commanded - position` is the following error of a servo."""
        return self._axis.pulses - self._origin

    @property
    def speed(self) -> float:
        """Present velocity; negative in the negative direction."""
        return self._axis.velocity

    @property
    def moving(self) -> bool:
        """True until the motion has ended."""
        return self._drop_end is not None or self._axis.moving

    @property
    def done(self) -> Event:
        """Event of the end of the present motion; at rest, of now."""
        if not self.moving:
            return self._clock.timeout(0)
        if self._ended is None:
            self._ended = self._clock.event()
        return self._ended

    def at_limit(self, side: int) -> bool:
        """True beyond the limit switch of a side, -1 or +1: its input is low."""
        return side in self._pins and not self._pins[side].level

    @property
    def at_home(self) -> bool:
        """True while the home input is high."""
        return self._home is not None and self._home.level

    # What moves

    def define(self, position: int) -> None:
        """Give the present position a number, without motion; a move in progress ends where it would have ended."""
        shift = position - self.position
        self._origin -= shift
        self._encoder_origin -= shift
        self.target = self.target + shift if self.moving else position
        if isinstance(self._goal, int):
            self._goal += shift

    def move_to(self, position: float) -> None:
        """Move to a position, rounded to whole steps; in motion with a ramp, and by way of a stop if it lies behind."""
        self.target = round(position)
        self._begin(self.target)

    def move_by(self, distance: float) -> None:
        """Move by a distance from the target of the present move, or from the present position."""
        self.move_to((self._goal if isinstance(self._goal, int) else self.commanded) + distance)

    def run(self, velocity: float) -> None:
        """Move with a signed velocity until stopped; 0 stops with a ramp."""
        self._begin(_fine(velocity) if velocity else None)

    def stop(self) -> None:
        """Stop with a ramp."""
        if self.moving:
            self._begin(None)

    def abort(self) -> None:
        """Stop at once, without a ramp."""
        self._halt()
        self._end()

    def find_home(self, velocity: float, slow: float) -> Procedure:
        """Search the home switch with a signed velocity, leave it slowly the other way, and call that place 0.

        For `yield from`.  Returns True, or False if a limit switch or a stop has ended the search.
        """
        back = -abs(slow) if velocity > 0 else abs(slow)
        for speed, level in ((velocity, True), (back, True), (back, False)):  # The ramp may end beyond the switch.
            if self._home is not None and self._home.level is not level:
                self.run(speed)
                yield self._home.changed() | self.done
                found = self._home.level is level
                if found and speed == velocity:
                    self.stop()
                    yield self.done
                if self.stopped_by or not found:
                    return False
        self.abort()
        self.define(0)
        return True

    def disconnect(self) -> None:
        """End all motion: the power is off."""
        self._halt()
        if self._watch is not None:
            kill(self._watch)
        for end in self._ends:
            end()

    # How it moves

    def _begin(self, goal: Any) -> None:
        self._goal, self.stopped_by = goal, ""
        self._next_leg()

    def _next_leg(self) -> None:
        """Start the motion from the present rate to the goal, or to the stop at which the direction changes."""
        goal, (rate, direction, fraction) = self._goal, self._state()
        limits = Limits(*map(_fine, (self.velocity, self.start_velocity, self.acceleration, self.deceleration or 0)))
        way = goal - self.commanded if isinstance(goal, int) else goal or 0
        if not rate and not way:
            self.abort()
            return
        direction = direction or (1 if way > 0 else -1)
        if isinstance(goal, int):
            segments = limits.to_distance(rate, way * direction - fraction)
        else:
            segments = limits.to_rate(rate, max(Fraction(way * direction), Fraction(0)))
        self._start(segments, direction, fraction, rate)

    def _state(self) -> tuple[Fraction, int, Fraction]:
        """Return rate, direction and the fraction of a step since the last one; at rest 0, 0, 0."""
        move, elapsed_ns = self._axis.train.move, self._clock.now - self._axis.train.move.start_ns
        rate = move.profile.rate_at(elapsed_ns) if elapsed_ns else move.profile.before
        if not self._axis.moving or not (elapsed_ns or rate):
            return Fraction(0), 0, Fraction(0)
        made, fraction = move.profile.phase_at(elapsed_ns)
        whole = fraction + made - move.profile.pulses_by(elapsed_ns)
        return rate, move.direction, max(Fraction(int(whole * FINE), FINE), Fraction(0))

    def _start(self, segments: list[Segment], direction: int, fraction: Fraction, rate: Fraction) -> None:
        if self.at_limit(direction):
            self._limit(direction)
            return
        self._cancel()
        profile = Profile(segments, phase=fraction, before=rate)
        if self._axis.moving:
            move = self._axis.train.move
            self._axis.train.replace(move.profile.cut_whole(self._clock.now - move.start_ns))
        self._axis.start(profile, direction)
        if profile.end_ns is not None:
            self._drop_end = self._clock.call_unless(profile.end_ns, self._over)

    def _over(self) -> None:
        self._drop_end = None
        if self._goal is None or (isinstance(self._goal, int) and self._goal == self.commanded):
            self._end()
        else:
            self._next_leg()

    def _cancel(self) -> None:
        if self._drop_end is not None:
            self._drop_end()
            self._drop_end = None

    def _halt(self) -> None:
        self._cancel()
        if self._axis.moving:
            self._axis.halt()

    def _end(self) -> None:
        self._goal = None
        if self._ended is not None:
            event, self._ended = self._ended, None
            event.succeed()

    def _disturbed(self) -> None:
        if (self._watch is None or not self._watch.is_alive) and (self._losing or self.commanded != self.position):
            self._watch = self._clock.process(self._return())

    @property
    def _losing(self) -> bool:
        return self._axis.moving and not self._axis.predictable

    def _return(self) -> Procedure:
        """Drive a servo back to where it should be, unless it is too far behind."""
        while (error := self.commanded - self.position) or self._losing:
            if self.following_error is not None and abs(error) > self.following_error:
                self.abort()
                self._origin += self.commanded - self.position
                self.stopped_by = "following error"
                self._at_limit(0)
            elif error and not self.moving and not self._axis.jammed:
                self._origin += error
                self._goal = self.commanded + error
                self._next_leg()
            self._clock.background += 1
            try:
                yield self._clock.timeout(MS)
            finally:
                self._clock.background -= 1

    def _check_limits(self) -> None:
        direction = self._axis.train.move.direction
        if self._axis.moving and self.at_limit(direction):
            self._limit(direction)

    def _limit(self, side: int) -> None:
        self.abort()
        self.stopped_by = f"{SIDES[side]} limit"
        self._at_limit(side)


def _fine(rate: float) -> Fraction:
    return Fraction(round(rate * FINE), FINE)
