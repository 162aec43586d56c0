"""Plot a study of `axistwin tune`: the scores of the trials, and the best trial compared with the delivered values."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from axistwin.records.plots.picture import ALARM, COLOURS, GREY, INK, check_suffix, write_figure
from axistwin.sweeps.study import Trial, best

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE = 9.0, 3.4  # Width and height of the whole picture in inches.


def save(plan: Mapping[str, Any], delivered: Trial, trials: Sequence[Trial], path: Path, title: str = "") -> None:
    """Plot a study to a PNG or SVG file.  Raises UsageError."""
    check_suffix(path)

    def draw(figure: "Figure") -> None:
        figure.set_size_inches(_SIZE)
        figure.set_layout_engine("constrained")
        left, right = figure.subplots(1, 2)
        _scores(left, plan, delivered, trials)
        _results(right, plan, delivered, best(trials, plan["goal"]))
        if title:
            figure.suptitle(title, x=0.012, ha="left", fontsize=11, color=INK)

    write_figure(draw, path)


def _scores(axes: "Axes", plan: Mapping[str, Any], delivered: Trial, trials: Sequence[Trial]) -> None:
    for feasible, colour, marker, label in ((True, COLOURS[0], "o", "trial"), (False, ALARM, "x", "a claim fails")):
        shown = [(n, trial.score) for n, trial in enumerate(trials) if trial.feasible is feasible and _drawable(trial)]
        if shown:
            numbers, scores = zip(*shown, strict=True)
            axes.scatter(numbers, scores, s=10, color=colour, marker=marker, linewidths=0.8, label=label)
    steps = [best(trials[: n + 1], plan["goal"]) for n in range(len(trials))]
    so_far = [(n, found.score) for n, found in enumerate(steps) if found is not None]
    if so_far:
        axes.step(*zip(*so_far, strict=True), where="post", color=INK, linewidth=1, label="best so far")
    axes.axhline(delivered.score, color=GREY, linestyle="--", linewidth=1, label="delivered")
    axes.set(xlabel="trial", ylabel=f"worst case: {plan['goal'].partition(' ')[2]}")
    axes.legend(fontsize=7, frameon=False)


def _results(axes: "Axes", plan: Mapping[str, Any], delivered: Trial, found: Trial | None) -> None:
    from matplotlib.ticker import MaxNLocator

    worst_first = not plan["goal"].startswith("maximise")
    for trial, colour, label in ((delivered, GREY, "delivered"), (found, COLOURS[0], "best")):
        if trial is not None and _drawable(trial):
            values = sorted(trial.results, reverse=worst_first)
            axes.plot(range(1, len(values) + 1), values, "o-", color=colour, markersize=4, linewidth=1, label=label)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="runs of a trial, worst first", ylim=(0, None) if worst_first and delivered.score > 0 else None)
    axes.legend(fontsize=7, frameon=False)


def _drawable(trial: Trial) -> bool:
    return "result" not in trial.violations
