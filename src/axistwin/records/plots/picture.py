"""Draw a chart on the screen, or to an SVG or PNG file."""

from collections.abc import Callable, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.core.errors import UsageError
from axistwin.core.lazy import np
from axistwin.core.storage import write_file
from axistwin.core.units import S
from axistwin.records.plots.chart import Chart, Panel, Word

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import LayoutEngine

SUFFIXES = (".svg", ".png")
# Colour-blind people can distinguish these colours of signals.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
INK, PALE, GREY, LAMP, ALARM = "#333333", "#D9D9D9", "#808080", "#F0B000", "#C00000"
STYLE: dict[Any, Any] = {  # Matplotlib's type hints reject a style of the type `dict[str, Any]`.
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": GREY,
    "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK, "svg.hashsalt": "axistwin", "svg.fonttype": "none",
    "axes.formatter.limits": (-9, 12), "axes.formatter.useoffset": False,
}  # fmt: skip
WIDTH, LANE, WORDS = 10, 0.24, 0.38
"""Width of a picture, height of a lane, and height of the messages of one sender, in inches."""
WORDS_SIZE, ROWS = 7.5, 2  # Font size of messages in points, and number of rows for the messages of one sender.
FAULT_LEVELS, FAULT_LEVEL = 4, 12
"""Largest number of simultaneous faults whose names are drawn, and height of a name in points."""
LABEL, MARGIN, COUNTS = 0.072, 0.85, 0.6
"""Widths in inches: a character of a label, the margins without labels, a scale on the right."""
FILES_ONLY = ("agg", "cairo", "pdf", "pgf", "ps", "svg", "template")  # Matplotlib backends that cannot open a window.
ALL_WORDS = 4.0  # Largest height of the messages of all senders together, in inches.


def check_suffix(path: Path) -> None:
    """Raise UsageError if the file name of a picture does not end in `.svg` or `.png`."""
    if path.suffix not in SUFFIXES:
        file_name, valid_endings = path.name, " or ".join(SUFFIXES)
        raise UsageError(f"invalid file name {file_name!r} for a picture: expected a name that ends in {valid_endings}")


def save(chart: Chart, path: Path) -> None:
    """Draw a chart to an SVG or PNG file.  Raises UsageError if the file cannot be written."""
    check_suffix(path)
    write_figure(_Picture(chart).draw, path)


def as_svg(chart: Chart) -> str:
    text = _rendered(_Picture(chart).draw, "svg").decode()
    return text[text.index("<svg") :]


def write_figure(draw: Callable[["Figure"], object], path: Path) -> None:
    """Draw a Matplotlib figure to an SVG or PNG file.  Raises AxistwinError if the file cannot be written."""
    write_file(path, _rendered(draw, path.suffix.lstrip(".")), f"cannot write the picture to {path}")


def _rendered(draw: Callable[["Figure"], object], form: str) -> bytes:
    import matplotlib as mpl

    picture = BytesIO()
    with mpl.rc_context(STYLE):
        from matplotlib.figure import Figure

        figure = Figure()
        draw(figure)
        figure.savefig(picture, format=form, dpi=150, metadata={"Date": None} if form == "svg" else {})
    return picture.getvalue()


def show(chart: Chart) -> None:
    """Show a chart in a window until the user closes the window.  Raises UsageError if there is no screen."""
    import matplotlib as mpl
    from matplotlib import pyplot as plt

    with mpl.rc_context(STYLE):
        if mpl.get_backend().lower() in FILES_ONLY:
            raise UsageError("no screen is available: write the picture to a file, e.g. --out chart.svg")
        _Picture(chart).draw(plt.figure())
        plt.show()


def _layout_engine() -> "LayoutEngine":
    """Return a layout engine that rounds the positions of diagrams to 6 decimals.

    The positions can differ by 1e-16 between two runs, and rounding makes the SVG files of two runs equal.
    """
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.transforms import Bbox

    class Rounded(ConstrainedLayoutEngine):
        def execute(self, fig: "Figure") -> None:
            super().execute(fig)
            for axes in fig.axes:
                axes.set_position(Bbox(axes.get_position(original=True).get_points().round(6)), which="original")
                # Matplotlib's `set_position` switches a diagram's automatic layout off; switch the layout on again.
                axes.set_in_layout(True)

    return Rounded(hspace=0.02, h_pad=0.05, w_pad=0.12)


