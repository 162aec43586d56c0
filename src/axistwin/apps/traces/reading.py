"""Reads traces back, whichever kind of file they are in, also those that whoever wrote them could not finish."""

import csv
import json
from array import array
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.apps.conversations.visible import CHARACTERS
from axistwin.apps.traces.signals import COUNT, LEVEL, REAL, STEP, TEXT, choose
from axistwin.apps.traces.signals import Signal as Known
from axistwin.errors import ProgramError, TraceError, UsageError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

FLOAT = "d"
WHOLE = "q"


@dataclass
class Track:
    """One signal: from `times[n]` on it had `values[n]`.  Texts are as they are shown, `\\r` for a carriage return."""

    name: str
    kind: str
    times: "array[int]" = field(default_factory=lambda: array(WHOLE))
    values: "array[int] | array[float] | list[str]" = field(init=False)

    def __post_init__(self) -> None:
        self.values = [] if self.kind == TEXT else array(FLOAT if self.kind == REAL else WHOLE)

    def __len__(self) -> int:
        return len(self.times)

    def add(self, time_ns: int, value: str) -> None:
        """One more change, as it is written in CSV."""
        self.times.append(time_ns)
        self.values.append(_value(self.kind, value))  # type: ignore[arg-type]

    def columns(self) -> "tuple[NDArray[np.int64], NDArray[Any]]":
        """Times, and numbers."""
        import numpy as np

        values = np.array(self.values, float if self.kind == REAL else np.int64)
        return np.array(self.times, np.int64), values


@dataclass
class Trace:
    """Signals by name, from `begin_ns` to `end_ns`; `about`: what it is a trace of."""

    path: Path
    tracks: dict[str, Track]
    about: dict[str, str]
    begin_ns: int
    end_ns: int

    def choose(self, patterns: tuple[str, ...]) -> dict[str, Track]:
        """The signals that patterns mean.  Raises UsageError for one that means none."""
        known = [Known(*name.rpartition(".")[::2], track.kind) for name, track in self.tracks.items()]
        return {signal.full: self.tracks[signal.full] for signal in choose(known, patterns)}


def read(path: Path) -> Trace:
    """A trace.  Raises UsageError for a file that cannot be read, TraceError for one that is no trace."""
    readers: Mapping[str, Callable[[Path], Trace]] = {".csv": _csv, ".vcd": _vcd, ".parquet": _parquet}
    if path.suffix not in readers:
        raise UsageError(f"{path.name!r} is no trace: name a file .csv, .vcd or .parquet")
    try:
        return readers[path.suffix](path)
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise TraceError(f"{path}: no text in UTF-8: is it a trace?") from None


def _trace(path: Path, tracks: Mapping[str, Track], about: dict[str, str], end_ns: int | None) -> Trace:
    times = [track.times for track in tracks.values() if len(track)]
    if not times:
        raise TraceError(f"{path}: no signals in it: is it a trace?")
    last = max(of_one[-1] for of_one in times)
    return Trace(path, dict(tracks), about, min(of_one[0] for of_one in times), last if end_ns is None else end_ns)


# CSV


def _csv(path: Path) -> Trace:
    about: dict[str, str] = {}
    tracks: dict[str, Track] = {}
    end_ns = None
    with path.open(encoding="utf-8", newline="") as file:
        rows, kinds = csv.reader(_rows(file, about)), dict[str, str]()
        for number, row in enumerate(rows):
            if number == 0 and row != ["time_ns", "signal", "value"]:
                raise TraceError(f"{path}: no row time_ns,signal,value at its beginning: is it a trace?")
            if number == 0:
                kinds = _kinds(about)
                continue
            try:
                time_ns, name, value = row
                track = tracks.get(name) or tracks.setdefault(name, Track(name, kinds.get(name) or _guess(value)))
                track.add(int(time_ns), value)
            except (ValueError, OverflowError):
                raise TraceError(f"{path}: no change of a signal: {','.join(row)!r}") from None
    if "end_ns" in about:
        end_ns = _time_ns(path, about.pop("end_ns"))
    return _trace(path, tracks, about, end_ns)


def _rows(lines: Iterator[str], about: dict[str, str]) -> Iterator[str]:
    """Lines that are no comments; the last one may be torn, and is then left out."""
    signals: list[str] = []
    for line in lines:
        if not line.endswith("\n"):
            break
        if not line.startswith("#"):
            yield line
            continue
        key, _, value = line.removeprefix("# ").strip().partition(": ")
        if key == "signal":
            signals.append(value)
            about["signals"] = "\n".join(signals)
        else:
            about[key] = value


def _kinds(about: dict[str, str]) -> dict[str, str]:
    lines = about.pop("signals", "").splitlines()
    return {name: kind for name, _, kind in (line.rpartition(" ") for line in lines)}


def _time_ns(path: Path, text: str) -> int:
    try:
        return array(WHOLE, [int(text)])[0]
    except (ValueError, OverflowError):
        raise TraceError(f"{path}: {text!r} is no time in ns") from None


