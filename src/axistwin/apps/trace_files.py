"""Files that a trace is written to: `.csv`, and `.vcd` for GTKWave."""

import csv
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import IO, Any, Protocol

from axistwin import __version__
from axistwin.apps.visible import CHARACTERS
from axistwin.errors import UsageError

STEP_NS = 250
"""How long a step pulse is drawn: shorter than half the period of the fastest controller."""

LEVEL, COUNT, STEP, TEXT, VOLTS = "wire", "integer", "step", "string", "real"
"""Kinds of signals: a level 0 or 1, a number, a level that is high for a moment, characters, a voltage."""

Write = Callable[[int, Any], object]
"""Writes a change: when, and to what.  In order of time, whatever the signal."""


class Sink(Protocol):
    """A file that changes are written to."""

    def add(self, scope: str, name: str, kind: str, value: float) -> Write:
        """A signal, and what it is to begin with; all are added before anything changes."""

    def end(self, now_ns: int) -> None:
        """Nothing more comes."""


class CsvSink:
    """Rows of time_ns, signal, value; the first rows say how everything is.  A pulse is a row of `pulses`."""

    def __init__(self, file: IO[str], now_ns: int) -> None:
        self._rows, self._now_ns = csv.writer(file, lineterminator="\n"), now_ns
        self._rows.writerow(("time_ns", "signal", "value"))

    def add(self, scope: str, name: str, kind: str, value: float) -> Write:
        """Its changes are rows; of step pulses there are none."""
        if kind == STEP:
            return lambda time_ns, value: None
        signal, row = f"{scope}.{name}", self._rows.writerow
        if kind == TEXT:
            row((self._now_ns, signal, ""))
            return lambda time_ns, text: row((time_ns, signal, CHARACTERS.show(text)))
        row((self._now_ns, signal, value))
        return lambda time_ns, value: row((time_ns, signal, value))

    def end(self, now_ns: int) -> None:
        """Nothing to add."""


class VcdSink:
    """A value change dump with a time scale of 1 ns, a scope for each controller and each axis."""

    def __init__(self, file: IO[str], now_ns: int) -> None:
        from vcd import VCDWriter

        comment = f"axistwin {__version__}; virtual time from 0; step pulses are drawn {STEP_NS} ns wide"
        self._vcd = VCDWriter(
            file, timescale="1 ns", date="", comment=comment, init_timestamp=now_ns, check_values=False
        )

    def add(self, scope: str, name: str, kind: str, value: float) -> Write:
        """Its changes are value changes."""
        change = self._vcd.change
        if kind == TEXT:
            text = self._vcd.register_var(scope, name, "string", init="")
            return lambda time_ns, data: change(text, time_ns, _vcd_text(data))
        type_, size = {COUNT: ("integer", 64), VOLTS: ("real", 64)}.get(kind, ("wire", 1))
        return partial(change, self._vcd.register_var(scope, name, type_, size, init=value))

    def end(self, now_ns: int) -> None:
        """The dump goes up to here."""
        self._vcd.close(now_ns)


SINKS: Mapping[str, Callable[[IO[str], int], Sink]] = {".csv": CsvSink, ".vcd": VcdSink}


def sink_for(path: Path) -> Callable[[IO[str], int], Sink]:
    """What writes this kind of file.  Raises UsageError if there is none."""
    try:
        return SINKS[path.suffix]
    except KeyError:
        raise UsageError(f"no trace in {path.name!r}: name a file {' or '.join(SINKS)}") from None


def _vcd_text(data: bytes) -> str:
    r"""Characters as text; the writer itself sees to blanks, `\r` and `\n`."""
    return "".join(chr(byte) if 0x20 <= byte < 0x7F or byte in b"\r\n" else f"<{byte:02X}>" for byte in data)
