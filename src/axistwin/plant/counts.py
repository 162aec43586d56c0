"""Encoder positions of an axis whose motion is computed in samples; only the most recent samples are stored."""

from array import array
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from axistwin.core.errors import UsageError
from axistwin.core.lazy import NDArray, np
from axistwin.core.units import to_seconds

SAMPLES = 10  # Number of stored samples with motion for each move in the option `history`.


class Samples(NamedTuple):
    """Positions of an axis, sampled at `start_ns` and then every `period_ns`.

    These samples are final.  `positions`: encoder counts from 0 when the bench was made.  `commanded`: the setpoints
    for the same samples in the same coordinates (`commanded - position` is the following error).  A `period_ns` of 0
    means that a person has moved the axis, in no time.
    """

    start_ns: int
    period_ns: int
    positions: "Sequence[int] | NDArray[np.int64]"
    commanded: "Sequence[int] | NDArray[np.int64]"

    def __len__(self) -> int:
        return len(self.positions)

    def time_ns(self, sample: int) -> int:
        return self.start_ns + sample * self.period_ns


Listener = Callable[[Samples], None]


@dataclass(slots=True)
class _Stretch:
    start_ns: int
    period_ns: int
    before: int
    positions: "array[int]"

    @property
    def begin_ns(self) -> int:
        return self.start_ns - self.period_ns

    def times(self) -> "NDArray[np.int64]":
        """Return the times of count changes; between two samples, they are evenly spaced."""
        positions = np.frombuffer(self.positions, np.int64)
        steps = np.abs(np.diff(positions, prepend=self.before))
        begins = self.begin_ns + self.period_ns * np.arange(len(positions), dtype=np.int64)
        number = np.arange(1, int(steps.sum()) + 1, dtype=np.int64) - np.repeat(np.cumsum(steps) - steps, steps)
        times: NDArray[np.int64] = np.repeat(begins, steps) + self.period_ns * number // np.repeat(steps, steps)
        return times


class CountHistory:
    """Times of an encoder's count changes, from the latest `samples` samples with motion."""

    def __init__(self, samples: int) -> None:
        self.samples = samples
        self._stretches: deque[_Stretch] = deque()
        self._kept = self._last = 0
        self.forgotten_ns: int | None = None  # Changes up to this time have been discarded.

    def add(self, samples: Samples) -> None:
        """Store samples, if a position has changed, and delete old ones beyond the newest `self.samples`."""
        given = samples.positions
        positions = given if isinstance(given, array) else array("q", given)
        if positions[0] == positions[-1] == self._last and positions.count(self._last) == len(positions):
            return
        self._stretches.append(_Stretch(samples.start_ns, samples.period_ns, self._last, positions))
        self._last = positions[-1]
        self._kept += len(positions)
        while self._kept - len(self._stretches[0].positions) >= self.samples:
            self._kept -= len(self._stretches.popleft().positions)
            self.forgotten_ns = self._stretches[0].begin_ns

    def times(self, start_ns: int, stop_ns: int, larger_history: int) -> "NDArray[np.int64]":
        """Return the times of all changes of the count from `start_ns` to before `stop_ns`.

        Raises UsageError if old ones have been discarded, and suggests the option `history=larger_history`.
        """
        if self.forgotten_ns is not None and start_ns <= self.forgotten_ns:
            raise UsageError(
                f"encoder counts before {to_seconds(self.forgotten_ns):g} s are no longer stored: "
                f"to store more counts, call Bench.add with history={larger_history}"
            )
        found = [stretch.times() for stretch in self._stretches if stretch.begin_ns < stop_ns]
        times = np.concatenate(found) if found else np.empty(0, np.int64)
        return times[np.searchsorted(times, start_ns) : np.searchsorted(times, stop_ns)]
