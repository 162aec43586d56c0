"""Read traces from CSV, VCD and Parquet files, even if a file is incomplete."""

import csv
import json
from array import array
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from axistwin.bench.codec import CHARACTERS
from axistwin.core.errors import ProgramError, TraceError, UsageError
from axistwin.core.lazy import NDArray, np, pa, pc, pq
from axistwin.core.numbers import NumberError, clipped, real, shortened, whole
from axistwin.records.traces.files import ALL_BITS
from axistwin.records.traces.signals import COUNT, LEVEL, REAL, STEP, TEXT, choose
from axistwin.records.traces.signals import Signal as SignalName

FLOAT = "d"
WHOLE = "q"
KINDS = (LEVEL, COUNT, STEP, TEXT, REAL)
COLUMNS = {"time_ns": "int64", "signal": "string", "integer": "int64", "number": "double", "text": "string"}
"""Columns of a Parquet file, with their types."""


@dataclass
class Track:
    """One signal, whose value is `values[n]` from `times[n]` on.  Control characters in texts are escaped as `\\r`."""

    name: str
    kind: str
    times: "array[int]" = field(default_factory=lambda: array(WHOLE))
    values: "array[int] | array[float] | list[str]" = field(init=False)

    def __post_init__(self) -> None:
        self.values = [] if self.kind == TEXT else array(FLOAT if self.kind == REAL else WHOLE)

    def __len__(self) -> int:
        return len(self.times)

    def add(self, time_ns: int, value: str) -> None:
        """Append a change; `value` is text as in a CSV file."""
        self.times.append(time_ns)
        self.values.append(_value(self.kind, value))  # type: ignore[arg-type]

    def columns(self) -> "tuple[NDArray[np.int64], NDArray[Any]]":
        return np.array(self.times, np.int64), np.array(self.values, float if self.kind == REAL else np.int64)


@dataclass
class Trace:
    """A trace that has been read from a file.  `tracks`: the signals by name; `about`: the provenance."""

    path: Path
    tracks: dict[str, Track]
    about: dict[str, str]
    begin_ns: int
    end_ns: int

    def choose(self, patterns: tuple[str, ...]) -> dict[str, Track]:
        """Return the signals that match at least one pattern.  Raises UsageError for a pattern without a match."""
        known = {SignalName(*name.rpartition(".")[::2], track.kind): name for name, track in self.tracks.items()}
        return {known[signal]: self.tracks[known[signal]] for signal in choose(list(known), patterns)}


