"""Files for traces: `.csv`, `.vcd` for GTKWave, `.parquet` for analysis.

A file can be read at any time during writing: it grows by whole rows, and rows cut by a full disk are removed.  Each
file holds its provenance (`provenance.py`), as comments or as Parquet metadata.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from axistwin.bench.codec import CHARACTERS
from axistwin.errors import UsageError
from axistwin.traces.batch import Batch, Value
from axistwin.traces.output import Output, Provenance
from axistwin.traces.signals import COUNT, LEVEL, REAL, STEP, TEXT, Signal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ALL_BITS = 0xFFFF_FFFF_FFFF_FFFF
WAVES = ".vcd"
"""Suffix of the files with step pulses.  In other files the signal `pulses` is enough."""


class Sink(Protocol):
    """Writer of one kind of file."""

    def write(self, batch: Batch) -> None:
        """Write changes, all later than those before.  Raises OSError."""

    def flush(self) -> None:
        """Make everything written so far readable for other programs.  Raises OSError."""

    def end(self, now_ns: int) -> None:
        """Write the end of the trace.  Raises OSError."""


class TextSink:
    """Writer of text."""

    def flush(self) -> None:
        """Do nothing: each line is written at once."""


class CsvSink(TextSink):
    """Writes rows of time_ns, signal, value; the first rows give the initial values.  A pulse is a row of `pulses`."""

    def __init__(
        self, output: Output, signals: Sequence[Signal], first: Sequence[Value], now_ns: int, provenance: Provenance
    ) -> None:
        self._output, self._signals = output, signals
        self._names = [f",{csv_field(signal.full)}," for signal in signals]
        lines = [f"# {key}: {value}" for key, value in provenance.items()]
        lines += [f"# signal: {signal.full} {signal.kind}" for signal in signals]
        lines.append("time_ns,signal,value")
        lines += [f"{now_ns}{name}{_csv_value(value)}" for name, value in zip(self._names, first, strict=True)]
        output.append(("\n".join(lines) + "\n").encode())

    def write(self, batch: Batch) -> None:
        """Write a row for each change."""
        values = decoded(batch, batch.signals, batch.values, self._signals, _csv_value)
        names = self._names
        rows = zip(batch.times.tolist(), batch.signals.tolist(), values, strict=True)
        self._output.append("".join([f"{time_ns}{names[n]}{value}\n" for time_ns, n, value in rows]).encode())

    def end(self, now_ns: int) -> None:
        """Write the end as a comment."""
        self._output.append(f"# end_ns: {now_ns}\n".encode())


class VcdSink(TextSink):
    """Writes a value change dump with a time scale of 1 ns, and a scope for each controller and each axis."""

    def __init__(
        self, output: Output, signals: Sequence[Signal], first: Sequence[Value], now_ns: int, provenance: Provenance
    ) -> None:
        self._output, self._signals = output, signals
        self._ids = [_identifier(n) for n in range(len(signals))]
        self._last_ns = now_ns
        dump = [self._change(n, _vcd_value(value)) for n, value in enumerate(first)]
        head = [
            *_vcd_head(provenance),
            *self._scopes(),
            "$enddefinitions $end",
            f"#{now_ns}",
            "$dumpvars",
            *dump,
            "$end",
        ]
        output.append(("\n".join(head) + "\n").encode())

    def write(self, batch: Batch) -> None:
        """Write each time and the changes at that time."""
        import numpy as np

        lines = self._changes(batch)
        new = np.flatnonzero(np.diff(batch.times, prepend=self._last_ns))
        for at, time_ns in zip(new.tolist(), batch.times[new].tolist(), strict=True):
            lines[at] = f"#{time_ns}\n{lines[at]}"
        if lines:
            self._output.append(("\n".join(lines) + "\n").encode())
            self._last_ns = int(batch.times[-1])

    def _changes(self, batch: Batch) -> list[str]:
        """Return a line for each change; lines for levels are built in advance, because most changes are levels."""
        import numpy as np

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
        """Write the time of the end."""
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
        """Return the nested scopes, in the order of the signals."""
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


def decoded(
    batch: Batch,
    signals: "NDArray[np.int64]",
    values: "NDArray[np.int64]",
    known: Sequence[Signal],
    show: Callable[[Value], float | str],
) -> list[float | str]:
    """Return integers as they are, and reals and texts as `show` formats them."""
    import numpy as np

    found: list[float | str] = values.tolist()
    kinds = np.array([{REAL: 1, TEXT: 2}.get(signal.kind, 0) for signal in known], np.int64)[signals]
    for at in np.flatnonzero(kinds == 1).tolist():
        found[at] = show(float(values[at : at + 1].view(np.float64)[0]))
    for at in np.flatnonzero(kinds == 2).tolist():
        found[at] = show(batch.texts[values[at]])
    return found


def csv_field(text: str) -> str:
    """Return a CSV field, quoted where necessary and where it would be read as a comment."""
    return f'"{text.replace(chr(34), chr(34) * 2)}"' if any(sign in text for sign in ',"#\r\n') else text


def _vcd_value(value: Value) -> float | str:
    """Return characters as one VCD word."""
    return CHARACTERS.show(value).replace(" ", r"\x20") if isinstance(value, bytes) else value


def _csv_value(value: Value) -> str:
    return csv_field(CHARACTERS.show(value)) if isinstance(value, bytes) else repr(value)


def _vcd_head(provenance: Provenance) -> list[str]:
    from axistwin.traces.axes import STEP_NS

    told = [f"  {key}: {value}".replace("$", "%24") for key, value in provenance.items()]
    note = f"  virtual time from 0; step pulses are drawn {STEP_NS} ns wide"
    return ["$comment", *told, note, "$end", "$timescale 1 ns $end"]


FIRST_SIGN, SIGNS = 33, 94


def _identifier(n: int) -> str:
    """Return the n-th identifier: the shortest ones first, of printable characters."""
    word = chr(FIRST_SIGN + n % SIGNS)
    return word if n < SIGNS else _identifier(n // SIGNS - 1) + word


def _parquet(*arguments: object) -> Sink:
    from axistwin.traces.parquet import ParquetSink  # lazy import: needs an extra

    return ParquetSink(*arguments)  # type: ignore[arg-type]


MakeSink = Callable[[Output, Sequence[Signal], Sequence[Value], int, Provenance], Sink]
SINKS: Mapping[str, MakeSink] = {".csv": CsvSink, WAVES: VcdSink, ".parquet": _parquet}


def sink_for(path: Path) -> MakeSink:
    """Return the writer for this kind of file.  Raises UsageError or MissingExtraError if there is none."""
    if path.suffix not in SINKS:
        *others, last = SINKS
        raise UsageError(
            f"{path.name!r} is not a name for a trace: expected a name that ends in {', '.join(others)} or {last}"
        )
    if path.suffix == ".parquet":
        from axistwin.traces.parquet import require_pyarrow

        require_pyarrow()
    return SINKS[path.suffix]


def supported(path: Path, signals: Iterable[Signal]) -> list[Signal]:
    """Return the signals that this kind of file keeps."""
    return [signal for signal in signals if signal.kind != STEP or path.suffix == WAVES]
