"""A velocity profile: the pulse rate of a motion as a list of segments of constant rate, calculated exactly.

Rates and durations are rational numbers, converted to integers over two common denominators.  The phase (pulses since
the start, with fraction) is therefore exact at any time, and the n-th pulse time is a formula, not a loop.

    rate
      │      ┌────────┐            segment: starts[j], phases[j], rates[j]
      │    ┌─┘        └─┐          phase(t) = phases[j] + rates[j] * (t - starts[j])
      │  ┌─┘            └─┐        pulse n happens when the phase reaches n;  n = 1, 2, ...
      └──┴────────────────┴── t    after the last segment: no pulses
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from math import gcd, lcm
from typing import NamedTuple

from axistwin.core.lazy import NDArray, np
from axistwin.core.units import S

BLOCK = 1 << 12  # Smallest number of pulses that are calculated one by one before the pattern is repeated.
MOST_BLOCK = 1 << 16  # Largest number of pulses that are calculated one by one.


class Segment(NamedTuple):
    """A part of a motion with constant velocity, i.e. with a constant pulse rate."""

    rate: Fraction  # Pulse rate in pulses/s.
    seconds: Fraction | None  # Duration; None for a segment that never ends.


class Profile:
    """A velocity profile: a list of segments, each with a constant pulse rate.  The first segment begins at time 0.

    Internal times are in units of 1/`ticks` s, phases in units of 1/`parts` pulse; both are exact.
    """

    def __init__(
        self, segments: Iterable[Segment], phase: Fraction = Fraction(0), before: Fraction = Fraction(0)
    ) -> None:
        """Convert segments to integers.  `phase`: fraction of a pulse before; `before`: rate before."""
        self.phase, self.before = phase, before
        self.segments: Sequence[Segment] = tuple(s for s in segments if s.seconds is None or s.seconds)
        self.ticks = lcm(*{s.seconds.denominator for s in self.segments if s.seconds is not None})
        self.per_rate = lcm(phase.denominator, *{s.rate.denominator for s in self.segments})
        self.parts = self.per_rate * self.ticks
        self.rates: list[int] = []  # Pulse rate of each segment, in parts per tick.
        self.starts, self.phases = [0], [phase.numerator * (self.parts // phase.denominator)]
        self._lay_out(self.segments)

    def _lay_out(self, segments: Sequence[Segment]) -> bool:
        """Append rates, starts and phases as integers; return False if a number is not exact as one."""
        per_rate, per_second, start, phase = self.per_rate, self.ticks, self.starts[-1], self.phases[-1]
        duration, ticks, rest = None, 0, 0
        for rate, seconds in segments:
            numerator, denominator = rate.as_integer_ratio()
            number, unfit = divmod(numerator * per_rate, denominator)
            self.rates.append(number)
            # Convert the duration from seconds to ticks only once for successive segments of the same duration.
            if seconds is not None and seconds is not duration:
                numerator, denominator = seconds.as_integer_ratio()
                duration, (ticks, rest) = seconds, divmod(numerator * per_second, denominator)
            if unfit or rest:
                return False
            if seconds is None:
                break
            start, phase = start + ticks, phase + number * ticks
            self.starts.append(start)
            self.phases.append(phase)
        self.endless = len(self.starts) == len(self.segments)
        self.pulses: int | None = None if self.endless else self.phases[-1] // self.parts  # In total; None: endless.
        self.end_ns: int | None = None if self.endless else self.starts[-1] * S // self.ticks
        """Time in ns from the start to the end of the last segment; None for an endless motion."""
        return True

    def _segment_at(self, ticks_s: int) -> int:
        """Return the index of the segment that contains the given time.  The time is in units of 1/S tick."""
        return bisect_right(self.starts, ticks_s // S) - 1

    def _phase_s(self, elapsed_ns: int) -> int:
        """Return the commanded position at a given time, as an exact integer.  The unit is 1/(parts * S) pulse."""
        ticks_s = elapsed_ns * self.ticks
        j = min(self._segment_at(ticks_s), len(self.rates) - 1)
        return self.phases[j] * S + self.rates[j] * (ticks_s - self.starts[j] * S)

    def over(self, elapsed_ns: int) -> bool:
        """Return True if the last segment of the profile has ended at the time `elapsed_ns`."""
        return self.end_ns is not None and elapsed_ns >= self.end_ns

    def pulses_by(self, elapsed_ns: int) -> int:
        """Return the number of pulses up to and including the time `elapsed_ns`."""
        if elapsed_ns < 0 or not self.rates:
            return 0
        if self.pulses is not None and self.over(elapsed_ns):
            return self.pulses
        # Pulse times are rounded down to whole nanoseconds, e.g. a pulse at 5.9 ns counts as a pulse at 5 ns.
        return max(0, -(-self._phase_s(elapsed_ns + 1) // (self.parts * S)) - 1)

    def pulse_ns(self, n: int) -> int:
        """Return the time in ns from the start of the profile to pulse `n`; the first pulse is pulse 1."""
        j = bisect_left(self.phases, n * self.parts, 1) - 1
        return (self.starts[j] * S + (n * self.parts - self.phases[j]) * S // self.rates[j]) // self.ticks

    def rate_at(self, elapsed_ns: int) -> Fraction:
        """Return the pulse rate in pulses/s at a time; the rate is 0 before and after the motion."""
        if elapsed_ns < 0 or self.over(elapsed_ns) or not self.segments:
            return Fraction(0)
        return self.segments[self._segment_at(elapsed_ns * self.ticks)].rate

    def phase_at(self, elapsed_ns: int) -> tuple[int, Fraction]:
        """Return the commanded position at a time as whole pulses and fraction, e.g. (12, 1/4) for 12.25."""
        pulses, rest_s = divmod(self._phase_s(elapsed_ns), self.parts * S)
        return pulses, Fraction(rest_s, self.parts * S)

    def trend(self, elapsed_ns: int) -> int:
        """Return +1 during acceleration, -1 during deceleration, and 0 at constant rate or at rest."""
        if elapsed_ns < 0 or self.over(elapsed_ns) or not self.segments:
            return 0
        j = self._segment_at(elapsed_ns * self.ticks)
        rate = self.segments[j].rate
        if j + 1 < len(self.segments) and self.segments[j + 1].rate > rate:
            return +1
        return -1 if j > 0 and self.segments[j - 1].rate > rate else 0

    def cut(self, elapsed_ns: int, then: Iterable[Segment] = ()) -> "Profile":
        """Return a copy up to the time `elapsed_ns`, continued by the segments `then`."""
        if self.over(elapsed_ns):
            return self
        ticks_s = elapsed_ns * self.ticks
        j = self._segment_at(ticks_s)
        since_s = ticks_s - self.starts[j] * S
        added = tuple(segment for segment in then if segment.seconds is None or segment.seconds)
        if since_s:
            added = (Segment(self.segments[j].rate, _seconds(since_s, S * self.ticks)), *added)
        return self._extended(j, added) or Profile((*self.segments[:j], *added), self.phase, self.before)

    def cut_whole(self, elapsed_ns: int) -> "Profile":
        """Return a copy up to the time `elapsed_ns`, with the pulse of this nanosecond even if due later in it."""
        made, fraction = self.phase_at(elapsed_ns)
        if self.over(elapsed_ns) or (pulses := self.pulses_by(elapsed_ns)) == made:
            return self.cut(elapsed_ns)
        rate = self.rate_at(elapsed_ns)
        return self.cut(elapsed_ns, [Segment(rate, (pulses - made - fraction) / rate)])

    def _extended(self, kept: int, added: tuple[Segment, ...]) -> "Profile | None":
        """Return the first `kept` segments and `added`; None if the units 1/`ticks` s, 1/`parts` pulse do not fit."""
        profile = Profile.__new__(Profile)
        profile.__dict__.update(self.__dict__)
        profile.segments = (*self.segments[:kept], *added)
        profile.rates = self.rates[:kept]
        profile.starts, profile.phases = self.starts[: kept + 1], self.phases[: kept + 1]
        return profile if profile._lay_out(added) else None

    def scaled(self, ratio: Fraction) -> "Profile":
        """Return a copy of the profile with all pulse rates multiplied by a factor."""
        return Profile(Segment(segment.rate * ratio, segment.seconds) for segment in self.segments)

    def fill_pulse_times(self, first: int, offset_ns: int, out: "NDArray[np.int64]") -> None:
        """Fill `out` with the times of consecutive pulses from number `first` (1 or more), plus `offset_ns`."""
        n, last = first, first + len(out) - 1
        for j in range(len(self.rates)):
            segment_last = last if j + 1 >= len(self.phases) else min(last, self.phases[j + 1] // self.parts)
            if n <= segment_last:
                self._fill(j, n, offset_ns, out[n - first : segment_last - first + 1])
                n = segment_last + 1

    def _fill(self, j: int, n: int, offset_ns: int, out: "NDArray[np.int64]") -> None:
        """Fill `out` with the times of consecutive pulses from number n, all of segment j.

        The period is a fraction of b nanoseconds, so after b pulses the pattern repeats a whole number of nanoseconds
        later.  One block is calculated, and the others are shifted copies of it.
        """
        period, b = self.parts * S, self.rates[j] * self.ticks
        common = gcd(period, b)
        period, b = period // common, b // common
        start = (self.starts[j] * S * self.rates[j] + (n * self.parts - self.phases[j]) * S) // common
        block = b * -(-BLOCK // b)
        if block >= len(out) or block > MOST_BLOCK:
            self._fill_block(start, period, b, offset_ns, out)
            return
        pattern = np.empty(block, np.int64)
        self._fill_block(start, period, b, offset_ns, pattern)
        whole = len(out) // block
        moves = np.arange(whole + 1, dtype=np.int64) * (period * (block // b))
        np.add(pattern, moves[:whole, None], out=out[: whole * block].reshape(whole, block))
        np.add(pattern[: len(out) - whole * block], moves[whole], out=out[whole * block :])

    @staticmethod
    def _fill_block(start: int, period: int, b: int, offset_ns: int, out: "NDArray[np.int64]") -> None:
        """Write evenly spaced pulse times: out[k] = (start + period * k) // b + offset_ns."""
        whole, fraction = divmod(period, b)
        if fraction * MOST_BLOCK >= 1 << 62:
            out[:] = [(start + period * k) // b + offset_ns for k in range(len(out))]
            return
        for begin in range(0, len(out), MOST_BLOCK):
            piece = out[begin : begin + MOST_BLOCK]
            count = np.arange(len(piece), dtype=np.int64)
            base, rest = divmod(start + period * begin, b)
            np.multiply(count, fraction, out=piece)
            piece += rest
            piece //= b
            count *= whole
            piece += count
            piece += base + offset_ns


@lru_cache(maxsize=1024)
def _seconds(parts: int, per_second: int) -> Fraction:
    return Fraction(parts, per_second)
