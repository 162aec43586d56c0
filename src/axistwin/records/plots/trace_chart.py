"""Build a chart of a trace: axes, levels, registers and messages."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import count

from axistwin.core.errors import UsageError
from axistwin.core.lazy import np
from axistwin.plant.machine_units import MachineUnits
from axistwin.records.plots import chart
from axistwin.records.plots.chart import BACKGROUND, FLAT, HIDDEN, LOW, TALL, Chart, Curve, Fault, Line, Panel, Word
from axistwin.records.traces.reading import Trace, Track
from axistwin.records.traces.signals import COUNT, EVERYTHING, FAULTS, LEVEL, REAL, TEXT

SAYS = ("host_says", "controller_says")
AXIS = ("pulses", "velocity", "position", "commanded")
BLANK = r"\x20"  # Escape sequence that replaces a space at the end of a text in a trace.
RAILS = (0.0, 5.0)  # Voltages at which logic levels are drawn: low and high.


def of_trace(
    trace: Trace, patterns: Sequence[str] = (EVERYTHING,), from_ns: int | None = None, to_ns: int | None = None,
    title: str = "",
) -> Chart:  # fmt: skip
    """Return a chart of the signals matched by patterns, from `from_ns` to `to_ns`.

    If a limit is None, the chart begins or ends with the events.  Raises UsageError for a pattern without a match.
    """
    return _Drawn(trace, trace.choose(tuple(patterns)), from_ns, to_ns, title, tuple(patterns) == (EVERYTHING,)).chart


class _Drawn:
    def __init__(
        self, trace: Trace, tracks: dict[str, Track], from_ns: int | None, to_ns: int | None, title: str, all_: bool
    ) -> None:
        self.tracks, self._all, self._about = tracks, all_, trace.about
        self._alone = len({name.partition(".")[0] for name in trace.tracks}) == 1
        found_from, _, edge = chart.span(trace.begin_ns, trace.end_ns, self._times())
        last = edge if to_ns is None else to_ns
        first = found_from if from_ns is None else from_ns
        self.chart = Chart(title, first, min(trace.end_ns, last), max(last, first + 1))
        self._colours = count()
        self._add_axes()
        for name, track in tracks.items():
            self._add(name, track)

    def _times(self) -> list[int]:
        found = []
        for name, track in self.tracks.items():
            last = name.rpartition(".")[2]
            if len(track) > 1 and last not in BACKGROUND and last not in SAYS and track.kind != TEXT:
                found += [track.times[1], track.times[-1]]
        return found

    def _short(self, name: str) -> str:
        return name.partition(".")[2] if self._alone else name

    def _changes(self, track: Track) -> bool:
        return any(self.chart.from_ns < track.times[n] <= self.chart.to_ns for n in range(1, len(track)))

    def _add_axes(self) -> None:
        scopes = dict.fromkeys(name.rpartition(".")[0] for name in self.tracks)
        for scope in scopes:
            tracks = {one: self.tracks[f"{scope}.{one}"] for one in AXIS if f"{scope}.{one}" in self.tracks}
            axis = {one: track for one, track in tracks.items() if track.kind != TEXT}
            if any(self._changes(track) for track in axis.values()):
                first = len(self.chart.panels)
                self._add_axis(self._short(scope), axis)
                if (units := self._units(scope)) is not None:
                    self.chart.panels[first:] = [in_units(panel, units) for panel in self.chart.panels[first:]]

    def _units(self, scope: str) -> MachineUnits | None:
        written = self._about.get(f"units {scope}")
        try:
            return None if written is None else MachineUnits.written(written)
        except UsageError:
            return None

    def _add_axis(self, name: str, axis: dict[str, Track]) -> None:
        colour, span = next(self._colours), (self.chart.from_ns, self.chart.to_ns)
        curves = {one: chart.held(*track.columns(), *span) for one, track in axis.items()}
        if "position" in axis and "commanded" in axis:
            velocity = chart.rate(*axis["position"].columns(), *span)
            error = difference(axis["commanded"], axis["position"], span)
            places = [
                Line(curves["position"], legend="position"),
                Line(curves["commanded"], faint=True, legend="commanded"),
            ]
            self.chart.panels += [
                Panel(f"{name}  velocity\ncounts/s", [Line(velocity)], TALL, filled=True, colour=colour),
                Panel(f"{name}  position\ncounts", places, TALL, colour=colour),
                Panel(f"{name}  following\nerror, counts", [Line(error)], LOW, filled=True, colour=colour),
            ]
            return
        if "velocity" in curves:
            line = Line(curves.pop("velocity"))
            self.chart.panels.append(Panel(f"{name}  velocity\npulses/s", [line], TALL, filled=True, colour=colour))
        for one, curve in curves.items():
            label = "position\npulses" if one == "pulses" else f"{one}\ncounts"
            self.chart.panels.append(Panel(f"{name}  {label}", [Line(curve)], colour=colour))

    def _add(self, name: str, track: Track) -> None:
        last = name.rpartition(".")[2]
        if last in SAYS and track.kind == TEXT:
            self._add_words(name, track)
        elif last == FAULTS:
            self.chart.add_faults(faults(track))
        elif last in AXIS or not self._changes(track) or (self._all and last in HIDDEN):
            return
        elif track.kind == LEVEL or (track.kind == COUNT and set(track.values) <= {0, 1}):
            self.chart.lanes[self._short(name)] = chart.held(*track.columns(), self.chart.from_ns, self.chart.to_ns)
        elif track.kind == TEXT:
            self.chart.states[self._short(name)] = states(track, self.chart.from_ns, self.chart.to_ns)
        elif track.kind == COUNT or (track.kind == REAL and not set(track.values) <= set(RAILS)):
            curve = chart.held(*track.columns(), self.chart.from_ns, self.chart.to_ns)
            label = self._short(name).replace("_volts", "\nvolts")
            self.chart.panels.append(Panel(label, [Line(curve)], FLAT, colour=next(self._colours)))

    def _add_words(self, name: str, track: Track) -> None:
        scope, _, which = name.rpartition(".")
        if self._alone:
            who = "host" if which == "host_says" else "controller"
        else:
            who = f"host to {scope}" if which == "host_says" else scope
        words = [w for w in messages(track) if self.chart.from_ns <= w.time_ns <= self.chart.to_ns]
        if words:
            self.chart.words[who] = words


def in_units(panel: Panel, units: MachineUnits) -> Panel:
    """Convert curves to a machine unit, e.g. mm; a second scale shows pulses or counts."""
    label, _, counts = panel.label.replace("error, counts", "error\ncounts").rpartition("\n")
    per_second = "/s" if counts.endswith("/s") else ""
    joint = ", " if label.endswith("error") else "\n"
    per = float(units.per)
    lines = [replace(line, curve=line.curve.divided(per)) for line in panel.lines]
    return replace(panel, label=f"{label}{joint}{units.of}{per_second}", lines=lines, per=per, counts=counts)


def states(track: Track, from_ns: int, to_ns: int) -> list[Word]:
    found = [Word(time_ns, str(text)) for time_ns, text in zip(track.times, track.values, strict=True)]
    before = [state for state in found if state.time_ns <= from_ns][-1:]
    return before + [state for state in found if from_ns < state.time_ns <= to_ns]


def faults(track: Track) -> Iterator[Fault]:
    there: dict[str, int] = {}
    for time_ns, text in zip(track.times, track.values, strict=True):
        names = [name for name in str(text).split(", ") if name]
        for name in [name for name in there if name not in names]:
            yield Fault(name, there.pop(name), time_ns)
        there = dict.fromkeys(names, time_ns) | there
    yield from (Fault(name, begin_ns) for name, begin_ns in there.items())


def messages(track: Track) -> list[Word]:
    """Join characters into messages; each value has one more than that before: `X`, `X3`, `X3@`."""
    found: list[Word] = []
    before = ""
    for time_ns, text in zip(track.times, track.values, strict=True):
        assert isinstance(text, str), "messages are texts"
        if text and before and text.startswith(before):
            found[-1] = Word(found[-1].time_ns, text)
        elif text:
            found.append(Word(time_ns, text))
        before = f"{text.removesuffix(BLANK)} " if text.endswith(BLANK) else text
    return found


def difference(of: Track, less: Track, span: tuple[int, int]) -> Curve:
    (times, values), (others, those) = of.columns(), less.columns()
    both = np.union1d(times, others)
    here = np.maximum(np.searchsorted(times, both, "right") - 1, 0)
    return chart.held(both, values[here] - those[np.maximum(np.searchsorted(others, both, "right") - 1, 0)], *span)
