"""Conversion of pulse times into step commands, which a motion board executes in ticks of its own clock.

A command outputs `count` pulses.  The first pulse comes `interval` ticks after the last pulse before the command, which
is at tick `last`.  Each further interval is longer by `add` ticks.  Pulse k (from 1) comes at tick `last + k * interval
+ add * k * (k - 1) / 2`.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from axistwin.core.lazy import NDArray, np

MOST_COUNT = (1 << 16) - 1
MOST_ADD = (1 << 15) - 1
MOST_INTERVAL = (1 << 31) - 1


@dataclass(frozen=True, slots=True)
class Steps:
    """A step command for a motion board.  The command outputs one or more pulses."""

    interval: int
    count: int
    add: int

    @property
    def ticks(self) -> int:
        """Ticks from the pulse before this command to its last pulse."""
        return self.count * self.interval + self.add * (self.count * (self.count - 1) // 2)

    def times(self, last: int) -> "NDArray[np.int64]":
        """Return the tick of each pulse; `last` is the tick of the pulse before the command."""
        k = np.arange(1, self.count + 1, dtype=np.int64)
        found: NDArray[np.int64] = last + k * self.interval + self.add * (k * (k - 1) // 2)
        return found


def plan(wanted: "NDArray[np.float64]", last: int, tolerance: float) -> Iterator[Steps]:
    """Yield the longest commands whose pulses are within `tolerance` ticks of the `wanted` times.

    The wanted times must rise.  `last` is the tick of the pulse before them, earlier by more than `tolerance`.  Raises
    ValueError if an interval is out of range.
    """
    low, high = np.ceil(wanted - tolerance).astype(np.int64), np.floor(wanted + tolerance).astype(np.int64)
    done = 0
    while done < len(wanted):
        steps = _longest(low[done : done + MOST_COUNT] - last, high[done : done + MOST_COUNT] - last)
        yield steps
        done += steps.count
        last += steps.ticks


def _longest(low: "NDArray[np.int64]", high: "NDArray[np.int64]") -> Steps:
    """Return the command with most of the first pulses, each between its ticks `low` and `high`."""
    if high[0] <= 0 or low[0] > MOST_INTERVAL:
        raise ValueError(f"interval of {int(high[0])} ticks between two pulses: expected 1 to {MOST_INTERVAL} ticks")
    best, reach = _fit(low[:1], high[:1]), 2
    assert best is not None, "a command of one pulse is always possible"
    while reach <= len(low) and (found := _fit(low[:reach], high[:reach])):
        best, reach = found, 2 * reach
    fails = min(reach, len(low) + 1)
    while best.count + 1 < fails:
        middle = (best.count + fails) // 2
        found = _fit(low[:middle], high[:middle])
        if found is None:
            fails = middle
        else:
            best = found
    return best


def _fit(low: "NDArray[np.int64]", high: "NDArray[np.int64]") -> Steps | None:
    """Return a command with all pulses between their ticks `low` and `high`; None if there is none."""
    count = len(low)
    if count == 1:
        return Steps(min(max(1, int(low[0] + high[0]) // 2), MOST_INTERVAL), 1, 0)
    pairs = count * (count - 1)
    first = max(-(-2 * int(low[-1] - count * high[0]) // pairs), -MOST_ADD)
    last = min(2 * int(high[-1] - count * low[0]) // pairs, MOST_ADD)
    if first > last:
        return None
    k = np.arange(1, count + 1, dtype=np.int64)
    triangle = k * (k - 1) // 2
    lowest, highest = first, last
    below = (first + last) // 2
    above = below + 1
    while lowest <= highest:
        below, above = min(below, highest), max(above, lowest)
        possible = [each for each in (below, above) if lowest <= each <= highest]
        if not possible:
            break
        add = min(possible, key=lambda each: abs(2 * each - first - last))
        shift = add * triangle
        least, most = -((shift - low) // k), (high - shift) // k
        m, n = int(least.argmax()), int(most.argmin())
        at_least, at_most = max(1, int(least[m])), min(MOST_INTERVAL, int(most[n]))
        if at_least <= at_most and at_least + add * (count - 1) >= 1:
            return Steps((at_least + at_most) // 2, count, add)
        lowest, highest = _narrowed(lowest, highest, add, (m + 1, int(low[m])), (n + 1, int(high[n])))
        if add == below:
            below -= 1
        else:
            above += 1
    return None


def _narrowed(lowest: int, highest: int, add: int, late: tuple[int, int], early: tuple[int, int]) -> tuple[int, int]:
    """Reduce the range of `add` (ticks by which successive intervals differ) after `add` has failed.

    The new range has only values with which both given pulses can be at permitted times; if `add` is one, the range
    stays.  `late`: number and earliest tick of the first pulse.  `early`: number and latest tick of the second.
    """
    (m, low), (n, high) = late, early
    gap, slope = 2 * (low * n - high * m), (m - n) * m * n
    if gap <= add * slope:
        return lowest, highest
    if not slope:
        return 0, -1
    return (max(lowest, -(-gap // slope)), highest) if slope > 0 else (lowest, min(highest, gap // slope))
