"""The pulse generator: it follows a velocity profile, and reports the begin of each phase.

Positions are counted in + and -, physical directions are CW (+1) and CCW (-1); command 14h says which is which.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cached_property, lru_cache, partial

from axistwin.controllers.product import PulseAxis
from axistwin.motion.profile import Profile, Segment
from axistwin.sim.clock import Clock, Event
from axistwin.sim.pins import Pin
from axistwin.units import S


class Phase(Enum):
    """What the velocity does."""

    REST = "zero velocity"
    ACCELERATING = "accelerating"
    CONSTANT = "constant, non-zero velocity"
    DECELERATING = "decelerating"


RAMPS = (Phase.ACCELERATING, Phase.DECELERATING)
AT_REST = Profile(())
MOST_SEGMENTS = 16
"""Of one stroke, where one velocity follows the other without end."""


@dataclass(frozen=True)
class VelocityProfile:
    """What the pulse generator is to do: segments, phase by phase.

    `clock`: the highest pulse rate of the range, which sets the width of the STEP pulse.  `of_move`: it is what a move
    asked for, so that its constant velocity is worth a message.
    """

    phases: tuple[tuple[Phase, tuple[Segment, ...]], ...]
    clock: Fraction = Fraction(1_092_266)
    of_move: bool = True

    @property
    def segments(self) -> Iterable[Segment]:
        """All segments."""
        return (segment for _, segments in self.phases for segment in segments)

    @cached_property
    def profile(self) -> Profile:
        """The velocity profile from zero velocity."""
        return Profile(self.segments)

    @cached_property
    def timetable(self) -> tuple[tuple[int, Phase], ...]:
        """When each phase begins, in ns from the velocity profile's start; a phase without duration is left out."""
        return tuple(self._begins())

    def _begins(self) -> Iterable[tuple[int, Phase]]:
        at = Fraction(0)
        for phase, segments in self.phases:
            if any(segment.seconds != 0 for segment in segments):
                yield int(at * S), phase
            for segment in segments:
                if segment.seconds is None:
                    return
                at += segment.seconds
        yield int(at * S), Phase.REST


