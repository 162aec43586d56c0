"""What an axis that is sampled has done: positions sample by sample, and how long they are remembered."""

from array import array
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from axistwin.errors import UsageError
from axistwin.units import to_seconds

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SAMPLES = 10
"""So many samples with motion are remembered for each stroke that a stepper would remember."""


@dataclass(frozen=True, slots=True)
class Samples:
    """What an axis did at `start_ns`, `start_ns + period_ns`, …, for good.

    `positions`: encoder counts from 0 when the bench was made.  `commanded`: as many; where the trajectory would have
    the shaft, in the same coordinates (so `commanded - position` is the following error).  `period_ns` 0: it was moved
    at once, by hand.
    """

    start_ns: int
    period_ns: int
    positions: "Sequence[int] | NDArray[np.int64]"
    commanded: "Sequence[int] | NDArray[np.int64]"

    def __len__(self) -> int:
        return len(self.positions)

    def time_ns(self, sample: int) -> int:
        """When the sample of this index, from 0, was."""
        return self.start_ns + sample * self.period_ns


Listener = Callable[[Samples], None]


@dataclass(slots=True)
class _Stretch:
    """Samples with motion; `before`: the position before the first of them."""

    start_ns: int
    period_ns: int
    before: int
    positions: "array[int]"

    @property
    def begin_ns(self) -> int:
        return self.start_ns - self.period_ns

    def times(self) -> "NDArray[np.int64]":
        """When the count changed, evenly from each sample to the next."""
        import numpy as np

        positions = np.frombuffer(self.positions, np.int64)
        steps = np.abs(np.diff(positions, prepend=self.before))
        begins = self.begin_ns + self.period_ns * np.arange(len(positions), dtype=np.int64)
        first = np.cumsum(steps) - steps
        number = np.arange(1, int(steps.sum()) + 1, dtype=np.int64) - np.repeat(first, steps)
        times: NDArray[np.int64] = np.repeat(begins, steps) + self.period_ns * number // np.repeat(steps, steps)
        return times


class CountHistory:
    """When the count of an encoder changed: the latest `samples` samples in which something moved."""

    def __init__(self, samples: int, position: int = 0) -> None:
        self.samples = samples
        self._stretches: deque[_Stretch] = deque()
        self._kept, self._last = 0, position
        self.forgotten_ns: int | None = None
        """Changes up to here are no longer kept; None: all are."""

    def add(self, samples: Samples) -> None:
        """The next ones."""
        given = samples.positions
        positions = given if isinstance(given, array) else array("q", given)
        if positions[0] == positions[-1] == self._last and positions.count(self._last) == len(positions):
            return
        self._stretches.append(_Stretch(samples.start_ns, samples.period_ns, self._last, positions))
        self._last = positions[-1]
        self._kept += len(positions)
        while self._kept > self.samples and len(self._stretches) > 1:
            oldest = self._stretches.popleft()
            self._kept -= len(oldest.positions)
            self.forgotten_ns = self._stretches[0].begin_ns

    def times(self, start_ns: int, stop_ns: int, advice: int) -> "NDArray[np.int64]":
        """All changes with start_ns <= time < stop_ns; `advice`: the history that would have kept more."""
        import numpy as np

        if self.forgotten_ns is not None and start_ns <= self.forgotten_ns:
            raise UsageError(
                f"counts before {to_seconds(self.forgotten_ns):g} s are no longer kept: ask from there on, "
                f"or add the controller with history={advice}"
            )
        found = [stretch.times() for stretch in self._stretches if stretch.begin_ns < stop_ns]
        times = np.concatenate(found) if found else np.empty(0, np.int64)
        return times[np.searchsorted(times, start_ns) : np.searchsorted(times, stop_ns)]
