"""Draw a shadow's log: what moves take longer than usual, and the findings."""

import json
from collections import Counter
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.core.errors import UsageError, reason
from axistwin.core.units import MS
from axistwin.real.shadow.findings import TOLERANCE_NS
from axistwin.records.plots.picture import ALARM, COLOURS, INK, PALE, check_suffix, write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TOLERANCE_MS = TOLERANCE_NS / MS  # What is usual, without --tolerance.

_WIDTH, _DRIFT, _ROW = 9.0, 3.2, 0.2  # Width of the picture, height of the upper part and of a finding, in inches.
MOST_KINDS = len(COLOURS)  # Kinds of moves that are drawn, those made most often.
MOST_FINDINGS = 12  # Findings that are written out, the first ones.


def save(log: Path, path: Path, title: str = "") -> None:
    """Draw a log to a PNG or SVG file.  Raises UsageError."""
    check_suffix(path)
    lines = list(_lines(log))
    moves = [line for line in lines if line.get("type") == "moves"]
    findings = [line for line in lines if line.get("type") == "finding"]
    if not moves:
        raise UsageError(f"{log} contains no moves: they are written every hour, and at the end of axistwin shadow")

    def draw(figure: "Figure") -> None:
        shown = findings[:MOST_FINDINGS]
        height = _ROW * (len(shown) + 1)
        figure.set_size_inches(_WIDTH, _DRIFT + height + 0.9)
        figure.set_layout_engine("constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[_DRIFT, height])
        _draw_drifts(above, moves)
        _draw_findings(below, shown, len(findings))
        for line in findings:
            above.axvline(_time(line), color=ALARM, linewidth=0.6, alpha=0.4)
        locator: Any = AutoDateLocator()  # type: ignore[no-untyped-call]
        below.xaxis.set_major_locator(locator)
        below.xaxis.set_major_formatter(ConciseDateFormatter(locator))  # type: ignore[no-untyped-call]
        below.set_xlabel("time (UTC)")
        figure.suptitle(title or log.name, x=0.012, ha="left", fontsize=11, color=INK)

    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

    write_figure(draw, path)


def _draw_drifts(axes: "Axes", moves: list[dict[str, Any]]) -> None:
    """Draw what moves take longer than usual; each line ends in its name, duration and drift."""
    counts: Counter[str] = Counter()
    for line in moves:
        counts[line["kind"]] += line["count"]
    ends = []
    for colour, (kind, _) in zip(COLOURS, counts.most_common(MOST_KINDS), strict=False):
        found = [line for line in moves if line["kind"] == kind]
        usual = [line.get("usual_ms", found[0]["later_ms"]) for line in found]
        times = [_time(line) for line in found]
        drifts = [line["later_ms"] - by for line, by in zip(found, usual, strict=True)]
        axes.plot(times, drifts, ".-", color=colour, linewidth=1.5)
        percent = drifts[-1] / 10 / (found[-1]["duration_s"] - drifts[-1] / 1000)
        ends.append((drifts[-1], f"{kind}: {drifts[-1]:+.0f} ms ({percent:+.1f} %)", colour))
    axes.axhspan(-TOLERANCE_MS, TOLERANCE_MS, color=PALE, alpha=0.4, linewidth=0)
    axes.set_ylabel("longer than usual (ms)")
    axes.margins(x=0.01)
    _write_ends(axes, ends)


def _write_ends(axes: "Axes", ends: list[tuple[float, str, str]]) -> None:
    """Write words at the ends of lines, one above the other where these are close."""
    low, high = axes.get_ylim()
    at = low
    for drift, words, colour in sorted(ends):
        at = max(at, drift)
        place = (1.01, (at - low) / (high - low))
        axes.text(*place, words, color=colour, fontsize=8, transform=axes.transAxes, va="center", clip_on=False)
        at += 0.08 * (high - low)


def _draw_findings(axes: "Axes", findings: list[dict[str, Any]], count: int) -> None:
    """Draw each finding at its time, in a row of its own."""
    low, high = axes.get_xlim()
    for row, line in enumerate(findings):
        time, words = _time(line), line.get("text", "")
        axes.plot([time], [row], "o", color=ALARM, markersize=4)
        left = (time - low) / (high - low) > 0.5
        axes.annotate(
            words, (time, row), xytext=(-6 if left else 6, 0), textcoords="offset points", fontsize=8, color=INK,
            ha="right" if left else "left", va="center", annotation_clip=False,
        )  # fmt: skip
    axes.set(ylim=(max(len(findings), 1) - 0.5, -0.5), yticks=[])
    axes.set_ylabel(f"{count or 'no'} finding{'s' * (count != 1)}")
    axes.spines["left"].set_visible(False)


def _lines(log: Path) -> Any:
    try:
        text = log.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"the log {log} cannot be read: {reason(error)}") from None
    for number, line in enumerate(text.splitlines(), 1):
        try:
            found = json.loads(line)
        except ValueError:
            raise UsageError(f"{log}:{number}: expected a line of JSON, as axistwin shadow --log writes it") from None
        if isinstance(found, dict):
            yield found


def _time(line: dict[str, Any]) -> float:
    """Return the time in days since 1970, as Matplotlib has it."""
    return datetime.fromisoformat(line["time"]).timestamp() / 86_400
