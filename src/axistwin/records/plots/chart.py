"""Contents of a picture: panels with curves, lanes with levels, and messages, on one time axis."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from axistwin.core.lazy import NDArray, np
from axistwin.core.units import MS, S

TALL, MIDDLE, LOW, FLAT = 1.15, 0.95, 0.75, 0.55  # Heights of a panel in inches.
HIDDEN = ("rts", "host.dtr", "host.rts", "host_dtr", "host_rts", "direction", "step", "index")
"""Signals that are drawn only on request, because messages or curves contain the same information."""
BACKGROUND = (*HIDDEN, "led", "dtr")  # Signals that are ignored when the default time range of a chart is chosen.
MOST = 10_000  # Largest number of points of a curve; longer curves are reduced to the extremes of groups of points.


@dataclass
class Curve:
    """A curve of a chart, with its values and times.  `times`: time in seconds at which each value starts."""

    times: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def divided(self, by: float) -> "Curve":
        return Curve(self.times, [value / by for value in self.values])

    def thinned(self, most: int = MOST) -> "Curve":
        """Reduce the points to at most `most`, without a visible change in a picture."""
        if len(self.times) <= most:
            return self
        thin = Curve([self.times[0]], [self.values[0]])
        group = 2 * len(self.times) // most + 1
        for first in range(1, len(self.times), group):
            values = self.values[first : first + group]
            thin.times += [self.times[first], self.times[min(first + group, len(self.times)) - 1]]
            thin.values += [min(values), max(values)]
        thin.times.append(self.times[-1])
        thin.values.append(self.values[-1])
        return thin


@dataclass(frozen=True)
class Fault:
    """A fault to draw, with name, start and end; `end_ns` is None while it is active."""

    name: str
    begin_ns: int
    end_ns: int | None = None


@dataclass
class Line:
    """A curve in a panel of a chart, with its label and line style."""

    curve: Curve
    faint: bool = False
    legend: str = ""


@dataclass
class Panel:
    """One diagram of a chart, with its curves.

    `filled`: fill the area between the curve and zero.  `colour`: index of the colour.  `per`: pulses or counts per
    unit of the values; a second scale on the right shows `counts`.
    """

    label: str
    lines: list[Line]
    height: float = MIDDLE
    filled: bool = False
    colour: int = 0
    per: float | None = None
    counts: str = ""


@dataclass(frozen=True)
class Word:
    """A text with its start time."""

    time_ns: int
    text: str


@dataclass
class Chart:
    """A picture with a time axis from `from_ns` to `edge_ns`; the data end at `to_ns`."""

    title: str
    from_ns: int
    to_ns: int
    edge_ns: int
    panels: list[Panel] = field(default_factory=list)
    lanes: dict[str, Curve] = field(default_factory=dict)
    states: dict[str, list[Word]] = field(default_factory=dict)
    """Texts by lane; each text is valid until the next text starts."""
    words: dict[str, list[Word]] = field(default_factory=dict)
    marks: list[Word] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)

    def add_faults(self, faults: Iterable[Fault]) -> None:
        seen = (f for f in faults if f.begin_ns <= self.to_ns and (f.end_ns is None or f.end_ns >= self.from_ns))
        self.faults += sorted(seen, key=lambda fault: (fault.begin_ns, fault.name))


def span(begin_ns: int, end_ns: int, times: Sequence[int]) -> tuple[int, int, int]:
    """Return three times in ns: the start of a chart, the end of its data, and the end of its time axis.

    The drawn time contains all events with a margin; without events, the whole time from `begin_ns` to `end_ns`.
    """
    if not times:
        return begin_ns, end_ns, max(end_ns, begin_ns + 1)
    margin_ns = (max(times) - min(times)) // 25 + 20 * MS
    from_ns, edge_ns = max(begin_ns, min(times) - margin_ns), max(times) + margin_ns
    return from_ns, min(edge_ns, end_ns), edge_ns


def held(times: "NDArray[np.int64]", values: "NDArray[Any]", from_ns: int, to_ns: int) -> Curve:
    first = max(int(np.searchsorted(times, from_ns, "right")) - 1, 0)
    last = int(np.searchsorted(times, to_ns, "right"))
    seen = values[first:last] if last > first else values[first : first + 1]
    at = np.clip(times[first : first + len(seen)], from_ns, to_ns)
    return Curve([*(at / S).tolist(), to_ns / S], [*seen.tolist(), float(seen[-1])])


BINS = 1500
SHORTEST_NS = 4 * MS
"""Shortest time for the average of a velocity; one count in a single sample would be thousands of counts/s."""


def rate(times: "NDArray[np.int64]", values: "NDArray[np.int64]", from_ns: int, to_ns: int) -> Curve:
    """Return the velocity of an axis in pulses/s or counts/s, calculated from its positions."""
    bins = max(1, min(BINS, (to_ns - from_ns) // SHORTEST_NS))
    edges = from_ns + (to_ns - from_ns) * np.arange(bins + 1, dtype=np.int64) // bins
    where = np.maximum(np.searchsorted(times, edges, "right") - 1, 0)
    rates = np.diff(values[where]) * (S / np.maximum(np.diff(edges), 1))
    return Curve((edges / S).tolist(), [*rates.tolist(), float(rates[-1])])
