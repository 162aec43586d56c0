"""Trapezoids between any two rates: the ramps are stairs with the area of the straight line.

rate   top ┐      ┌──────┐          each step lasts `interval` and has the mean rate of the line in it;
           │    ┌─┘      └─┐        the last, shorter one brings the ramp to `end`.  At the end of each step
           │  ┌─┘          └─┐      the phase is that of a constant acceleration.
           ───┴──────────────┴── t

Durations are whole nanoseconds, so that many changes of target do not make the numbers of a profile long.
"""

from fractions import Fraction
from functools import lru_cache
from math import isqrt
from typing import NamedTuple

from axistwin.core.units import MS, S
from axistwin.sim.motion.profile import Segment

MOST_STEPS = 250  # Largest number of steps of a ramp.
FINE = 1000  # Rates, and the fraction of a pulse at a change of target, are multiples of a thousandth.
LEAST = Fraction(1, FINE)


@lru_cache(maxsize=256)
def ramp(start: Fraction, end: Fraction, acceleration: Fraction) -> tuple[Segment, ...]:
    """Return a ramp between two rates in pulses/s, with a constant acceleration above 0 in pulses/s²."""
    change, sign = abs(end - start), 1 if end > start else -1
    interval = _interval(change, acceleration)
    step = acceleration * interval / S
    count = change // step
    levels = [Segment(start + sign * step * Fraction(2 * k + 1, 2), Fraction(interval, S)) for k in range(count)]
    rest_ns = (change - count * step) * S // acceleration
    last = [Segment(end - sign * (change - count * step) / 2, Fraction(rest_ns, S))] if rest_ns else []
    return (*levels, *last)


class Limits(NamedTuple):
    """What a motion keeps to, in pulses and seconds: rates above 0, and a start rate of 0 or more.

    A motor starts and stops from the rate `start` without a ramp.  A `down` of 0 means `up`.
    """

    top: Fraction
    start: Fraction
    up: Fraction
    down: Fraction = Fraction(0)

    def to_distance(self, rate: Fraction, distance: Fraction) -> list[Segment]:
        """Return segments that make `distance` pulses from `rate` on, and end at rest; they may end 1 ns late.

        If the distance is too short to stop, the segments are those of `to_rate(rate, 0)`.
        """
        top, up, down = max(self.top, LEAST), max(self.up, LEAST), max(self.down or self.up, LEAST)
        end = min(self.start, top)
        start = max(rate, end)
        if 0 < distance < (needed := _ramp_distance(start, end, down)):
            # The present rate, that of a stair of a ramp, may be half a step above the line.
            if needed - distance > start * _interval(max(start, top), down) / (2 * S):
                return self.to_rate(rate, Fraction(0))
            down = Fraction(-(-(start * start - end * end) * FINE // (2 * distance)), FINE)
        elif distance <= 0:
            return self.to_rate(rate, Fraction(0))
        square = (2 * up * down * distance + down * start**2 + up * end**2) / (up + down)
        peak = max(min(Fraction(isqrt(int(square * FINE * FINE)), FINE), top), end)
        if start > top:  # A lower speed was set in motion.
            peak = top
        elif peak < start:
            peak = start
        begin, stop = (start, peak, up if peak >= start else down), (peak, end, down)
        rest = max(distance - _pulses(*begin) - _pulses(*stop), Fraction(0))
        return [*ramp(*begin), Segment(peak, Fraction(-(-rest * S // peak), S)), *ramp(*stop)]

    def to_rate(self, rate: Fraction, wanted: Fraction) -> list[Segment]:
        """Return a ramp from `rate` to the rate `wanted`, which then lasts; 0 ends at rest."""
        if not wanted:
            return list(ramp(rate, min(self.start, rate), max(self.down or self.up, LEAST)))
        begin = max(rate, min(self.start, wanted))
        acceleration = max(self.up if wanted >= begin else self.down or self.up, LEAST)
        return [*ramp(begin, wanted, acceleration), Segment(wanted, None)]


def _interval(change: Fraction, acceleration: Fraction) -> int:
    """Return the duration of a stair in ns."""
    return int(MS * max(1, -(-change * S // (acceleration * MS * MOST_STEPS))))


@lru_cache(maxsize=256)
def _pulses(start: Fraction, end: Fraction, acceleration: Fraction) -> Fraction:
    """Return the pulses that a ramp makes."""
    return sum((step.rate * (step.seconds or 0) for step in ramp(start, end, acceleration)), Fraction(0))


def _ramp_distance(rate: Fraction, end: Fraction, deceleration: Fraction) -> Fraction:
    return (rate * rate - end * end) / (2 * deceleration)
