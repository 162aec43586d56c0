"""Write traces to files: `.csv`, `.vcd` for GTKWave, or `.parquet` for analysis.

A file can be read at any time during writing: it grows by whole rows, and rows cut by a full disk are removed.  Each
file holds its provenance (`provenance.py`), as comments or as Parquet metadata.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Protocol

from axistwin.bench.codec import CHARACTERS
from axistwin.core.errors import UsageError
from axistwin.core.lazy import NDArray, np
from axistwin.records.traces.batch import Batch, Value
from axistwin.records.traces.output import Output, Provenance
from axistwin.records.traces.signals import COUNT, LEVEL, REAL, STEP, TEXT, Signal

ALL_BITS = 0xFFFF_FFFF_FFFF_FFFF
WAVES, SIGROK = ".vcd", ".sigrok.vcd"
"""Endings of the only files with step pulses; other files contain the signal `pulses` instead."""


class Sink(Protocol):
    """A writer of trace files."""

    def write(self, batch: Batch) -> None:
        """Write signal changes to the trace file, in order of time.  Raises OSError if the file cannot be written."""

    def flush(self) -> None:
        """Make all written changes readable for other programs.  Raises OSError."""

    def end(self, now_ns: int) -> None:
        """Write the end time of the trace.  Raises OSError if the file cannot be written."""


class TextSink:
    """Base class of the writers of text files, e.g. CSV files."""

    def flush(self) -> None:
        """Do nothing: the method `write` has already written all signal changes to the file."""


class CsvSink(TextSink):
    """Writes a CSV file with the columns time_ns, signal and value.  The first rows are the initial values."""

    def __init__(
        self, output: Output, signals: Sequence[Signal], first: Sequence[Value], now_ns: int, provenance: Provenance
    ) -> None:
        self._output, self._signals = output, signals
        self._names = [f",{csv_field(signal.full)}," for signal in signals]
        lines = [f"# {key}: {value}" for key, value in provenance.items()]
        lines += [f"# signal: {signal.full} {signal.kind}" for signal in signals]
        lines += [f"# unit of {name}: {unit}" for name, unit in units(signals).items()]
        lines.append("time_ns,signal,value")
        lines += [f"{now_ns}{name}{_csv_value(value)}" for name, value in zip(self._names, first, strict=True)]
        output.append(("\n".join(lines) + "\n").encode())

    def write(self, batch: Batch) -> None:
        values = decoded(batch, batch.signals, batch.values, self._signals, _csv_value)
        names = self._names
        rows = zip(batch.times.tolist(), batch.signals.tolist(), values, strict=True)
        self._output.append("".join([f"{time_ns}{names[n]}{value}\n" for time_ns, n, value in rows]).encode())

    def end(self, now_ns: int) -> None:
        self._output.append(f"# end_ns: {now_ns}\n".encode())


class VcdSink(TextSink):
    """Writes a value change dump (VCD) in ns; each controller and each axis has a VCD scope (group of signals)."""

    def __init__(
        self, output: Output, signals: Sequence[Signal], first: Sequence[Value], now_ns: int, provenance: Provenance
    ) -> None:
        self._output, self._signals = output, signals
        self._ids = [_identifier(n) for n in range(len(signals))]
        self._last_ns = now_ns
        head = [
            *_vcd_head(provenance),
            *self._scopes(),
            "$enddefinitions $end",
            f"#{now_ns}",
            "$dumpvars",
            *[self._change(n, _vcd_value(value)) for n, value in enumerate(first)],
            "$end",
        ]
        output.append(("\n".join(head) + "\n").encode())

    def write(self, batch: Batch) -> None:
        lines = self._changes(batch)
        new = np.flatnonzero(np.diff(batch.times, prepend=self._last_ns))
        for at, time_ns in zip(new.tolist(), batch.times[new].tolist(), strict=True):
            lines[at] = f"#{time_ns}\n{lines[at]}"
        if lines:
            self._output.append(("\n".join(lines) + "\n").encode())
            self._last_ns = int(batch.times[-1])

    def _changes(self, batch: Batch) -> list[str]:
        """Convert each change to a line; those of levels, which are the most, are built in advance."""
        values, signals = batch.values, batch.signals
        levels = np.array([signal.kind in (LEVEL, STEP) for signal in self._signals], bool)[signals]
        known = np.array([f"{level}{identifier}" for identifier in self._ids for level in (0, 1)], object)
        lines: list[str] = known[np.where(levels, 2 * signals + values, 0)].tolist()
        others = np.flatnonzero(~levels)
        shown = decoded(batch, signals[others], values[others], self._signals, _vcd_value)
        for at, n, value in zip(others.tolist(), signals[others].tolist(), shown, strict=True):
            lines[at] = self._change(n, value)
        return lines

    def end(self, now_ns: int) -> None:
        if now_ns > self._last_ns:
            self._output.append(f"#{now_ns}\n".encode())

    def _change(self, n: int, value: float | str) -> str:
        kind = self._signals[n].kind
        if kind == COUNT:
            return f"b{int(value) & ALL_BITS:b} {self._ids[n]}"
        if kind == REAL:
            return f"r{value!r} {self._ids[n]}"
        return f"s{value} {self._ids[n]}" if kind == TEXT else f"{value}{self._ids[n]}"

    def _scopes(self) -> list[str]:
        found: list[str] = []
        inside: list[str] = []
        for signal, identifier in zip(self._signals, self._ids, strict=True):
            path = signal.scope.split(".")
            shared = next(
                (n for n, (a, b) in enumerate(zip(inside, path, strict=False)) if a != b), min(len(inside), len(path))
            )
            found += ["$upscope $end"] * (len(inside) - shared)
            found += [f"$scope module {name} $end" for name in path[shared:]]
            inside = path
            size = 64 if signal.kind in (COUNT, REAL) else 1
            kind = "wire" if signal.kind == STEP else signal.kind
            found.append(f"$var {kind} {size} {identifier} {signal.name} $end")
        return found + ["$upscope $end"] * len(inside)


class SigrokSink(VcdSink):
    """Writes a VCD file that every version of sigrok and PulseView reads.

    The file has no scopes, because sigrok would show only the last part of a name.  Integers are written as real
    numbers, because old versions of sigrok cannot read integers.  Texts are left out.
    """

    def _change(self, n: int, value: float | str) -> str:
        if self._signals[n].kind in (COUNT, REAL):
            return f"r{float(value)!r} {self._ids[n]}"
        return super()._change(n, value)

    def _scopes(self) -> list[str]:
        return [
            f"$var {'real 64' if signal.kind in (COUNT, REAL) else 'wire 1'} {identifier} {signal.full} $end"
            for signal, identifier in zip(self._signals, self._ids, strict=True)
        ]


def units(signals: Iterable[Signal]) -> dict[str, str]:
    """Return the units of signals; the keys are the full names of the signals."""
    return {signal.full: signal.unit for signal in signals if signal.unit}


def decoded(
    batch: Batch, signals: "NDArray[np.int64]", values: "NDArray[np.int64]", known: Sequence[Signal],
    show: Callable[[Value], float | str],
) -> list[float | str]:  # fmt: skip
    """Convert stored integers to values; `show` formats floating-point numbers and texts."""
    found: list[float | str] = values.tolist()
    kinds = np.array([{REAL: 1, TEXT: 2}.get(signal.kind, 0) for signal in known], np.int64)[signals]
    for at in np.flatnonzero(kinds == 1).tolist():
        found[at] = show(float(values[at : at + 1].view(np.float64)[0]))
    for at in np.flatnonzero(kinds == 2).tolist():
        found[at] = show(batch.texts[values[at]])
    return found


def csv_field(text: str) -> str:
    """Return a text as a CSV field, in quotes if the text contains special characters."""
    return f'"{text.replace(chr(34), chr(34) * 2)}"' if any(sign in text for sign in ',"#\r\n') else text


def _vcd_value(value: Value) -> float | str:
    return CHARACTERS.show(value).replace(" ", r"\x20") if isinstance(value, bytes) else value


def _csv_value(value: Value) -> str:
    return csv_field(CHARACTERS.show(value)) if isinstance(value, bytes) else repr(value)


def _vcd_head(provenance: Provenance) -> list[str]:
    from axistwin.records.traces.axes import STEP_NS

    told = [f"  {key}: {value}".replace("$", "%24") for key, value in provenance.items()]
    note = f"  virtual time from 0; step pulses are drawn {STEP_NS} ns wide"
    return ["$comment", *told, note, "$end", "$timescale 1 ns $end"]


FIRST_SIGN, SIGNS = 33, 94


def _identifier(n: int) -> str:
    word = chr(FIRST_SIGN + n % SIGNS)
    return word if n < SIGNS else _identifier(n // SIGNS - 1) + word


def _parquet(*arguments: object) -> Sink:
    from axistwin.records.traces.parquet import ParquetSink

    return ParquetSink(*arguments)  # type: ignore[arg-type]


MakeSink = Callable[[Output, Sequence[Signal], Sequence[Value], int, Provenance], Sink]
SINKS: Mapping[str, MakeSink] = {".csv": CsvSink, WAVES: VcdSink, SIGROK: SigrokSink, ".parquet": _parquet}


def ending(path: Path) -> str:
    """Return the ending of a trace file's name, e.g. `.csv` or `.sigrok.vcd`.  The ending selects the file format."""
    return SIGROK if path.name.endswith(SIGROK) else path.suffix


def sink_for(path: Path) -> MakeSink:
    """Return the writer for files with this ending.  Raises UsageError for another ending, or MissingExtraError."""
    if ending(path) not in SINKS:
        *others, last = SINKS
        raise UsageError(
            f"{path.name!r} is not a name for a trace: expected a name that ends in {', '.join(others)} or {last}"
        )
    if path.suffix == ".parquet":
        from axistwin.records.traces.parquet import require_pyarrow

        require_pyarrow()
    return SINKS[ending(path)]


def supported(path: Path, signals: Iterable[Signal]) -> list[Signal]:
    left_out = {WAVES: (), SIGROK: (TEXT,)}.get(ending(path), (STEP,))
    return [signal for signal in signals if signal.kind not in left_out]