def _guess(value: str) -> str:
    """The kind of a signal about which nothing is said."""
    for kind in (COUNT, REAL):
        try:
            _value(kind, value)
        except ValueError:
            continue
        return kind
    return TEXT


def _value(kind: str, text: str) -> int | float | str:
    if kind == TEXT:
        return text
    return float(text) if kind == REAL else int(text)


# VCD


def _vcd(path: Path) -> Trace:
    with path.open(encoding="utf-8") as file:
        about, names = _vcd_head(path, file)
        tracks = {identifier: Track(*known) for identifier, known in names.items()}
        now_ns = 0
        for line in file:
            if not line.endswith("\n"):
                break
            if line.startswith("#"):
                now_ns = _time_ns(path, line[1:].strip())
            elif not line.startswith("$"):
                try:
                    _vcd_change(path, tracks, now_ns, line.rstrip("\n"))
                except ValueError:
                    raise TraceError(f"{path}: no change of a signal: {line.rstrip()!r}") from None
    return _trace(path, {track.name: track for track in tracks.values() if len(track)}, about, now_ns)


def _vcd_head(path: Path, lines: Iterator[str]) -> tuple[dict[str, str], dict[str, tuple[str, str]]]:
    """What it is a trace of, and the name and kind of each signal."""
    about: dict[str, str] = {}
    names: dict[str, tuple[str, str]] = {}
    scopes: list[str] = []
    for line in lines:
        words = line.split()
        match words:
            case ["$scope", _, name, "$end"]:
                scopes.append(name)
            case ["$upscope", "$end"] if scopes:
                scopes.pop()
            case ["$var", kind, _, identifier, name, *_]:
                step = kind == LEVEL and name == STEP
                names[identifier] = (".".join((*scopes, name)), STEP if step else kind)
            case ["$timescale", *scale, "$end"] if "".join(scale) != "1ns":
                raise TraceError(f"{path}: its times are in {' '.join(scale)}, not in 1 ns: is it a trace of axistwin?")
            case ["$enddefinitions", *_]:
                return about, names
            case [_, *_] if ": " in line:
                name, _, value = line.strip().partition(": ")
                about[name] = value.replace("%24", "$")
    raise TraceError(f"{path}: no definitions at its beginning: is it a trace?")


def _vcd_change(path: Path, tracks: dict[str, Track], now_ns: int, line: str) -> None:
    sign = line[:1]
    value, _, identifier = line[1:].partition(" ") if sign in "bBrRsS" else (sign, "", line[1:])
    track = tracks.get(identifier)
    if track is None:
        raise TraceError(f"{path}: no change of a signal: {line!r}")
    if sign in "bB":
        number = int(value, 2)
        value = str(number - (1 << 64) if number >> 63 else number)
    track.add(now_ns, _words(path, value) if track.kind == TEXT else value)


def _words(path: Path, text: str) -> str:
    """Characters that were written as one word."""
    try:
        return CHARACTERS.show(CHARACTERS.read(text))
    except ProgramError as error:
        raise TraceError(f"{path}: {text!r}: {error.message}") from None


# Parquet


def _parquet(path: Path) -> Trace:
    from axistwin.apps.traces.parquet import END as END_ROW
    from axistwin.apps.traces.parquet import SIGNALS, need_pyarrow

    need_pyarrow()
    import numpy as np
    import pyarrow as pa
    import pyarrow.compute as pc
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except pa.ArrowInvalid as error:
        raise TraceError(f"{path}: no Parquet file: {str(error).splitlines()[0]}") from None
    about = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
    if SIGNALS not in about or "time_ns" not in table.column_names:
        raise TraceError(f"{path}: not written by axistwin: is it a trace?")
    kinds: dict[str, str] = json.loads(about.pop(SIGNALS))
    times = table["time_ns"].to_numpy()
    names = table["signal"].cast(pa.string())
    tracks = {name: Track(name, kind) for name, kind in kinds.items()}
    which = pc.index_in(names, pa.array([*kinds, END_ROW], pa.string())).to_numpy()
    for place, track in enumerate(tracks.values()):
        rows = np.flatnonzero(which == place)
        track.times = array(WHOLE, times[rows].tobytes())
        track.values = _column(track.kind, table, rows)
    ends = times[which == len(kinds)]
    return _trace(path, {name: t for name, t in tracks.items() if len(t)}, about, int(ends[-1]) if len(ends) else None)


def _column(kind: str, table: Any, rows: "NDArray[np.int64]") -> "array[int] | array[float] | list[str]":
    if kind == TEXT:
        found: list[str] = table["text"].take(rows).to_pylist()
        return found
    if kind == REAL:
        return array(FLOAT, table["number"].take(rows).to_numpy().tobytes())
    return array(WHOLE, table["integer"].take(rows).to_numpy().tobytes())
