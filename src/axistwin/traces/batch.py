"""Changes on their way into a file: in order of time, and those of one nanosecond in the order of the signals."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from axistwin.traces.signals import REAL, TEXT, Signal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Value = int | float | bytes


class Part(NamedTuple):
    """Changes of one signal in order of time; numbers that are not whole as their 64 bits, texts by their place."""

    signal: int
    times: "NDArray[np.int64]"
    values: "NDArray[np.int64]"


@dataclass(frozen=True)
class Batch:
    """Changes of all signals, in order."""

    times: "NDArray[np.int64]"
    signals: "NDArray[np.int64]"
    values: "NDArray[np.int64]"
    texts: Sequence[bytes]

    def __len__(self) -> int:
        return len(self.times)


class Waiting:
    """Changes that have happened one by one and wait to be written, signal by signal."""

    def __init__(self, signals: Sequence[Signal]) -> None:
        self.count = 0
        self._signals = signals
        self._changes: list[list[tuple[int, Value]]] = [[] for _ in signals]

    def add(self, time_ns: int, signal: int, value: Value) -> None:
        """One more; of one signal they come in order of time."""
        self._changes[signal].append((time_ns, value))
        self.count += 1

    def parts(self, before_ns: int, texts: list[bytes]) -> list[Part]:
        """Those before a time; they wait no longer."""
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
        import numpy as np

        times, given = zip(*changes, strict=True)
        kind = self._signals[signal].kind
        if kind == TEXT:
            values = np.arange(len(texts), len(texts) + len(given), dtype=np.int64)
            texts += given
        else:
            values = np.array(given, float).view(np.int64) if kind == REAL else np.array(given, np.int64)
        return Part(signal, np.array(times, np.int64), values)


class Rows:
    """Numbers that have been told in order of time, and wait to be written: columns, the first of them the times."""

    def __init__(self, columns: int) -> None:
        self._told: list[tuple[NDArray[np.int64], ...]] = []
        self._columns = columns
        self.waiting = 0

    def add(self, *columns: "Sequence[int] | NDArray[np.int64]") -> None:
        """Some more."""
        import numpy as np

        self._told.append(tuple(np.asarray(column, np.int64) for column in columns))
        self.waiting += len(columns[0])

    def take(self, before_ns: int) -> "list[NDArray[np.int64]]":
        """Those before a time; they wait no longer."""
        import numpy as np

        if not self._told:
            return [np.empty(0, np.int64)] * self._columns
        columns = [np.concatenate(column) for column in zip(*self._told, strict=True)]
        due = int(np.searchsorted(columns[0], before_ns))
        self.waiting -= due
        self._told = [tuple(column[due:] for column in columns)] if self.waiting else []
        return [column[:due] for column in columns]


def merged(parts: Sequence[Part], texts: Sequence[bytes]) -> Batch:
    """All of them in order."""
    import numpy as np

    parts = sorted((part for part in parts if len(part.times)), key=lambda part: part.signal)
    if not parts:
        nothing = np.empty(0, np.int64)
        return Batch(nothing, nothing, nothing, texts)
    times = np.concatenate([part.times for part in parts])
    signals = np.repeat([part.signal for part in parts], [len(part.times) for part in parts])
    values = np.concatenate([part.values for part in parts])
    order = np.argsort(times, kind="stable")
    return Batch(times[order], signals[order], values[order], texts)
