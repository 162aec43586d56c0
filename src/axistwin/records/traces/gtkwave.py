"""Write a GTKWave save file beside a VCD file: `moves.gtkw` opens `moves.vcd` with groups and analog lanes."""

import io
from collections.abc import Sequence
from itertools import groupby
from math import log2
from pathlib import Path
from typing import TYPE_CHECKING

from axistwin.records.traces.signals import COUNT, REAL, TEXT, Signal

if TYPE_CHECKING:
    from vcd.gtkw import GTKWSave

HEAD = "[*] axistwin writes this file again with each trace; a file saved by GTKWave is kept"
"""First line of a save file.  GTKWave writes another first line."""
WIDTH_PIXELS, LANE_ROWS = 1000, 3  # Width of the waves, for the zoom, and height of an analog lane in rows.


def write_save_file(waves: Path, signals: Sequence[Signal], begin_ns: int, end_ns: int) -> None:
    """Write a GTKWave save file for a VCD file.

    A save file that the user has saved in GTKWave is not overwritten.  Raises OSError.
    """
    path = waves.with_suffix(".gtkw")
    if path.exists() and not path.read_bytes().startswith(HEAD.encode()):
        return
    path.write_text(f"{HEAD}\n{_contents(waves, signals, begin_ns, end_ns)}", encoding="utf-8")


def _contents(waves: Path, signals: Sequence[Signal], begin_ns: int, end_ns: int) -> str:
    from vcd.gtkw import GTKWSave

    text = io.StringIO()
    save = GTKWSave(text)
    save.dumpfile(waves.name, abspath=False)
    save.timestart(begin_ns)
    save.zoom_markers(-log2(max(end_ns - begin_ns, WIDTH_PIXELS) / WIDTH_PIXELS))
    for scope, members in groupby(signals, lambda signal: signal.scope):
        with save.group(scope):
            for signal in members:
                _add(save, signal)
    return text.getvalue()


def _add(save: "GTKWSave", signal: Signal) -> None:
    from vcd.gtkw import GTKWFlag

    name = f"{signal.full} [{signal.unit}]" if signal.unit else signal.full
    if signal.kind in (COUNT, REAL):
        save.trace(signal.full, name, datafmt="signed", extraflags=GTKWFlag.analog_step | GTKWFlag.analog_fullscale)
        for _ in range(LANE_ROWS - 1):
            save.blank(analog_extend=True)
    else:
        save.trace(signal.full, name, datafmt="ascii" if signal.kind == TEXT else "bin")
