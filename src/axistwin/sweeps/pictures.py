"""Plot the results of a sweep: one row of plots for each measure and for each claim's robustness.

A row has a histogram and a scatter plot over each path.  If exactly two numeric paths vary, the row also has a heat
map; for the design `saltelli`, it has the Sobol indices as bars instead.  Runs that fail a claim are red; the worst
runs of a claim are labelled with their run numbers.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from axistwin.core.errors import TraceError
from axistwin.core.lazy import pa
from axistwin.records.plots.picture import ALARM, COLOURS, GREY, INK, check_suffix, write_figure
from axistwin.sweeps import sensitivity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_PATHS = 4  # Largest number of scatter plots in a row; no plots are drawn for further paths.
WORST = 3  # Number of worst runs of each claim that are labelled.
_SIZE = 2.6, 2.2  # Width and height of one plot in inches.


def save(table: "pa.Table", plan: Mapping[str, Any], path: Path, title: str = "") -> None:
    """Plot a sweep to a PNG or SVG file.  Raises TraceError without any measure or claim."""
    check_suffix(path)
    names = [*plan["measures"], *(f"{name}.robustness" for name in plan["claims"])]
    if not names:
        raise TraceError(
            f"{title or path} has no results to plot: expected a sweep that measures or checks a signal, "
            "e.g. --measure 'end: final table.X.position'"
        )
    write_figure(lambda figure: _draw(figure, table, plan, names, title), path)


def _draw(figure: "Figure", table: "pa.Table", plan: Mapping[str, Any], names: Sequence[str], title: str) -> None:
    numeric = [path for path in plan["varied"] if str(table.schema.field(path).type) in ("double", "int64")]
    paths = numeric[:MOST_PATHS]
    shares = sensitivity.indices(table, plan)
    maps = len(paths) == 2 or bool(shares)
    columns = 1 + len(paths) + maps
    figure.set_size_inches(_SIZE[0] * columns, _SIZE[1] * len(names) + 0.4)
    figure.set_layout_engine("constrained")
    grid = figure.subplots(len(names), columns, squeeze=False)
    failing = np.zeros(table.num_rows, bool)
    for name in plan["claims"]:
        failing |= np.array([holds is False for holds in table[name].to_pylist()], bool)
    runs = np.array(table["run"].to_pylist())
    for row, name in zip(grid, names, strict=True):
        values = _numbers(table[name].to_pylist())
        _histogram(row[0], name, values)
        marked = np.argsort(values)[:WORST] if name.endswith(".robustness") else np.empty(0, int)
        for axes, path in zip(row[1:], paths, strict=False):
            _scatter(axes, path, _numbers(table[path].to_pylist()), values, failing)
            for n in marked[np.isfinite(values[marked])]:
                at = float(table[path][int(n)].as_py()), float(values[n])
                axes.annotate(str(runs[n]), at, fontsize=7, color=INK, xytext=(3, 3), textcoords="offset points")
        if shares:
            _bars(row[-1], shares.get(name))
        elif maps:
            _heat_map(figure, row[-1], paths, [_numbers(table[path].to_pylist()) for path in paths], values)
    if title:
        figure.suptitle(title, x=0.012, ha="left", fontsize=11, color=INK)


def _numbers(values: Sequence[Any]) -> "np.ndarray[Any, np.dtype[np.float64]]":
    flat = [np.mean(value) if isinstance(value, list) else np.nan if value is None else value for value in values]
    found = np.array(flat, float)
    found[~np.isfinite(found)] = np.nan
    return found


def _histogram(axes: "Axes", name: str, values: Any) -> None:
    axes.hist(values[np.isfinite(values)], bins=30, color=COLOURS[0])
    axes.set_xlabel(name)
    axes.set_ylabel("runs")


def _scatter(axes: "Axes", path: str, at: Any, values: Any, failing: Any) -> None:
    axes.scatter(at[~failing], values[~failing], s=8, color=COLOURS[0], linewidths=0)
    axes.scatter(at[failing], values[failing], s=8, color=ALARM, linewidths=0)
    axes.set_xlabel(path)


def _bars(axes: "Axes", shares: Mapping[str, Mapping[str, float]] | None) -> None:
    """Draw first-order and total Sobol index of each setting, with 95 % confidence intervals."""
    if shares is None:
        axes.set_axis_off()
        return
    for shift, kind, label, colour in ((-0.2, "first", "alone", COLOURS[0]), (0.2, "total", "total", GREY)):
        values, errors = ([one[key] for one in shares.values()] for key in (kind, f"{kind}_95"))
        places = [n + shift for n in range(len(shares))]
        axes.barh(places, values, 0.38, xerr=errors, color=colour, label=label, error_kw={"linewidth": 0.8})
    axes.set_yticks(range(len(shares)), [*shares], fontsize=6)
    axes.invert_yaxis()
    axes.set_xlabel("share of the variance")
    axes.legend(fontsize=7, frameon=False)


def _heat_map(figure: "Figure", axes: "Axes", paths: Sequence[str], at: Sequence[Any], values: Any) -> None:
    drawn = axes.scatter(at[0], at[1], c=values, s=14, marker="s", cmap="viridis", linewidths=0)
    axes.set_xlabel(paths[0])
    axes.set_ylabel(paths[1])
    if np.isfinite(values).any():
        figure.colorbar(drawn, ax=axes)
