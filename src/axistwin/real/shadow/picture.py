"""Draw a shadow's log: durations of moves, what they are later than the twin, and the findings."""

import json
from collections import Counter
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.core.errors import UsageError
from axistwin.records.plots.picture import ALARM, COLOURS, INK, check_suffix, write_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE = 9.0, 5.0  # Width and height in inches.
MOST_KINDS = len(COLOURS)  # Kinds of moves that are drawn, those made most often.


def save(log: Path, path: Path, title: str = "") -> None:
    """Draw a log to a PNG or SVG file.  Raises UsageError."""
    check_suffix(path)
    lines = list(_lines(log))
    moves = [line for line in lines if line.get("type") == "moves"]
    findings = [line for line in lines if line.get("type") == "finding"]
    if not moves:
        raise UsageError(f"{log} contains no moves: they are written every hour, and at the end of axistwin shadow")

    def draw(figure: "Figure") -> None:
        figure.set_size_inches(_SIZE)
        figure.set_layout_engine("constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        counts: Counter[str] = Counter()
        for line in moves:
            counts[line["kind"]] += line["count"]
        for colour, (kind, _) in zip(COLOURS, counts.most_common(MOST_KINDS), strict=False):
            found = [line for line in moves if line["kind"] == kind]
            times = [_time(line) for line in found]
            above.plot(times, [line["duration_s"] for line in found], ".-", color=colour, label=kind, linewidth=1)
            below.plot(times, [line["later_ms"] for line in found], ".-", color=colour, linewidth=1)
            ends = ([line[name] for line in found] for name in ("least_ms", "most_ms"))
            below.fill_between(times, *ends, color=colour, alpha=0.15, linewidth=0)
        for line in findings:
            for axes in (above, below):
                axes.axvline(_time(line), color=ALARM, linewidth=0.8)
        above.set(ylabel="duration (s)")
        below.set(ylabel="later than the twin (ms)", xlabel="time (UTC); red: a finding")
        above.legend(fontsize=7, frameon=False)
        figure.autofmt_xdate()
        figure.suptitle(title or log.name, x=0.012, ha="left", fontsize=11, color=INK)

    write_figure(draw, path)


def _lines(log: Path) -> Any:
    try:
        text = log.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{log} cannot be read: {error}") from None
    for number, line in enumerate(text.splitlines(), 1):
        try:
            found = json.loads(line)
        except ValueError:
            raise UsageError(f"{log}:{number}: expected a line of JSON, as axistwin shadow --log writes it") from None
        if isinstance(found, dict):
            yield found


def _time(line: dict[str, Any]) -> datetime:
    return datetime.fromisoformat(line["time"])
