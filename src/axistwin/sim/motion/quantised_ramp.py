"""Quantised ramps: at fixed intervals, hardware sets a new rate that is a multiple of its resolution.

rate  top ┐       ┌────────┐          the ideal rate rises by `increment` every `interval`;
          │    ┌──┘        └──┐       the level is the ideal rate rounded to a multiple of `unit`,
          │ ┌──┘              └──┐    so a slow ramp stays on each level for several intervals
        ──┴─┴────────────────────┴─ t
"""

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from math import lcm

from axistwin.sim.motion.profile import Segment


def quantised_levels(
    start: Fraction, end: Fraction, increment: Fraction, interval: Fraction, unit: Fraction
) -> list[Segment]:
    """Return the levels between the rates `start` and `end`, without both ends and without levels of rate 0.

    There are at most as many levels as units, or as increments, between the two rates.
    """
    rising = end > start
    steps = -(-abs(end - start) // increment) - 1
    q = lcm((start / unit).denominator, (increment / unit).denominator)
    a, b = int(start / unit * q), int(increment / unit * q) * (1 if rising else -1)
    counted = _by_step(a, b, q, steps) if abs(b) >= q else _by_level(a, b, q, steps)
    return [Segment(level * unit, count * interval) for level, count in counted if level and count]


def _by_step(a: int, b: int, q: int, steps: int) -> Iterable[tuple[int, int]]:
    """Yield the levels of a ramp whose level changes at each increment, each with its number of intervals."""
    return (((2 * (a + k * b) + q) // (2 * q), 1) for k in range(1, steps + 1))


def _by_level(a: int, b: int, q: int, steps: int) -> Iterable[tuple[int, int]]:
    """Yield rates of a slow ramp, each with the number of update periods that it lasts."""
    if steps < 1:
        return
    first, last = ((2 * (a + k * b) + q) // (2 * q) for k in (1, steps))
    done = 0
    for level in range(first, last + 1) if b > 0 else range(first, last - 1, -1):
        edge = 2 * q * (level + 1) - q - 2 * a if b > 0 else 2 * a + q - 2 * q * level
        last_interval = min(steps, -(-edge // (2 * b)) - 1 if b > 0 else edge // (-2 * b))
        yield level, last_interval - done
        done = last_interval


@dataclass(frozen=True)
class Trapezoid:
    """Profile of a preset move; `whole` is True if it reaches the maximum velocity."""

    up: tuple[Segment, ...]
    along: Segment
    whole: bool

    @property
    def segments(self) -> tuple[Segment, ...]:
        """All segments of the velocity profile in order of time."""
        return (*self.up, self.along, *reversed(self.up))


@dataclass(frozen=True)
class QuantisedRamp:
    """Acceleration in steps of constant velocity; the deceleration is its mirror image."""

    up: tuple[Segment, ...]
    max_rate: Fraction
    interval: Fraction

    @cached_property
    def _pulses(self) -> list[Fraction]:
        return [Fraction(0), *accumulate(level.rate * (level.seconds or 0) for level in self.up)]

    def trapezoid(self, distance: int) -> Trapezoid:
        """Return a profile of exactly `distance` pulses (at least 1).

        An acceleration that does not fit twice ends after the last interval that fits; the rest runs at that rate.
        """
        if 2 * self._pulses[-1] <= distance:
            left_over = distance - 2 * self._pulses[-1]
            return Trapezoid(self.up, Segment(self.max_rate, left_over / self.max_rate), whole=left_over > 0)
        fits = bisect_right(self._pulses, Fraction(distance, 2)) - 1
        level = self.up[fits].rate
        intervals = (Fraction(distance, 2) - self._pulses[fits]) // (level * self.interval)
        up = (*self.up[:fits], Segment(level, intervals * self.interval))
        left_over = distance - 2 * (self._pulses[fits] + level * intervals * self.interval)
        return Trapezoid(up, Segment(level, left_over / level), whole=False)
