"""Compare two traces: find, for each signal, the first time at which the values differ by more than a tolerance."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from axistwin.core.lazy import NDArray, np
from axistwin.records.traces.reading import Trace, Track
from axistwin.records.traces.signals import EVERYTHING, STEP, TEXT, Signal, choose

if TYPE_CHECKING:
    Times = NDArray[np.int64]
    Columns = tuple[Times, NDArray[Any]]

Value = int | float | str


@dataclass(frozen=True)
class Tolerance:
    """Largest differences in value and in time with which two traces still count as equal."""

    value: float = 0.0
    time_ns: int = 0


@dataclass(frozen=True)
class Difference:
    """First difference of a signal, with its value in both traces; None: the trace does not contain the signal."""

    time_ns: int
    signal: str
    first: Value | None
    second: Value | None


@dataclass(frozen=True)
class Comparison:
    """Result of a comparison: all differences in order of time, and the number of compared signals."""

    differences: Sequence[Difference]
    compared: int
    until_ns: int  # End of the compared time.
    ends: tuple[int, int]


def compare(
    first: Trace, second: Trace, tolerance: Tolerance | None = None, patterns: Sequence[str] = (EVERYTHING,)
) -> Comparison:
    """Compare the signals matched by patterns, up to the end of the shorter trace.

    Step pulses are not compared, because `pulses` contains the same information.  Raises UsageError for a pattern
    without a match.
    """
    tolerance = tolerance or Tolerance()
    until_ns = min(first.end_ns, second.end_ns)
    found = []
    names = _names(first, second, patterns)
    for name in names:
        difference = _compare(name, first, second, until_ns, tolerance)
        if difference is not None:
            found.append(difference)
    found.sort(key=lambda difference: difference.time_ns)
    return Comparison(found, len(names), until_ns, (first.end_ns, second.end_ns))


def _names(first: Trace, second: Trace, patterns: Sequence[str]) -> list[str]:
    tracks = {**second.tracks, **first.tracks}
    names = dict.fromkeys((*first.tracks, *second.tracks))
    known = [Signal(*name.rpartition(".")[::2], tracks[name].kind) for name in names if tracks[name].kind != STEP]
    return [signal.full for signal in choose(known, patterns)]


def _compare(name: str, first: Trace, second: Trace, until_ns: int, tolerance: Tolerance) -> Difference | None:
    one, other = first.tracks.get(name), second.tracks.get(name)
    if one is None or other is None:
        begin_ns = max(first.begin_ns, second.begin_ns)
        return Difference(begin_ns, name, one.values[0] if one else None, other.values[0] if other else None)
    if tolerance == Tolerance() and one.times == other.times and one.values == other.values:
        return None
    return _first(name, one, other, until_ns, tolerance)


def _first(name: str, one: Track, other: Track, until_ns: int, tolerance: Tolerance) -> Difference | None:
    moments = [
        time_ns
        for this, that in ((one, other), (other, one))
        if (time_ns := _first_unmatched(this, that, until_ns, tolerance)) is not None
    ]
    if not moments:
        return None
    at_ns = min(moments)
    return Difference(at_ns, name, _at(one, at_ns), _at(other, at_ns))


def _at(track: Track, time_ns: int) -> Value:
    return track.values[max(bisect_right(track.times, time_ns) - 1, 0)]


def _first_unmatched(this: Track, that: Track, until_ns: int, tolerance: Tolerance) -> int | None:
    """Return the first time at which the value of `this` does not occur in `that` within the tolerated time.

    It is sufficient to check the times of changes of `this`, and of changes of `that` shifted by the tolerance.
    """
    most_ns, begin_ns = tolerance.time_ns, max(this.times[0], that.times[0])
    times, others = np.array(this.times, np.int64), np.array(that.times, np.int64)
    at = moments(np.append(times, begin_ns), others, most_ns)
    at = at[(at >= begin_ns) & (at <= until_ns - most_ns)]
    if not len(at):
        return None
    if TEXT in (this.kind, that.kind):
        here, first, last = _places(at, times, others, most_ns)
        places = zip(here.tolist(), first.tolist(), last.tolist(), strict=True)
        differs = np.array([str(this.values[n]) not in map(str, that.values[a:b]) for n, a, b in places], bool)
    else:
        differs = apart(at, this.columns(), that.columns(), most_ns) > tolerance.value
    unmatched = np.flatnonzero(differs)
    return int(at[unmatched[0]]) if len(unmatched) else None


def moments(times: "Times", others: "Times", most_ns: int) -> "Times":
    """Return the times at which the distance of two signals within a time can change."""
    found: Times = np.unique(np.concatenate((times, others + most_ns, others - most_ns)))
    return found


def apart(at: "Times", this: "Columns", that: "Columns", most_ns: int) -> "NDArray[Any]":
    """Return how far the value of `this` at each time is from the range of `that`, from `most_ns` before to after."""
    here, first, last = _places(at, this[0], that[0], most_ns)
    values, others = this[1][here], that[1]
    spans = np.column_stack((first, last)).ravel()
    # Extend `others` by one value, because the largest index in `spans` may be `len(others)`.
    ended = np.append(others, others[-1])
    least, greatest = np.minimum.reduceat(ended, spans)[::2], np.maximum.reduceat(ended, spans)[::2]
    found: NDArray[Any] = np.maximum(np.maximum(least - values, values - greatest), 0)
    return found


def _places(at: "Times", times: "Times", others: "Times", most_ns: int) -> "tuple[Times, Times, Times]":
    here = np.maximum(np.searchsorted(times, at, "right") - 1, 0)
    first = np.maximum(np.searchsorted(others, at - most_ns, "right") - 1, 0)
    return here, first, np.maximum(np.searchsorted(others, at + most_ns, "right"), first + 1)
