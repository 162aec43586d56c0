"""Draws what has moved over time, and below it levels and what was said.

Of a stepper velocity and position; of a servo its position, where it should have been, and the following error.
"""

from collections.abc import Iterator, Sequence
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.apps import curves, partners
from axistwin.apps.history import History, Move, Utterance
from axistwin.apps.servo_record import ServoRecord
from axistwin.errors import UsageError
from axistwin.units import S

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".svg", ".png")
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")  # told apart by all eyes
INK, PALE, LAMP = "#333333", "#D9D9D9", "#F0B000"
STYLE: dict[Any, Any] = {  # `rc_context` knows its keys by name
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#808080",
    "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK, "svg.hashsalt": "axistwin", "svg.fonttype": "none",
    "axes.formatter.limits": (-9, 12), "axes.formatter.useoffset": False,
}  # fmt: skip
WIDTH, VELOCITY, POSITION, ERROR, LANE, WORDS = 10, 1.15, 0.95, 0.75, 0.24, 0.75
"""Width of the picture and heights of its parts, in inches."""
WORDS_SIZE, ROWS, ROW_INCHES = 7.5, 2, 8.6
"""Words: font size, rows of text for each speaker, and about how many inches they have from left to right."""
UNSEEN = ("rts", "host.dtr", "host.rts")
"""Levels that are not drawn: they go with the words."""


def check_suffix(path: Path) -> None:
    """Raises UsageError if this is no kind of picture."""
    if path.suffix not in SUFFIXES:
        raise UsageError(f"no picture in {path.name!r}: name a file {' or '.join(SUFFIXES)}")


def draw(history: History, path: Path, title: str = "") -> None:
    """Draw a history into an SVG or PNG file."""
    check_suffix(path)
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        figure = _Picture(history, title).draw()
        metadata = {"Date": None} if path.suffix == ".svg" else {}
        try:
            figure.savefig(path, dpi=150, metadata=metadata)
        except OSError as error:
            raise UsageError(f"{path} cannot be written: {error.strerror}") from None


