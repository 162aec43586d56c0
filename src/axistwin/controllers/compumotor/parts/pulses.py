"""The pulse generator, which outputs velocity profiles, counts their pulses, and reports changes of phase.

Positions are signed + and -; physical directions are CW (+1) and CCW (-1).  Command 14h assigns signs to directions.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cached_property, lru_cache, partial

from axistwin.core.units import S
from axistwin.plant.stepper import StepperAxis
from axistwin.sim.clock import Clock, Moment
from axistwin.sim.motion.profile import Profile, Segment
from axistwin.sim.pins import Pin


class Phase(Enum):
    """Phases of a motion: accelerating, constant velocity, decelerating, at rest."""

    REST = "zero velocity"
    ACCELERATING = "accelerating"
    CONSTANT = "constant, non-zero velocity"
    DECELERATING = "decelerating"


RAMPS = (Phase.ACCELERATING, Phase.DECELERATING)
AT_REST = Profile(())
MOST_SEGMENTS = 16  # Maximum number of segments that a stream appends to one profile; after that, a new profile begins.


@dataclass(frozen=True)
class VelocityProfile:
    """A velocity profile, with its segments grouped by phase.

    `clock`: the highest pulse rate of the range, which sets the width of the STEP pulse.  `of_move`: True for the
    profile of a move, whose constant velocity causes a message.
    """

    phases: tuple[tuple[Phase, tuple[Segment, ...]], ...]
    clock: Fraction = Fraction(1_092_266)
    of_move: bool = True

    @property
    def segments(self) -> Iterable[Segment]:
        """The segments of all phases, in order of time."""
        return (segment for _, segments in self.phases for segment in segments)

    @cached_property
    def from_rest(self) -> Profile:
        """Pulse profile for a start from rest."""
        return Profile(self.segments)

    @cached_property
    def timetable(self) -> tuple[tuple[int, Phase], ...]:
        """Start time of each phase in ns, counted from the start of the profile.  Phases of duration 0 are left out."""
        return tuple(self._begins())

    def _begins(self) -> Iterable[tuple[int, Phase]]:
        at = Fraction(0)
        for phase, segments in self.phases:
            if any(seconds is None or seconds for _, seconds in segments):
                yield int(at * S) if at else 0, phase
            for segment in segments:
                if segment.seconds is None:
                    return
                at += segment.seconds
        yield int(at * S), Phase.REST


class PulseGenerator:
    """Outputs pulses to the motor and counts them."""

    def __init__(self, clock: Clock, axis: StepperAxis, direction: Pin) -> None:
        self.clock, self.axis, self._direction = clock, axis, direction
        self.cw_is_plus = True  # True if CW is the + direction (command 14h).
        self.sign = +1
        self.phase = Phase.REST
        self.velocity_profile = VelocityProfile(())
        self.on_phase: Callable[[Phase], None] = lambda phase: None
        self._output, self._start_ns, self._origin = AT_REST, 0, 0
        self._excursion_origin, self._unmade_at_reset = 0, axis.unmade
        self._pulse_ns: int | None = None  # Time of the last joystick pulse in ns.
        self._plan = 0
        self.changed = Moment(clock)  # A phase of the motion begins.

    @property
    def moving(self) -> bool:
        return self.phase is not Phase.REST

    @property
    def ending(self) -> bool:
        return self.phase is Phase.DECELERATING and self.velocity_profile.timetable[-1][1] is Phase.REST

    @property
    def physical(self) -> int:
        """Physical direction of the present or most recent motion: +1 is CW, -1 is CCW."""
        return self.sign if self.cw_is_plus else -self.sign

    @property
    def position(self) -> int:
        """Net number of pulses since the reset; each counts with the sign that its direction had at that time."""
        unmade = self.axis.unmade - self._unmade_at_reset
        return self._issued - (unmade if self.cw_is_plus else -unmade)

    @property
    def _issued(self) -> int:
        return self._origin + self.sign * self._output.pulses_by(self._elapsed_ns)

    @property
    def excursion(self) -> int:
        """Net pulses since the motor last left zero velocity."""
        return self.position - self._excursion_origin

    @property
    def rate(self) -> Fraction:
        return self._output.rate_at(self._elapsed_ns) if self.moving else Fraction(0)

    def ns_until(self, pulses: int) -> int:
        """Return the time in ns that the present profile needs for the next `pulses` pulses.  `pulses`: at least 1."""
        count = self._output.pulses_by(self._elapsed_ns) + pulses
        return self._output.pulse_ns(count) + 1 - self._elapsed_ns

    def within(self, duration_ns: int) -> int:
        """Return the number of pulses in the next `duration_ns` nanoseconds of the present profile."""
        elapsed_ns = self._elapsed_ns
        return self._output.pulses_by(elapsed_ns + duration_ns) - self._output.pulses_by(elapsed_ns)

    @property
    def step_level(self) -> bool:
        """Level of STEP: high for half a period of the range's highest frequency after each pulse."""
        width_ns = int(S / (2 * self.velocity_profile.clock))
        return self._output.pulses_by(self._elapsed_ns) > self._output.pulses_by(self._elapsed_ns - width_ns)

    @property
    def _elapsed_ns(self) -> int:
        return self.clock.now - self._start_ns

    def start(self, profile: VelocityProfile, sign: int, *, further: bool = False) -> None:
        """Start a velocity profile at rest; `further`: the previous excursion continues."""
        if not further:
            self._excursion_origin = self.position
        self.face(sign)
        self._begin(profile.from_rest)
        self._follow(profile)

    def change(self, profile: VelocityProfile) -> None:
        """Change to another profile in the same direction; ignored after the last pulse."""
        if self._output.over(self._elapsed_ns):
            return
        self._output = self._output.cut(self._elapsed_ns, profile.segments)
        self.axis.replace(self._output)
        self._follow(profile)

    def run(self, profile: VelocityProfile, sign: int, *, further: bool = False) -> None:
        """Replace any motion, without a ramp, by one in the direction `sign`; in the same one, the fraction is kept.

        `further`: the previous excursion continues after a change of direction or zero velocity.
        """
        if sign != self.sign:
            self.kill()
        if not self.moving:
            self.start(profile, sign, further=further)
        elif len(self._output.segments) < MOST_SEGMENTS:
            self.change(profile)
        else:
            self._continue(profile.segments)
            self._follow(profile)

    @property
    def room(self) -> int:
        """Return how many segments `append` accepts now; 0: velocities must be output one by one."""
        if not (self.moving and self.axis.free):
            return 0
        return MOST_SEGMENTS - len(self._output.segments) or MOST_SEGMENTS

    def append(self, segments: Sequence[Segment]) -> None:
        """Continue at new velocities in the same direction; that of the last of the `segments` is kept."""
        added = (*segments[:-1], Segment(segments[-1].rate, None))
        if len(self._output.segments) < MOST_SEGMENTS:
            self._output = self._output.cut(self._elapsed_ns, added)
            self.axis.replace(self._output)
        else:
            self._continue(added)

    def hold(self) -> None:
        """Keep the present velocity until another profile begins."""
        if self.moving:
            constant = (Segment(self.rate, None),)
            self.change(VelocityProfile(((Phase.CONSTANT, constant),), self.velocity_profile.clock, of_move=False))

    def kill(self) -> None:
        """Stop the pulses at once, without deceleration."""
        if self.moving:
            self._output = self._output.cut_whole(self._elapsed_ns)
            self.axis.halt()
            self._plan += 1
            self._enter(Phase.REST)

    def face(self, sign: int) -> None:
        """Set the direction of the next pulses, and the level of the DIRECTION output.  The level is high for CW."""
        self._origin, self._output = self._issued, AT_REST
        self.sign = sign
        self._direction.set(self.physical > 0)

    def pulse(self) -> None:
        """Output one pulse of a motion by joystick; its rate follows from the time since the previous pulse."""
        self._origin = self._issued
        since_ns = None if self._pulse_ns is None else self.clock.now - self._pulse_ns
        self._pulse_ns = self.clock.now
        self._begin(one_pulse(since_ns))

    def leave_zero(self) -> None:
        self._excursion_origin = self.position
        self._pulse_ns = None

    def _continue(self, segments: Iterable[Segment]) -> None:
        """Replace the present profile; the fraction of the present pulse is kept, so pulses continue without a gap."""
        pulses, fraction = self._output.phase_at(self._elapsed_ns)
        self._origin += self.sign * pulses
        self._begin(Profile(segments, fraction, self.rate))

    def _begin(self, output: Profile) -> None:
        self._output, self._start_ns = output, self.clock.now
        self.axis.start(output, self.physical)

    def _follow(self, profile: VelocityProfile) -> None:
        self._plan += 1
        self.velocity_profile = profile
        plan = self._plan
        for at_ns, phase in profile.timetable:
            if at_ns == 0:
                self._enter(phase)
            else:
                self.clock.call_later(at_ns, partial(self._enter_as_planned, plan, phase))
            # Return if the callback `on_phase` has stopped the pulses or started another velocity profile.
            if plan != self._plan:
                return

    def _enter_as_planned(self, plan: int, phase: Phase) -> None:
        if plan == self._plan:
            self._enter(phase)

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        self.changed.happens()
        self.on_phase(phase)


@lru_cache(maxsize=64)
def one_pulse(since_ns: int | None) -> Profile:
    """Return a profile of one pulse in the next nanosecond; `since_ns` after the previous one gives its rate."""
    if not since_ns:
        return Profile((Segment(Fraction(S), Fraction(1, S)),))
    rate = Fraction(S, since_ns)
    return Profile((Segment(rate, Fraction(since_ns, S)),), phase=1 - rate / S, before=rate)