class _Picture:
    def __init__(self, chart: Chart) -> None:
        self.chart = chart
        self.edges = chart.from_ns / S, chart.edge_ns / S

    def draw(self, figure: "Figure") -> "Figure":
        chart = self.chart
        lanes = len(chart.lanes) + len(chart.states)
        heights = [panel.height for panel in chart.panels] + [0.2 + LANE * lanes] * bool(lanes)
        if chart.words or not heights:
            heights.append(max(min(WORDS * len(chart.words), ALL_WORDS), WORDS))
        levels = len({level for *_, level, _ in self._packed()})
        figure.set_size_inches(WIDTH, sum(heights) + 0.16 * len(heights) + 0.9 + levels * FAULT_LEVEL / 72)
        figure.set_layout_engine(_layout_engine())
        rows = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0])
        rows[0].set_xlim(*self.edges)
        rows[-1].set_xlabel("seconds")
        self._draw_marks(rows)
        self._draw_faults(rows)
        for panel in chart.panels:
            self._draw_panel(rows.pop(0), panel)
        if lanes:
            self._draw_lanes(rows.pop(0))
        if rows:
            self._draw_words(rows.pop(0))
        figure.align_ylabels()
        if chart.title:
            figure.suptitle(chart.title, x=0.012, ha="left", fontsize=11, color=INK, parse_math=False)
        return figure

    def _draw_marks(self, rows: Sequence["Axes"]) -> None:
        for mark in self.chart.marks:
            for row in rows:
                row.axvline(mark.time_ns / S, color=ALARM, linewidth=1.0, linestyle=(0, (4, 2)), zorder=5)
            rows[0].annotate(
                mark.text, (mark.time_ns / S, 1), xytext=(3, 2), xycoords=("data", "axes fraction"),
                textcoords="offset points", color=ALARM, fontsize=8, annotation_clip=False, parse_math=False,
            )  # fmt: skip

    def _draw_faults(self, rows: Sequence["Axes"]) -> None:
        for begin_ns, end_ns, level, name in self._packed():
            for row in rows:
                for at_ns, style in {end_ns: ":", begin_ns: "-"}.items():
                    if self.chart.from_ns < at_ns < self.chart.edge_ns:
                        row.axvline(at_ns / S, color=ALARM, linewidth=0.7, alpha=0.55, linestyle=style, zorder=1.9)
            if level is not None:
                self._draw_bar(rows[0], begin_ns, end_ns, level, name)

    def _draw_bar(self, row: "Axes", begin_ns: float, end_ns: float, level: int, name: str) -> None:
        from matplotlib.transforms import ScaledTranslation

        up = 3 + FAULT_LEVEL * level
        place = row.get_xaxis_transform() + ScaledTranslation(0, up / 72, row.figure.dpi_scale_trans)
        bar: dict[str, Any] = {"transform": place, "clip_on": False, "solid_capstyle": "butt", "linewidth": 2}
        row.plot([begin_ns / S, end_ns / S], [1, 1], color=ALARM, alpha=0.35, scalex=False, scaley=False, **bar)
        row.annotate(
            name, (begin_ns / S, 1), xytext=(1, up + 2), xycoords=("data", "axes fraction"),
            textcoords="offset points", color=ALARM, fontsize=WORDS_SIZE, annotation_clip=False, parse_math=False,
        )  # fmt: skip

    def _packed(self) -> Iterator[tuple[float, float, int | None, str]]:
        chart, free_ns = self.chart, [float(self.chart.from_ns)] * FAULT_LEVELS
        for fault in chart.faults:
            begin_ns = max(fault.begin_ns, chart.from_ns)
            end_ns = chart.edge_ns if fault.end_ns is None else min(fault.end_ns, chart.edge_ns)
            level = next((n for n in range(FAULT_LEVELS) if free_ns[n] <= begin_ns), None)
            if level is not None:
                free_ns[level] = max(end_ns, begin_ns + (len(fault.name) + 1) * self._character_ns)
            yield begin_ns, end_ns, level, fault.name

    def _draw_panel(self, row: "Axes", panel: Panel) -> None:
        colour = COLOURS[panel.colour % len(COLOURS)]
        for line in panel.lines:
            curve = line.curve.thinned()
            style: dict[str, Any] = {"color": colour, "linewidth": 1.2}
            if line.faint:
                style = {"color": INK, "linewidth": 0.8, "linestyle": "--"}
            if panel.filled and not line.faint:
                row.fill_between(curve.times, curve.values, color=colour, alpha=0.22, linewidth=0, step="post")
            row.plot(curve.times, curve.values, label=line.legend, drawstyle="steps-post", **style)
        if panel.filled:
            row.axhline(0, color=GREY, linewidth=0.6)
        if any(line.legend for line in panel.lines):
            row.legend(
                loc="lower right", bbox_to_anchor=(1, 1), ncols=len(panel.lines), frameon=False, fontsize=7.5,
                borderaxespad=0, borderpad=0.1,
            )  # fmt: skip
        _dress(row, panel.label)
        if panel.per is not None:
            self._add_counts(row, panel.per, panel.counts)
        values = {value for line in panel.lines for value in line.curve.values}
        if len(values) == 1:
            # For a constant signal, the y axis of the plot extends one count above and below the signal's value.
            value, count = values.pop(), 1 / (panel.per or 1)
            row.set_ylim(value - count, value + count)

    def _add_counts(self, row: "Axes", per: float, counts: str) -> None:
        scales = (lambda values: np.asarray(values) * per, lambda numbers: np.asarray(numbers) / per)
        right = row.secondary_yaxis("right", functions=scales)
        right.set_ylabel(counts, fontsize=7.5, color=GREY)
        right.tick_params(labelsize=7.5, colors=GREY)
        right.spines["right"].set_visible(True)

    def _draw_lanes(self, row: "Axes") -> None:
        names = [*self.chart.lanes, *self.chart.states]
        places = {name: len(names) - 1 - n for n, name in enumerate(names)}
        for name, full in self.chart.lanes.items():
            lane, place = full.thinned(), places[name]
            levels = [place + 0.66 * level for level in lane.values]
            row.fill_between(lane.times, levels, place, step="post", color=LAMP, alpha=0.55, linewidth=0)
            row.step(lane.times, levels, where="post", color=INK, linewidth=0.9)
        for name, states in self.chart.states.items():
            self._draw_states(row, places[name], states)
        row.set_ylim(-0.25, len(names))
        row.set_yticks([place + 0.33 for place in places.values()], names)
        row.tick_params(axis="y", length=0)
        row.grid(axis="x", color=PALE, linewidth=0.5)

    def _draw_states(self, row: "Axes", place: int, states: Sequence[Word]) -> None:
        begins = [max(state.time_ns, self.chart.from_ns) for state in states]
        for state, begin_ns, end_ns in zip(states, begins, [*begins[1:], self.chart.to_ns], strict=True):
            row.fill_between([begin_ns / S, end_ns / S], place, place + 0.66, color=PALE, alpha=0.5, linewidth=0)
            row.vlines(begin_ns / S, place, place + 0.66, color=INK, linewidth=0.9)
            if len(state.text) * self._character_ns < end_ns - begin_ns:
                row.text(
                    begin_ns / S, place + 0.33, f" {state.text}", family="monospace", fontsize=WORDS_SIZE, color=INK,
                    va="center", parse_math=False, clip_on=True,
                )  # fmt: skip

    @property
    def _character_ns(self) -> float:
        chart = self.chart
        labels = (*(line for panel in chart.panels for line in panel.label.split("\n")), *chart.lanes, *chart.words)
        right = COUNTS * any(panel.per is not None for panel in chart.panels)
        inches = WIDTH - MARGIN - right - LABEL * max(map(len, (*labels, *chart.states)), default=0)
        return (chart.edge_ns - chart.from_ns) / inches * 0.66 * WORDS_SIZE / 72

    def _draw_words(self, row: "Axes") -> None:
        speakers = list(self.chart.words)
        for n, (speaker, words) in enumerate(self.chart.words.items()):
            place = float(len(speakers) - 1 - n)
            row.vlines([word.time_ns / S for word in words], place, place + 0.2, color=INK, linewidth=0.7)
            mark = ">" if speaker.startswith("host") else "<"
            for at_ns, level, text in self._fitting([(word.time_ns, f"{mark} {word.text}") for word in words]):
                row.text(
                    at_ns / S, place + 0.22 + 0.3 * level, text,
                    family="monospace", fontsize=WORDS_SIZE, color=INK, parse_math=False,
                )  # fmt: skip
        if not speakers:
            row.text(
                0.5, 0.5, "no signal changes in this time", transform=row.transAxes, ha="center", va="center",
                color=GREY, fontsize=WORDS_SIZE + 1,
            )  # fmt: skip
        row.set_ylim(-0.1, max(len(speakers), 1))
        row.set_yticks([len(speakers) - 1 - n + 0.35 for n in range(len(speakers))], speakers)
        row.tick_params(axis="y", length=0)
        row.grid(axis="x", color=PALE, linewidth=0.5)

    def _fitting(self, texts: Sequence[tuple[int, str]]) -> Iterator[tuple[float, int, str]]:
        character_ns = self._character_ns
        free_ns: list[float] = [self.chart.from_ns] * ROWS
        for time_ns, text in texts:
            at_ns = min(time_ns, self.chart.edge_ns - len(text) * character_ns)
            row = next((row for row in range(ROWS) if free_ns[row] <= at_ns), None)
            if row is not None:
                free_ns[row] = at_ns + (len(text) + 1) * character_ns
                yield at_ns, row, text


def _dress(row: "Axes", label: str) -> None:
    row.set_ylabel(label, rotation=0, ha="right", va="center", labelpad=8)
    row.grid(color=PALE, linewidth=0.5)
    row.margins(y=0.12)
