"""Save the screen of an oscilloscope, or the complete record, as a trace or as a picture."""

import tempfile
from array import array
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from axistwin.bench.codec import CHARACTERS
from axistwin.core.units import to_seconds
from axistwin.records.plots import picture
from axistwin.records.plots.chart import Word
from axistwin.records.plots.trace_chart import of_trace
from axistwin.records.traces.batch import Part, Value, merged
from axistwin.records.traces.files import sink_for
from axistwin.records.traces.output import Output
from axistwin.records.traces.reading import Trace
from axistwin.records.traces.reading import Track as Read
from axistwin.records.traces.signals import REAL, STEP, TEXT, Signal
from axistwin.ui.panel.scope.cursors import duration
from axistwin.ui.panel.scope.decimation import window
from axistwin.ui.panel.scope.recorder import Record
from axistwin.ui.panel.scope.tracks import Numbers, Rows, Times, Track, Words

TRACES, PICTURES = (".csv", ".vcd", ".parquet"), picture.SUFFIXES
PIECE = 1 << 15
PIXELS = 1500  # Width in pixels to which the lines of a picture are reduced.


@dataclass(frozen=True)
class Piece:
    """Part of a signal's history: an initial value and the changes in a period."""

    signal: Signal
    first: Value
    times: Times
    values: Numbers
    texts: list[str]


def saved(
    record: Record, signals: Mapping[str, Signal], from_ns: int, to_ns: int, suffix: str,
    cursors: Mapping[str, int] | None = None,
) -> bytes:  # fmt: skip
    """Return the recorded signals as the contents of a trace file or a picture file.

    `suffix` selects the format.  A picture shows the cursors and the time between the cursors.  Raises UsageError,
    MissingExtraError.
    """
    from_ns, to_ns = max(from_ns, 0), max(min(to_ns, record.now_ns), 0)
    make = _drawn if suffix in PICTURES else _piece
    pieces = [make(record.tracks[name], signal, from_ns, to_ns) for name, signal in signals.items()]
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / f"scope{suffix}"
        if suffix in PICTURES:
            trace, title = _read(path, pieces, from_ns, to_ns, record.about), record.about.get("title", "")
            chart = of_trace(trace, from_ns=from_ns, to_ns=to_ns, title=title)
            chart.marks += _marks(cursors or {})
            picture.save(chart, path)
        else:
            _write(path, pieces, {**record.about, **_coarse(record, signals, from_ns)}, from_ns, to_ns)
        return path.read_bytes()


def _marks(cursors: Mapping[str, int]) -> list[Word]:
    marks = [Word(at_ns, name) for name, at_ns in cursors.items()]
    if len(marks) == 2:
        marks[1] = Word(marks[1].time_ns, f"B   B − A {duration(cursors['B'] - cursors['A'])}")
    return marks


def exact_ns(record: Record, names: Mapping[str, Signal]) -> int:
    """Return the time after which the record contains every change of these signals."""
    return max((record.tracks[name].exact_ns for name in names), default=0)


def _coarse(record: Record, signals: Mapping[str, Signal], from_ns: int) -> dict[str, str]:
    since_ns = exact_ns(record, signals)
    if since_ns <= from_ns:
        return {}
    told = f"before {to_seconds(since_ns):.9f} s, first, least, greatest and last value of intervals only"
    return {"summary": told}


def _write(path: Path, pieces: list[Piece], about: dict[str, str], from_ns: int, to_ns: int) -> None:
    texts: list[bytes] = []
    parts = [_part(n, piece, texts) for n, piece in enumerate(pieces)]
    output = Output(path)
    try:
        signals, first = [piece.signal for piece in pieces], [piece.first for piece in pieces]
        sink = sink_for(path)(output, signals, first, from_ns, about)
        batch = merged(parts, texts)
        for at in range(0, len(batch), PIECE):
            part = slice(at, at + PIECE)
            sink.write(type(batch)(batch.times[part], batch.signals[part], batch.values[part], batch.texts))
        sink.end(to_ns)
    finally:
        output.close()


def _part(place: int, piece: Piece, texts: list[bytes]) -> Part:
    if piece.signal.kind == TEXT:
        begin = len(texts)
        texts += map(CHARACTERS.read, piece.texts)
        return Part(place, piece.times, np.arange(begin, len(texts), dtype=np.int64))
    exact = piece.values.view(np.int64) if piece.signal.kind == REAL else piece.values.astype(np.int64)
    return Part(place, piece.times, exact)


def _piece(track: Track, signal: Signal, from_ns: int, to_ns: int) -> Piece:
    if isinstance(track, Words):
        return _texts(track, signal, from_ns, to_ns)
    times, values = _spelled(track.rows(from_ns, to_ns + 1))
    known = ~np.isnan(values)
    times, values = times[known], values[known]
    begin, end = int(np.searchsorted(times, from_ns, "right")), int(np.searchsorted(times, to_ns, "right"))
    first = float(values[begin - 1]) if begin else 0.0
    given = first if signal.kind == REAL else int(first)
    return Piece(signal, given, times[begin:end], np.ascontiguousarray(values[begin:end]), [])


def _drawn(track: Track, signal: Signal, from_ns: int, to_ns: int) -> Piece:
    if isinstance(track, Words):
        texts = _texts(track, signal, from_ns, to_ns)
        return texts if signal.register else replace(texts, first=b"")
    seen = window(track, from_ns, max(to_ns, from_ns + PIXELS), PIXELS, to_ns)
    known = ~np.isnan(seen.values)
    times, values = seen.times[known], seen.values[known]
    first = float(values[0]) if len(values) else 0.0
    return Piece(signal, first if signal.kind == REAL else int(first), times, values, [])


def _texts(words: Words, signal: Signal, from_ns: int, to_ns: int) -> Piece:
    when = [time_ns for time_ns, _ in words.changes]
    begin, end = bisect_right(when, from_ns), bisect_right(when, to_ns)
    texts = [text for _, text in words.changes[begin:end]]
    first = CHARACTERS.read(words.changes[begin - 1][1]) if begin else b""
    return Piece(signal, first, np.array(when[begin:end], np.int64), np.zeros(end - begin), texts)


def _spelled(rows: Rows) -> tuple[Times, Numbers]:
    """Convert rows to changes; a merged interval becomes its first, least, greatest and last value."""
    wide = rows.end > rows.begin
    width = rows.end - rows.begin
    times = np.stack((rows.begin, rows.begin + width // 3, rows.begin + 2 * width // 3, rows.end), 1)
    values = np.stack((rows.first, rows.low, rows.high, rows.last), 1)
    used = np.stack((np.ones(len(wide), bool), wide, wide, wide), 1)
    times, values = times[used], values[used]
    new = values != np.concatenate(((np.nan,), values[:-1]))
    return times[new], values[new]


def _read(path: Path, pieces: list[Piece], from_ns: int, to_ns: int, about: dict[str, str]) -> Trace:
    tracks = {}
    for piece in pieces:
        if piece.signal.kind == STEP:
            continue
        track = tracks[piece.signal.full] = Read(piece.signal.full, piece.signal.kind)
        track.times = array("q", [from_ns, *piece.times.tolist()])
        track.values = _values(piece)
    return Trace(path, tracks, about, from_ns, to_ns)


def _values(piece: Piece) -> "array[int] | array[float] | list[str]":
    if piece.signal.kind == TEXT:
        return [CHARACTERS.show(piece.first) if isinstance(piece.first, bytes) else "", *piece.texts]
    values = [float(piece.first), *piece.values.tolist()]
    return array("d", values) if piece.signal.kind == REAL else array("q", map(int, values))
