"""Files that a trace is written to: `.csv`, and `.vcd` for GTKWave."""

import csv
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO, NamedTuple, Protocol

from axistwin import __version__
from axistwin.apps.visible import CHARACTERS
from axistwin.errors import UsageError

STEP_NS = 250
"""How long a step pulse is drawn: shorter than half the period of the fastest controller."""

LEVEL, COUNT, STEP, TEXT = "wire", "integer", "step", "string"


class Signal(NamedTuple):
    """Something that is traced."""

    scope: str
    name: str
    kind: str


class Sink(Protocol):
    """A file that changes are written to."""

    def begin(self, now_ns: int, initial: Mapping[Signal, int | bytes]) -> None:
        """All signals there are, and what they are now."""

    def change(self, time_ns: int, signal: Signal, value: int | bytes) -> None:
        """In order of time."""

    def end(self, now_ns: int) -> None:
        """Nothing more comes."""


class CsvSink:
    """Rows of time_ns, signal, value.  A pulse is a row of the axis's `pulses`."""

    def __init__(self, file: IO[str]) -> None:
        self._rows = csv.writer(file, lineterminator="\n")
        self._rows.writerow(("time_ns", "signal", "value"))

    def begin(self, now_ns: int, initial: Mapping[Signal, int | bytes]) -> None:
        """The first rows say how everything is."""
        for signal, value in initial.items():
            self.change(now_ns, signal, value)

    def change(self, time_ns: int, signal: Signal, value: int | bytes) -> None:
        """A row."""
        if signal.kind != STEP:
            shown = CHARACTERS.show(value) if isinstance(value, bytes) else value
            self._rows.writerow((time_ns, f"{signal.scope}.{signal.name}", shown))

    def end(self, now_ns: int) -> None:
        """Nothing to add."""


class VcdSink:
    """A value change dump with a time scale of 1 ns."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file

    def begin(self, now_ns: int, initial: Mapping[Signal, int | bytes]) -> None:
        """Declare the signals, a scope for each controller and each axis."""
        from vcd import VCDWriter

        comment = f"axistwin {__version__}; virtual time from 0; step pulses are drawn {STEP_NS} ns wide"
        self._vcd = VCDWriter(self._file, timescale="1 ns", date="", comment=comment, init_timestamp=now_ns)
        kinds = {LEVEL: ("wire", 1), STEP: ("wire", 1), COUNT: ("integer", 64), TEXT: ("string", None)}
        self._variables = {
            signal: self._vcd.register_var(signal.scope, signal.name, *kinds[signal.kind], init=_vcd_value(value))
            for signal, value in initial.items()
        }

    def change(self, time_ns: int, signal: Signal, value: int | bytes) -> None:
        """A value change."""
        self._vcd.change(self._variables[signal], time_ns, _vcd_value(value))

    def end(self, now_ns: int) -> None:
        """The dump goes up to here."""
        self._vcd.close(now_ns)


SINKS: Mapping[str, Callable[[IO[str]], Sink]] = {".csv": CsvSink, ".vcd": VcdSink}


def sink_for(path: Path) -> Callable[[IO[str]], Sink]:
    """What writes this kind of file.  Raises UsageError if there is none."""
    try:
        return SINKS[path.suffix]
    except KeyError:
        raise UsageError(f"no trace in {path.name!r}: name a file {' or '.join(SINKS)}") from None


def _vcd_value(value: int | bytes) -> int | str:
    r"""Characters as text; the writer itself sees to blanks, `\r` and `\n`."""
    if isinstance(value, int):
        return value
    return "".join(chr(byte) if 0x20 <= byte < 0x7F or byte in b"\r\n" else f"<{byte:02X}>" for byte in value)
