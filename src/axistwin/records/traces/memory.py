"""Record a trace in memory of limited size, for a picture of the run."""

from array import array
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.bench import Bench
from axistwin.bench.codec import CHARACTERS
from axistwin.core.lazy import NDArray, np
from axistwin.records.traces.batch import Part, Value
from axistwin.records.traces.provenance import provenance
from axistwin.records.traces.reading import FLOAT, WHOLE, Trace, Track
from axistwin.records.traces.signals import DEFAULT, REAL, STEP, TEXT, Signal, catalogue, choose
from axistwin.records.traces.trace import Tracer

if TYPE_CHECKING:
    Changes = tuple[NDArray[np.int64], NDArray[Any]]

POINTS = 1 << 17  # A signal with more than twice this number of changes is reduced to this number.


@contextmanager
def tracing_in_memory(bench: Bench) -> Iterator["MemoryTrace"]:
    memory = MemoryTrace(bench)
    with memory.tracer as tracer:
        yield memory
        tracer.finish()


class MemoryTrace:
    """A trace in memory.  In a long run, only the extremes of groups of numbers and the latest texts are kept."""

    def __init__(self, bench: Bench) -> None:
        self._bench, self._began_ns = bench, bench.now
        self._signals = [signal for signal in choose(catalogue(bench), (DEFAULT,)) if signal.kind != STEP]
        self.tracer = Tracer(bench, self._signals)
        self.tracer.consumer = self._take
        self._changes = [
            _Changes(signal, bench.now, value) for signal, value in zip(self._signals, self.tracer.first(), strict=True)
        ]
        by_name = {changes.signal.full: changes for changes in self._changes}
        self._servos = [
            (changes, by_name[f"{changes.signal.scope}.commanded"])
            for changes in self._changes
            if changes.signal.name == "position" and f"{changes.signal.scope}.commanded" in by_name
        ]

    def trace(self) -> Trace:
        tracks = {changes.signal.full: changes.track() for changes in self._changes}
        return Trace(Path(), tracks, provenance(self._bench), self._began_ns, self._bench.now)

    def _take(self, parts: list[Part], texts: list[bytes]) -> None:
        for part in parts:
            self._changes[part.signal].add(part, texts)
        for servo in self._servos:
            if max(each.count for each in servo) > 2 * POINTS:
                _reduce(servo)
        for changes in self._changes:
            if changes.count > 2 * POINTS:
                _reduce((changes,))


class _Changes:
    def __init__(self, signal: Signal, now_ns: int, first: Value) -> None:
        self.signal, self.count = signal, 1
        self._blocks: list[tuple[Sequence[int] | NDArray[np.int64], Sequence[Value] | NDArray[Any]]] = []
        self._blocks.append(([now_ns], [first]))

    def add(self, part: Part, texts: Sequence[bytes]) -> None:
        values: Sequence[Value] | NDArray[Any] = part.values.view(float) if self.signal.kind == REAL else part.values
        if self.signal.kind == TEXT:
            values = [texts[n] for n in part.values]
        self._blocks.append((part.times, values))
        self.count += len(part.times)

    def joined(self) -> "Changes":
        kind = {TEXT: object, REAL: float}.get(self.signal.kind, np.int64)
        times = np.concatenate([np.asarray(block, np.int64) for block, _ in self._blocks])
        return times, np.concatenate([np.asarray(block, kind) for _, block in self._blocks])

    def replace(self, times: "NDArray[np.int64]", values: "NDArray[Any]") -> None:
        self._blocks, self.count = [(times, values)], len(times)

    def track(self) -> Track:
        track = Track(self.signal.full, self.signal.kind)
        times, values = self.joined()
        track.times = array(WHOLE, times.tobytes())
        if self.signal.kind == TEXT:
            track.values = [CHARACTERS.show(text) for text in values]
        else:
            track.values = array(FLOAT if self.signal.kind == REAL else WHOLE, values.tobytes())
        return track


def _reduce(signals: Sequence[_Changes]) -> None:
    """Reduce a signal, or position and commanded position of a servo so that the extremes of their error are kept."""
    columns = [changes.joined() for changes in signals]
    if signals[0].signal.kind == TEXT:
        signals[0].replace(*(column[-POINTS:] for column in columns[0]))
        return
    times = np.unique(np.concatenate([own for own, _ in columns]))
    rows = [values[np.searchsorted(own, times, "right") - 1] for own, values in columns]
    kept = _extremes(rows[-1] - rows[0] if len(rows) > 1 else rows[0])
    for changes, row in zip(signals, rows, strict=True):
        changes.replace(times[kept], row[kept])


def _extremes(values: "NDArray[Any]") -> "NDArray[np.int64]":
    whole = len(values) // 4 * 4
    groups = values[:whole].reshape(-1, 4)
    least, most = groups.argmin(axis=1), groups.argmax(axis=1)
    most = np.where(least == most, 3 - least, most)
    base = np.arange(0, whole, 4)
    return np.unique(np.concatenate(([0], base + least, base + most, np.arange(whole, len(values)))))
