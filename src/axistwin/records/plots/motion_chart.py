"""Build a chart of the motion of two traces: for each pair of axes the positions of both, and their difference."""

from typing import Any

from axistwin.core.lazy import NDArray, np
from axistwin.core.units import S
from axistwin.records.plots import chart
from axistwin.records.plots.chart import BINS, LOW, Chart, Curve, Line, Panel, Word
from axistwin.records.traces.motion import Leg, Motion


def of_motion(motion: Motion, broken: list[Leg], names: tuple[str, str], title: str = "") -> Chart:
    """Return a chart in the time of the first trace; the moves of the second one are drawn where the first has them."""
    edges = [edge for path, _ in motion.axes for span in path.moving for edge in span]
    made = Chart(title, *chart.span(0, motion.end_ns, edges))
    span = made.from_ns, made.to_ns
    for colour, (one, other) in enumerate(motion.axes):
        times, values = motion.aligned(other)
        lines = [
            Line(chart.held(one.times, one.values, *span), legend=names[0]),
            Line(chart.held(times, values, *span), faint=True, legend=names[1]),
        ]
        made.panels.append(Panel(f"{one.name}, {other.name}\n{one.unit}", lines, colour=colour))
        at = np.unique(np.concatenate((one.times, times)))
        difference = values[_held(times, at)] - one.values[_held(one.times, at)]
        made.panels.append(
            Panel(f"difference\n{one.unit}", [Line(_extremes(at, difference, *span))], LOW, filled=True, colour=colour)
        )
    made.marks = [Word(leg.apart_ns, f"{leg.axes[0].name} differs") for leg in broken[:1]]
    return made


def _held(times: "NDArray[np.int64]", at: "NDArray[np.int64]") -> "NDArray[Any]":
    return np.maximum(np.searchsorted(times, at, "right") - 1, 0)


def _extremes(times: "NDArray[np.int64]", values: "NDArray[Any]", from_ns: int, to_ns: int) -> Curve:
    """Return the value farthest from 0 of each of some 1500 times, so that no difference is too short to be seen."""
    bins = max(1, min(BINS, to_ns - from_ns))
    edges = from_ns + (to_ns - from_ns) * np.arange(bins + 1, dtype=np.int64) // bins
    first = _held(times, edges)
    spans = np.column_stack((first[:-1], np.maximum(_held(times, edges[1:] - 1) + 1, first[:-1] + 1))).ravel()
    ended = np.append(values, values[-1])
    low, high = np.minimum.reduceat(ended, spans)[::2], np.maximum.reduceat(ended, spans)[::2]
    extremes = np.where(-low > high, low, high).tolist()
    return Curve((edges / S).tolist(), [*extremes, extremes[-1]])