def read(path: Path) -> Trace:
    """Read a trace file.  Raises UsageError if the file cannot be read, and TraceError if it is not a trace."""
    readers: Mapping[str, Callable[[Path], Trace]] = {".csv": _csv, ".vcd": _vcd, ".parquet": _parquet}
    if path.suffix not in readers:
        raise UsageError(f"{path.name!r} is not a trace: expected a name that ends in .csv, .vcd or .parquet")
    try:
        if path.exists() and not path.is_file():
            raise UsageError(f"the trace {path} cannot be read: expected an ordinary file")
        return readers[path.suffix](path)
    except OSError as error:
        raise UsageError(f"the trace {path} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise TraceError(f"{path} is not a trace: expected text in UTF-8") from None


def _trace(path: Path, tracks: Mapping[str, Track], about: dict[str, str], end_ns: int | None) -> Trace:
    times = [track.times for track in tracks.values() if len(track)]
    if not times:
        raise TraceError(f"{path} is not a trace: expected at least one signal")
    for track in tracks.values():
        _check_order(path, track)
    last = max(of_one[-1] for of_one in times)
    return Trace(path, dict(tracks), about, min(of_one[0] for of_one in times), max(last, end_ns or last))


def _check_order(path: Path, track: Track) -> None:
    times, signal_name = np.array(track.times, np.int64), track.name
    if len(times) and (times[0] < 0 or (times[1:] < times[:-1]).any()):
        raise TraceError(
            f"invalid times for the signal {signal_name} in {path}: "
            "expected numbers of at least 0 in ascending order, e.g. 0, 10, 25"
        )


# CSV


def _csv(path: Path) -> Trace:
    about: dict[str, str] = {}
    tracks: dict[str, Track] = {}
    end_ns = None
    with path.open(encoding="utf-8", newline="") as file:
        rows, kinds = _Rows(path, file, about), dict[str, str]()
        for number, row in enumerate(rows):
            if number == 0 and row != ["time_ns", "signal", "value"]:
                raise TraceError(f"{path} is not a trace: expected time_ns,signal,value as the first row")
            if number == 0:
                kinds = _kinds(about)
                continue
            try:
                time_ns, name, value = row
                track = tracks.get(name) or tracks.setdefault(name, Track(name, kinds.get(name) or _guess(value)))
                track.add(whole(time_ns), value)
            except ValueError:
                raise TraceError(
                    f"{path}:{rows.line}: invalid change {shortened(','.join(row))}: "
                    "expected time_ns,signal,value, e.g. 1000,if1.output1,1"
                ) from None
    if "end_ns" in about:
        end_ns = _time_ns(path, about.pop("end_ns"))
    return _trace(path, tracks, about, end_ns)


class _Rows:
    def __init__(self, path: Path, lines: Iterator[str], about: dict[str, str]) -> None:
        self.line = 0
        self._path, self._rows = path, csv.reader(_rows(self._counted(lines), about))

    def _counted(self, lines: Iterator[str]) -> Iterator[str]:
        for self.line, line in enumerate(lines, start=1):  # Error messages contain the line number in the trace file.
            yield line

    def __iter__(self) -> Iterator[list[str]]:
        try:
            yield from self._rows
        except csv.Error as csv_error:
            raise TraceError(f"{self._path}:{self.line}: this line is not valid CSV: {csv_error}") from None


def _rows(lines: Iterator[str], about: dict[str, str]) -> Iterator[str]:
    """Yield the complete lines of a CSV file; its comments are stored in `about`."""
    signals: list[str] = []
    for line in lines:
        if not line.endswith("\n"):
            break
        if not line.startswith("#"):
            yield line
            continue
        key, _, value = line.removeprefix("# ").strip().partition(": ")
        if key.startswith("unit of "):
            continue
        if key == "signal":
            signals.append(value)
            about["signals"] = "\n".join(signals)
        else:
            about[key] = value


def _kinds(about: dict[str, str]) -> dict[str, str]:
    told = (line.rpartition(" ") for line in about.pop("signals", "").splitlines())
    return {name: kind for name, _, kind in told if kind in KINDS}


def _time_ns(path: Path, text: str, line: int = 0) -> int:
    try:
        return whole(text)
    except NumberError:
        file_and_line = f"{path}:{line}" if line else f"{path}"
        raise TraceError(f"{file_and_line}: invalid time {shortened(text)}: expected nanoseconds, e.g. 1000") from None


def _guess(value: str) -> str:
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
    return real(text) if kind == REAL else whole(text)


# VCD


def _vcd(path: Path) -> Trace:
    with path.open(encoding="utf-8") as file:
        lines = enumerate(file, start=1)
        about, names = _vcd_head(path, (line for _, line in lines))
        tracks = {identifier: Track(*known) for identifier, known in names.items()}
        now_ns = 0
        for number, line in lines:
            if not line.endswith("\n"):
                break
            if line.startswith("#"):
                now_ns = _time_ns(path, line[1:].strip(), number)
            elif not line.startswith("$"):
                try:
                    _vcd_change(path, tracks, now_ns, line.rstrip("\n"))
                except ValueError:
                    raise TraceError(
                        f"{path}:{number}: invalid change {shortened(line.rstrip())} of a signal: "
                        "expected a value and the signal's identifier, e.g. 1a for the value 1 of the signal a"
                    ) from None
    return _trace(path, {track.name: track for track in tracks.values() if len(track)}, about, now_ns)


def _vcd_head(path: Path, lines: Iterator[str]) -> tuple[dict[str, str], dict[str, tuple[str, str]]]:
    about: dict[str, str] = {}
    names: dict[str, tuple[str, str]] = {}
    scopes: list[str] = []
    for line in lines:
        match line.split():
            case ["$scope", _, name, "$end"]:
                scopes.append(name)
            case ["$upscope", "$end"] if scopes:
                scopes.pop()
            case ["$var", kind, _, identifier, name, *_]:
                step = kind == LEVEL and name.rpartition(".")[2] == STEP
                names[identifier] = (".".join((*scopes, name)), STEP if step else kind)
            case ["$timescale", *scale, "$end"] if "".join(scale) != "1ns":
                raise TraceError(f"unsupported time scale {' '.join(scale)} in {path}: expected 1 ns")
            case ["$enddefinitions", *_]:
                return about, names
            case [_, *_] if ": " in line:
                name, _, value = line.strip().partition(": ")
                about[name] = value.replace("%24", "$")
    raise TraceError(f"{path} is not a trace: expected a line with $enddefinitions")


def _vcd_change(path: Path, tracks: dict[str, Track], now_ns: int, line: str) -> None:
    sign = line[:1]
    value, _, identifier = line[1:].partition(" ") if sign in "bBrRsS" else (sign, "", line[1:])
    track = tracks.get(identifier)
    if track is None:
        raise ValueError(f"unknown signal identifier {identifier!r}: expected an identifier from a $var line")
    if sign in "bB":
        number = whole(value, 0, ALL_BITS, base=2)
        value = str(number - (1 << 64) if number >> 63 else number)
    track.add(now_ns, _words(path, value) if track.kind == TEXT else value)


def _words(path: Path, text: str) -> str:
    try:
        return CHARACTERS.show(CHARACTERS.read(text))
    except ProgramError as syntax_error:
        raise TraceError(f"{path} contains an invalid text {shortened(text)}: {syntax_error.message}") from None


# Parquet


def _parquet(path: Path) -> Trace:
    from axistwin.records.traces.parquet import END as END_ROW
    from axistwin.records.traces.parquet import SIGNALS, UNITS, require_pyarrow

    require_pyarrow()

    table = _parquet_table(path)
    about = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
    kinds = _parquet_kinds(path, about.pop(SIGNALS, None))
    about.pop(UNITS, None)
    times = table["time_ns"].to_numpy()
    names = table["signal"].cast(pa.string())
    tracks = {name: Track(name, kind) for name, kind in kinds.items()}
    which = pc.index_in(names, pa.array([*kinds, END_ROW], pa.string())).to_numpy()
    for place, track in enumerate(tracks.values()):
        rows = np.flatnonzero(which == place)
        track.times = array(WHOLE, times[rows].tobytes())
        track.values = _column(path, track, table, rows)
    ends = times[which == len(kinds)]
    return _trace(path, {name: t for name, t in tracks.items() if len(t)}, about, int(ends[-1]) if len(ends) else None)


def _parquet_table(path: Path) -> Any:
    with path.open("rb"):  # Opening a trace file raises OSError if the file cannot be read.
        pass
    try:
        table = pq.ParquetFile(path).read()
        table.validate(full=True)
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        read_error = clipped("".join(str(error).splitlines()[:1])) or type(error).__name__
        raise TraceError(f"{path} is damaged or is not a Parquet file ({read_error})") from None
    kinds = {field.name: field.type for field in table.schema}
    types = {name: str(kind.value_type if pa.types.is_dictionary(kind) else kind) for name, kind in kinds.items()}
    for name, wanted in COLUMNS.items():
        if types.get(name) != wanted or table.column_names.count(name) != 1:
            raise TraceError(
                f"{path} is not a trace file of axistwin: "
                f"expected exactly one column {name} of type {wanted}, found {types.get(name, 'no such column')}"
            )
    for name in ("time_ns", "signal"):
        if table[name].null_count:
            raise TraceError(f"{path} is not a trace: expected a value in each row of the column {name}")
    return table


def _parquet_kinds(path: Path, text: str | None) -> dict[str, str]:
    try:
        kinds = json.loads(text or "")
    except (ValueError, RecursionError):
        kinds = None
    if not isinstance(kinds, dict) or not all(kind in KINDS for kind in kinds.values()):
        raise TraceError(f"{path} was not written by axistwin: expected a list of signals in the metadata")
    return kinds


def _column(path: Path, track: Track, table: Any, rows: "NDArray[np.int64]") -> "array[int] | array[float] | list[str]":
    name = {TEXT: "text", REAL: "number"}.get(track.kind, "integer")
    found = table[name].take(rows)
    if found.null_count:
        raise TraceError(
            f"{path} is damaged: in the column {name}, a value of the signal {track.name} is missing; "
            "record the trace again"
        )
    if track.kind == TEXT:
        texts: list[str] = found.to_pylist()
        return texts
    return array(FLOAT if track.kind == REAL else WHOLE, found.to_numpy().tobytes())
