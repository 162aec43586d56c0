"""Piecewise constant signals, used by measures and claims."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axistwin.core.units import S

Times = NDArray[np.int64]
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Series:
    """A signal over time: `values[n]` is valid from `times[n]` to `times[n + 1]`, the last value until `end_ns`."""

    times: Times
    values: NDArray[Any]
    end_ns: int

    @classmethod
    def of(cls, times: Times, values: NDArray[Any], end_ns: int) -> "Series":
        """Create a signal from changes in order of time; of several at one time, the last is used."""
        last = np.append(np.diff(times) > 0, True)
        return cls(times[last], values[last], end_ns)

    @property
    def seconds(self) -> Numbers:
        """Array of durations in seconds: how long the signal keeps each value."""
        found: Numbers = np.diff(self.times, append=self.end_ns) / S
        return found

    def at(self, times: Times) -> NDArray[Any]:
        found: NDArray[Any] = self.values[np.maximum(np.searchsorted(self.times, times, "right") - 1, 0)]
        return found

    def within(self, begin_ns: int, end_ns: int) -> NDArray[Any]:
        """Return all values that the signal has from `begin_ns` to `end_ns`, including the value at `begin_ns`."""
        first = max(int(np.searchsorted(self.times, begin_ns, "right")) - 1, 0)
        return self.values[first : max(int(np.searchsorted(self.times, end_ns, "right")), first + 1)]

    def map(self, function: Callable[[NDArray[Any]], NDArray[Any]]) -> "Series":
        return Series(self.times, function(self.values), self.end_ns)


def combined(function: Callable[..., NDArray[Any]], *parts: Series) -> Series:
    times = np.unique(np.concatenate([part.times for part in parts]))
    return Series(times, function(*(part.at(times) for part in parts)), max(part.end_ns for part in parts))


def minimum(values: Sequence[float] | NDArray[Any]) -> float:
    """Return the smallest of the values, or infinity if there are no values."""
    return float(np.min(values)) if len(values) else float("inf")
