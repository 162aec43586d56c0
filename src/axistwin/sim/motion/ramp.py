"""Stepped ramps: the rate rises by a fixed increment at fixed intervals, and falls the same way.

rate   top ┐      ┌──────────┐
           │    ┌─┘          └─┐            levels: start, start + increment, ... below top
   levels  ┤  ┌─┘              └─┐          each lasts one interval
     start ┘┌─┘                  └─┐
           ─┴──────────────────────┴── t
"""

from bisect import bisect_right
from fractions import Fraction
from functools import lru_cache
from itertools import accumulate

from axistwin.sim.motion.profile import Profile, Segment


class Ramp:
    """The table of levels from `start` to below `top`, all in pulses/s; `interval` in seconds.

    A `top` at or below `start` means no ramp: the whole motion runs at `top`.
    """

    def __init__(self, start: Fraction, top: Fraction, increment: Fraction, interval: Fraction) -> None:
        self.top, self.interval = top, interval
        self.levels = [start + k * increment for k in range(max(0, -((start - top) // increment)))]
        self.pulses = [Fraction(0), *accumulate(level * interval for level in self.levels)]
        """Number of pulses in the first k levels, for k = 0, 1 and so on."""
        self.index = lru_cache(maxsize=64)(self._index)

    def run(self) -> Profile:
        """Return the velocity profile of a run: a ramp to the rate `top`, then endless motion."""
        return Profile((*self._level_segments(len(self.levels)), Segment(self.top, None)))

    def _index(self, distance: int) -> Profile:
        """Return the profile of exactly `distance` pulses: acceleration, constant rate, deceleration.

        A distance too short for the whole ramp uses as many levels as fit twice.  The remaining pulses run at the next
        level, a short plateau.
        """
        if distance == 0:
            return Profile(())
        fits = bisect_right(self.pulses, Fraction(distance, 2)) - 1
        up = self._level_segments(fits)
        plateau = self.levels[fits] if fits < len(self.levels) else self.top
        return Profile((*up, Segment(plateau, (distance - 2 * self.pulses[fits]) / plateau), *reversed(up)))

    def down_from(self, rate: Fraction) -> tuple[Segment, ...]:
        """Return a deceleration from `rate`: the levels below `rate`, in descending order."""
        return tuple(Segment(level, self.interval) for level in reversed(self.levels) if level < rate)

    def _level_segments(self, count: int) -> tuple[Segment, ...]:
        return tuple(Segment(level, self.interval) for level in self.levels[:count])