class _Picture:
    def __init__(self, history: History, title: str) -> None:
        self.history, self.title = history, title
        self.moves: dict[str, list[Move]] = {}
        for move in history.strokes():
            self.moves.setdefault(self._name(move.controller, move.axis), []).append(move)
        self.servos: dict[str, ServoRecord] = {
            self._name(servo.controller, servo.name): servo for servo in history.servos if len(servo.points())
        }
        self.from_ns, self.edge_ns = self._span()
        self.to_ns = min(self.edge_ns, history.bench.now)
        self.lanes = self._lanes()
        self.words = [u for u in history.said if self.from_ns <= u.time_ns <= self.to_ns]

    def _name(self, controller: str, name: str) -> str:
        return f"{controller}.{name}" if len(self.history.bench.controllers) > 1 else name

    def _span(self) -> tuple[int, int]:
        """The time in which something moves or switches, and a little around it; else all there is."""
        changes = [change for change in self.history.changes if change.pin not in (*UNSEEN, "led", "dtr")]
        moves = self.history.moves()
        begins = [move.start_ns for move in moves]
        ends = [move.end_ns or self.history.bench.now for move in moves]
        times = [*begins, *ends, *(change.time_ns for change in changes)]
        if not times:
            return self.history.began_ns, max(self.history.bench.now, self.history.began_ns + 1)
        margin_ns = (max(times) - min(times)) // 25 + 20_000_000
        return max(self.history.began_ns, min(times) - margin_ns), max(times) + margin_ns

    def _lanes(self) -> dict[str, curves.Curve]:
        """The levels that change while we look."""
        levels = dict(self.history.levels)
        found: dict[tuple[str, str], curves.Curve] = {}
        for change in self.history.changes:
            key = change.controller, change.pin
            if change.pin not in UNSEEN and self.from_ns <= change.time_ns <= self.to_ns:
                if key not in found:
                    found[key] = curves.Curve([self.from_ns / S], [levels[key]])
                found[key].add(change.time_ns, change.level)
            levels[key] = change.level
        for key, lane in found.items():
            lane.add(self.to_ns, levels[key])
        return {self._name(*key): lane.thinned() for key, lane in sorted(found.items())}

    def draw(self) -> "Figure":
        from matplotlib.figure import Figure
        from matplotlib.layout_engine import ConstrainedLayoutEngine

        heights = [VELOCITY, POSITION] * len(self.moves) + [VELOCITY, ERROR] * len(self.servos)
        heights += [0.2 + LANE * len(self.lanes)] * bool(self.lanes) + [WORDS]
        size = (WIDTH, sum(heights) + 0.16 * len(heights) + 0.9)
        figure = Figure(figsize=size, layout=ConstrainedLayoutEngine(hspace=0.02, h_pad=0.05, w_pad=0.12))
        rows = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0])
        rows[0].set_xlim(self.from_ns / S, self.edge_ns / S)
        colours = cycle(COLOURS)
        for name, moves in self.moves.items():
            colour = next(colours)
            self._draw_velocity(rows.pop(0), name, moves, colour)
            self._draw_position(rows.pop(0), name, moves, colour)
        for name, servo in self.servos.items():
            self._draw_servo(rows.pop(0), rows.pop(0), name, servo, next(colours))
        if self.lanes:
            self._draw_lanes(rows.pop(0))
        self._draw_words(rows.pop(0))
        figure.align_ylabels()
        if self.title:
            figure.suptitle(self.title, x=0.012, ha="left", fontsize=11, color=INK)
        return figure

    def _draw_velocity(self, row: "Axes", name: str, moves: Sequence[Move], colour: str) -> None:
        curve = curves.velocity(moves, self.from_ns, self.to_ns).thinned()
        row.fill_between(curve.times, curve.values, step="post", color=colour, alpha=0.22, linewidth=0)
        row.step(curve.times, curve.values, where="post", color=colour, linewidth=1.1)
        row.axhline(0, color="#808080", linewidth=0.6)
        _dress(row, f"{name}  velocity\npulses/s")

    def _draw_position(self, row: "Axes", name: str, moves: Sequence[Move], colour: str) -> None:
        curve = curves.position(moves, self.from_ns, self.to_ns).thinned()
        row.plot(curve.times, curve.values, color=colour, linewidth=1.4)
        _dress(row, f"{name}  position\npulses")

    def _draw_servo(self, row: "Axes", below: "Axes", name: str, servo: ServoRecord, colour: str) -> None:
        position, commanded, error = (
            curve.thinned() for curve in curves.servo(servo.points(), self.from_ns, self.to_ns)
        )
        row.plot(position.times, position.values, color=colour, linewidth=1.4, label="position")
        row.plot(commanded.times, commanded.values, color=INK, linewidth=0.8, linestyle="--", label="commanded")
        row.legend(loc="best", frameon=False, fontsize=7.5)
        _dress(row, f"{name}  position\ncounts")
        below.fill_between(error.times, error.values, color=colour, alpha=0.22, linewidth=0)
        below.plot(error.times, error.values, color=colour, linewidth=0.9)
        below.axhline(0, color="#808080", linewidth=0.6)
        _dress(below, f"{name}  following\nerror, counts")

    def _draw_lanes(self, row: "Axes") -> None:
        """One lane per terminal: a line that is up when the level is high, lit underneath."""
        for place, lane in enumerate(reversed(self.lanes.values())):
            levels = [place + 0.66 * level for level in lane.values]
            row.fill_between(lane.times, levels, place, step="post", color=LAMP, alpha=0.55, linewidth=0)
            row.step(lane.times, levels, where="post", color=INK, linewidth=0.9)
        row.set_ylim(-0.25, len(self.lanes))
        row.set_yticks([place + 0.33 for place in range(len(self.lanes))], list(reversed(self.lanes)))
        row.tick_params(axis="y", length=0)
        row.grid(axis="x", color=PALE, linewidth=0.5)

    def _draw_words(self, row: "Axes") -> None:
        """What was said, where there is room for it; a tick where there is none."""
        for by_host, place, mark in ((True, 1.0, ">"), (False, 0.0, "<")):
            said = [utterance for utterance in self.words if utterance.by_host is by_host]
            row.vlines([u.time_ns / S for u in said], place, place + 0.2, color=INK, linewidth=0.7)
            texts = [(u.time_ns, f"{mark} {self._shown(u)}") for u in said]
            for at_ns, level, text in self._fitting(texts):
                row.text(
                    at_ns / S, place + 0.22 + 0.3 * level, text,
                    family="monospace", fontsize=WORDS_SIZE, color=INK, parse_math=False,
                )  # fmt: skip
        row.set_ylim(-0.1, 2.0)
        row.set_yticks([0.35, 1.35], ["controller", "host"])
        row.tick_params(axis="y", length=0)
        row.grid(axis="x", color=PALE, linewidth=0.5)
        row.set_xlabel("seconds")

    def _shown(self, utterance: Utterance) -> str:
        return partners.codec_at(self.history.bench, utterance.controller).show(bytes(utterance.data))

    def _fitting(self, texts: Sequence[tuple[int, str]]) -> Iterator[tuple[float, int, str]]:
        """Where there is room for a text: from when on, and in which of the rows."""
        character_ns = (self.edge_ns - self.from_ns) / ROW_INCHES * 0.62 * WORDS_SIZE / 72
        free_ns: list[float] = [self.from_ns] * ROWS
        for time_ns, text in texts:
            at_ns = min(time_ns, self.edge_ns - len(text) * character_ns)
            row = next((row for row in range(ROWS) if free_ns[row] <= at_ns), None)
            if row is not None:
                free_ns[row] = at_ns + (len(text) + 1) * character_ns
                yield at_ns, row, text


def _dress(row: "Axes", label: str) -> None:
    row.set_ylabel(label, rotation=0, ha="right", va="center", labelpad=8)
    row.grid(color=PALE, linewidth=0.5)
    row.margins(y=0.12)
    row.tick_params(axis="x", labelbottom=False)
