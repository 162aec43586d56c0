"""Build a chart of two traces; each signal that differs is drawn twice, once from each trace."""

from axistwin.core.units import MS
from axistwin.records.plots import chart
from axistwin.records.plots.chart import FLAT, LOW, Chart, Line, Panel, Word
from axistwin.records.plots.trace_chart import states
from axistwin.records.traces.differences import Comparison
from axistwin.records.traces.reading import Trace, Track
from axistwin.records.traces.signals import TEXT

MOST = 12  # Largest number of differing signals in a chart.
BEFORE_NS, AFTER_NS = 100 * MS, 400 * MS  # Least time in the chart before and after the first difference.


def of_difference(first: Trace, second: Trace, found: Comparison, title: str = "") -> Chart:
    """Return a chart of the signals that differ first, beginning shortly before the first difference."""
    drawn = found.differences[:MOST]
    begin_ns, last_ns = drawn[0].time_ns, drawn[-1].time_ns
    around_ns = max(BEFORE_NS, (last_ns - begin_ns) // 4)
    from_ns = max(begin_ns - around_ns, first.begin_ns, second.begin_ns)
    to_ns = min(max(last_ns + around_ns, begin_ns + AFTER_NS), max(found.ends))
    made = Chart(title, from_ns, to_ns, max(to_ns, from_ns + 1))
    for number, difference in enumerate(drawn):
        _add(made, difference.signal, first.tracks.get(difference.signal), second.tracks.get(difference.signal), number)
    made.marks = [Word(begin_ns, f"first difference: {drawn[0].signal}")]
    return made


def _add(made: Chart, name: str, one: Track | None, other: Track | None, colour: int) -> None:
    tracks = [track for track in (one, other) if track is not None]
    span = made.from_ns, made.to_ns
    if any(track.kind == TEXT for track in tracks):
        for track, which in ((one, "first"), (other, "second")):
            if track is not None:
                made.states[f"{name}, {which}"] = states(track, *span)
        return
    lines = [
        Line(chart.held(*track.columns(), *span), faint=track is other, legend=which)
        for track, which in ((one, "first"), (other, "second"))
        if track is not None
    ]
    height = FLAT if all(set(track.values) <= {0, 1} for track in tracks) else LOW
    made.panels.append(Panel(name, lines, height, colour=colour))