class PulseGenerator:
    """Gives pulses to the motor."""

    def __init__(self, clock: Clock, axis: PulseAxis, direction: Pin) -> None:
        self.clock, self.axis, self._direction = clock, axis, direction
        self.cw_is_plus = True
        """Command 14h."""
        self.sign = +1
        """The present or most recent direction of travel."""
        self.phase = Phase.REST
        self.on_phase: Callable[[Phase], None] = lambda phase: None
        self._profile, self._start_ns, self._origin = AT_REST, 0, 0
        self._excursion_origin = 0
        self._pulse_ns: int | None = None  # when the latest pulse from outside came, in this excursion
        self._velocity_profile = VelocityProfile(())
        self._plan = 0
        self._changed: Event | None = None

    # What is going on

    @property
    def moving(self) -> bool:
        """Whether the velocity is not zero."""
        return self.phase is not Phase.REST

    @property
    def ending(self) -> bool:
        """True while the velocity decreases to zero."""
        return self.phase is Phase.DECELERATING and self._velocity_profile.timetable[-1][1] is Phase.REST

    @property
    def physical(self) -> int:
        """+1 CW, -1 CCW: the present or most recent direction."""
        return self.sign if self.cw_is_plus else -self.sign

    @property
    def position(self) -> int:
        """Net pulses since the board was reset, + and - as they were at the time."""
        return self._origin + self.sign * self._profile.pulses_by(self._elapsed_ns)

    @property
    def excursion(self) -> int:
        """Net pulses since zero velocity was left last."""
        return self.position - self._excursion_origin

    @property
    def rate(self) -> Fraction:
        """Pulses per second."""
        return self._profile.rate_at(self._elapsed_ns) if self.moving else Fraction(0)

    @property
    def of_move(self) -> bool:
        """Whether the present velocity profile is what a move asked for."""
        return self._velocity_profile.of_move

    def ns_until(self, pulses: int) -> int:
        """From now until so many more pulses (at least 1) are out; as things are now they must come."""
        count = self._profile.pulses_by(self._elapsed_ns) + pulses
        return self._profile.pulse_ns(count) + 1 - self._elapsed_ns

    @property
    def velocity_profile(self) -> VelocityProfile:
        """The present or most recent velocity profile."""
        return self._velocity_profile

    @property
    def step_level(self) -> bool:
        """The level of STEP: high for half a period of the range's highest frequency after each pulse."""
        width_ns = int(S / (2 * self._velocity_profile.clock))
        return self._profile.pulses_by(self._elapsed_ns) > self._profile.pulses_by(self._elapsed_ns - width_ns)

    @property
    def _elapsed_ns(self) -> int:
        return self.clock.now - self._start_ns

    def changed(self) -> Event:
        """An event that happens when the phase changes next."""
        if self._changed is None:
            self._changed = self.clock.event()
        return self._changed

    # What is to be done

    def start(self, velocity_profile: VelocityProfile, sign: int, *, further: bool = False) -> None:
        """From zero velocity; `further`: it counts as part of the excursion before."""
        if not further:
            self._excursion_origin = self.position
        self.face(sign)
        self._profile, self._start_ns = velocity_profile.profile, self.clock.now
        self.axis.start(self._profile, self.physical)
        self._follow(velocity_profile)

    def change(self, velocity_profile: VelocityProfile) -> None:
        """Follow another velocity profile from now on, in the same direction; not after the last pulse."""
        if self._profile.over(self._elapsed_ns):
            return
        self._profile = self._profile.cut(self._elapsed_ns, velocity_profile.segments)
        self.axis.replace(self._profile)
        self._follow(velocity_profile)

    def run(self, velocity_profile: VelocityProfile, sign: int, *, further: bool = False) -> None:
        """Another velocity at once, in any direction; in the same one the fraction of a pulse is kept.

        `further`: it counts as part of the excursion before.
        """
        if sign != self.sign:
            self.kill()
        if not self.moving:
            self.start(velocity_profile, sign, further=further)
        elif len(self._profile.segments) < MOST_SEGMENTS:
            self.change(velocity_profile)
        else:
            fraction, rate = self._profile.fraction_at(self._elapsed_ns), self.rate
            self._profile = self._profile.cut(self._elapsed_ns)
            self._origin = self.position
            self._profile, self._start_ns = Profile(velocity_profile.segments, fraction, rate), self.clock.now
            self.axis.start(self._profile, self.physical)
            self._follow(velocity_profile)

    def hold(self) -> None:
        """The velocity of this instant is kept."""
        if self.moving:
            on = (Segment(self.rate, None),)
            self.change(VelocityProfile(((Phase.CONSTANT, on),), self._velocity_profile.clock, of_move=False))

    def kill(self) -> None:
        """No more pulses, at once."""
        if self.moving:
            self._profile = self._profile.cut(self._elapsed_ns)
            self.axis.halt()
            self._plan += 1
            self._enter(Phase.REST)

    def face(self, sign: int) -> None:
        """The direction of what comes now: the level of DIRECTION, high for CW."""
        self._origin, self._profile = self.position, AT_REST
        self.sign = sign
        self._direction.set(self.physical > 0)

    def pulse(self) -> None:
        """A single pulse from outside (the joystick), in the direction of `sign`, in the next nanosecond.

        It is as fast as it is far from the one before.
        """
        self._origin = self.position
        since_ns = None if self._pulse_ns is None else self.clock.now - self._pulse_ns
        self._profile, self._start_ns = one_pulse(since_ns), self.clock.now
        self._pulse_ns = self.clock.now
        self.axis.start(self._profile, self.physical)

    def leave_zero(self) -> None:
        """A new excursion begins here."""
        self._excursion_origin = self.position
        self._pulse_ns = None

    def _follow(self, velocity_profile: VelocityProfile) -> None:
        self._plan += 1
        self._velocity_profile = velocity_profile
        plan = self._plan
        for at_ns, phase in velocity_profile.timetable:
            if at_ns == 0:
                self._enter(phase)
            else:
                self.clock.call_later(at_ns, partial(self._enter_as_planned, plan, phase))
            if plan != self._plan:  # a subscriber has changed the velocity profile
                return

    def _enter_as_planned(self, plan: int, phase: Phase) -> None:
        if plan == self._plan:
            self._enter(phase)

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        if self._changed is not None:
            event, self._changed = self._changed, None
            event.succeed()
        self.on_phase(phase)


@lru_cache(maxsize=64)
def one_pulse(since_ns: int | None) -> Profile:
    """A pulse in the next nanosecond, so long after the one before, and nothing more until the next is due."""
    if not since_ns:
        return Profile((Segment(Fraction(S), Fraction(1, S)),))
    rate = Fraction(S, since_ns)
    return Profile((Segment(rate, Fraction(since_ns, S)),), phase=1 - rate / S, before=rate)
