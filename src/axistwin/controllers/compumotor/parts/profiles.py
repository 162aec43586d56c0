"""Velocity profiles of chapter Indexer mode: linear ramps, updated every 2 ms, from and to the start/stop velocity.

A preset move makes the exact number of pulses.  A move too short for its ramps is a triangle without constant velocity.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from axistwin.controllers.compumotor.parts.pulses import Phase, VelocityProfile
from axistwin.controllers.compumotor.parts.ranges import VelocityRange
from axistwin.sim.motion.profile import Segment
from axistwin.sim.motion.quantised_ramp import QuantisedRamp, quantised_levels

UPDATE = Fraction(1, 500)  # Seconds between two levels of a ramp.


@dataclass(frozen=True)
class Speed:
    """Step rate in pulses/s, acceleration in pulses/s², their velocity range, and the start/stop velocity (D6h)."""

    rate: Fraction
    acceleration: Fraction
    range: VelocityRange
    start_stop: Fraction = Fraction(0)

    @property
    def base(self) -> Fraction:
        """The velocity at which ramps begin and end: a multiple of the range's resolution."""
        unit = self.range.resolution
        return (2 * self.start_stop + unit) // (2 * unit) * unit


def _between(start: Fraction, end: Fraction, speed: Speed, unit: Fraction) -> tuple[Segment, ...]:
    return tuple(quantised_levels(start, end, speed.acceleration * UPDATE, UPDATE, unit))


@lru_cache(maxsize=64)
def _way_up(speed: Speed) -> QuantisedRamp:
    """Return the acceleration from zero velocity to the rate; empty at or below the start/stop velocity."""
    base = speed.base
    if speed.rate <= base:
        return QuantisedRamp((), speed.rate, UPDATE)
    first = (Segment(base, UPDATE),) if base else ()
    return QuantisedRamp((*first, *_between(base, speed.rate, speed, speed.range.resolution)), speed.rate, UPDATE)


@lru_cache(maxsize=256)
def preset(speed: Speed, distance: int) -> VelocityProfile:
    """Return the profile of a preset move of `distance` pulses (at least 1)."""
    shape = _way_up(speed).trapezoid(distance)
    up, down = shape.up, tuple(reversed(shape.up))
    phases: tuple[tuple[Phase, tuple[Segment, ...]], ...]
    if shape.whole:
        phases = ((Phase.ACCELERATING, up), (Phase.CONSTANT, (shape.along,)), (Phase.DECELERATING, down))
    else:
        phases = ((Phase.ACCELERATING, (*up, shape.along)), (Phase.DECELERATING, down))
    return VelocityProfile(phases, speed.range.maximum)


def continuous(speed: Speed) -> VelocityProfile:
    """Return the profile of a continuous move: acceleration from rest, then constant velocity without end."""
    on = (Segment(speed.rate, None),)
    return VelocityProfile(((Phase.ACCELERATING, _way_up(speed).up), (Phase.CONSTANT, on)), speed.range.maximum)


def changed(rate: Fraction, before: VelocityRange, speed: Speed) -> VelocityProfile:
    """Return the ramp from `rate`, in velocity range `before`, to a rate above zero, then endless motion."""
    unit, base = max(before.resolution, speed.range.resolution), speed.base
    phase = Phase.ACCELERATING if speed.rate > rate else Phase.DECELERATING
    ramp: tuple[Segment, ...] = ()
    if max(rate, speed.rate) > base:
        ramp = _between(max(rate, base), max(speed.rate, base), speed, unit)
        at_base = (Segment(base, UPDATE),) if min(rate, speed.rate) < base else ()
        ramp = (*at_base, *ramp) if phase is Phase.ACCELERATING else (*ramp, *at_base)
    return VelocityProfile(((phase, ramp), (Phase.CONSTANT, (Segment(speed.rate, None),))), speed.range.maximum)


def stopping(rate: Fraction, speed: Speed) -> VelocityProfile:
    base = min(speed.base, rate)
    last = (Segment(base, UPDATE),) if 0 < base < rate else ()
    ramp = _between(rate, base, speed, speed.range.resolution)
    return VelocityProfile(((Phase.DECELERATING, (*ramp, *last)),), speed.range.maximum)
