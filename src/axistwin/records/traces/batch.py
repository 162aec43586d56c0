"""Collect changes of signals, and sort them by time.  Changes in the same nanosecond are sorted by signal."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from axistwin.core.lazy import NDArray, np
from axistwin.records.traces.signals import REAL, TEXT, Signal

Value = int | float | bytes


class Part(NamedTuple):
    """Changes of one signal in order of time.  `values`: integers, bit patterns of floats, or indices of texts."""

    signal: int
    times: "NDArray[np.int64]"
    values: "NDArray[np.int64]"


@dataclass(frozen=True)
class Batch:
    """Changes of all signals in order of time.  `values`: as in `Part`; `texts`: the texts by index."""

    times: "NDArray[np.int64]"
    signals: "NDArray[np.int64]"
    values: "NDArray[np.int64]"
    texts: Sequence[bytes]

    def __len__(self) -> int:
        return len(self.times)

    def part(self, begin: int, end: int) -> "Batch":
        return Batch(self.times[begin:end], self.signals[begin:end], self.values[begin:end], self.texts)

    def middle(self) -> int:
        """Return the index at which the list of signal changes can be split into two parts of similar size.

        Changes with equal times stay in one part.  If all changes have the same time, return the number of changes.
        """
        half_ns = self.times[len(self) // 2]
        return int(np.searchsorted(self.times, half_ns) or np.searchsorted(self.times, half_ns, side="right"))


class ChangeQueue:
    """Changes that have not been written yet, as a list for each signal."""

    def __init__(self, signals: Sequence[Signal]) -> None:
        self.count, self._signals = 0, signals
        self._changes: list[list[tuple[int, Value]]] = [[] for _ in signals]

    def add(self, time_ns: int, signal: int, value: Value) -> None:
        """Append a change of a signal; the changes of each signal must be in order of time."""
        self._changes[signal].append((time_ns, value))
        self.count += 1

    def parts(self, before_ns: int, texts: list[bytes]) -> list[Part]:
        """Remove and return the changes before `before_ns`; their texts are appended to `texts`."""
        taken = ((n, self._take(n, before_ns)) for n in range(len(self._changes)) if self._changes[n])
        return [self._part(n, changes, texts) for n, changes in taken if changes]

    def _take(self, signal: int, before_ns: int) -> list[tuple[int, Value]]:
        changes = self._changes[signal]
        if changes[-1][0] < before_ns:
            self._changes[signal], found = [], changes
        else:
            upto = next(n for n, (time_ns, _) in enumerate(changes) if time_ns >= before_ns)
            self._changes[signal], found = changes[upto:], changes[:upto]
        self.count -= len(found)
        return found

    def _part(self, signal: int, changes: list[tuple[int, Value]], texts: list[bytes]) -> Part:
        times, given = zip(*changes, strict=True)
        kind = self._signals[signal].kind
        if kind == TEXT:
            values = np.arange(len(texts), len(texts) + len(given), dtype=np.int64)
            texts += given
        else:
            values = np.array(given, float).view(np.int64) if kind == REAL else np.array(given, np.int64)
        return Part(signal, np.array(times, np.int64), values)


class Rows:
    """Changes that have not been written yet, as columns of integers; the first column contains the times."""

    def __init__(self, columns: int) -> None:
        self._blocks: list[tuple[NDArray[np.int64], ...]] = []
        self._columns, self.waiting = columns, 0

    def add(self, *columns: "Sequence[int] | NDArray[np.int64]") -> None:
        self._blocks.append(tuple(np.asarray(column, np.int64) for column in columns))
        self.waiting += len(columns[0])

    def take(self, before_ns: int) -> "list[NDArray[np.int64]]":
        if not self._blocks:
            return [np.empty(0, np.int64)] * self._columns
        columns = [np.concatenate(column) for column in zip(*self._blocks, strict=True)]
        due = int(np.searchsorted(columns[0], before_ns))
        self.waiting -= due
        self._blocks = [tuple(column[due:] for column in columns)] if self.waiting else []
        return [column[:due] for column in columns]


def merged(parts: Sequence[Part], texts: Sequence[bytes]) -> Batch:
    """Merge the changes of all signals into one batch in order of time."""
    parts = sorted((part for part in parts if len(part.times)), key=lambda part: part.signal)
    if not parts:
        nothing = np.empty(0, np.int64)
        return Batch(nothing, nothing, nothing, texts)
    times = np.concatenate([part.times for part in parts])
    signals = np.repeat([part.signal for part in parts], [len(part.times) for part in parts])
    values = np.concatenate([part.values for part in parts])
    order = np.argsort(times, kind="stable")
    return Batch(times[order], signals[order], values[order], texts)
