"""`axistwin plot`: draw a trace or a run."""

from collections.abc import Callable
from pathlib import Path

import click

from axistwin.cli.common.completing import complete_trace
from axistwin.cli.common.parameters import FILE, Number
from axistwin.cli.common.working import working
from axistwin.core.errors import UsageError
from axistwin.core.units import to_ns, to_seconds
from axistwin.records.plots.picture import check_suffix, save, show
from axistwin.records.traces.signals import EVERYTHING


@click.command()
@click.argument("trace", type=FILE, shell_complete=complete_trace)
@click.option("--out", "-o", type=FILE, help="FILE.svg or FILE.png; TRACE.png if left out.")
@click.option("--show", "on_screen", is_flag=True, help="Show the picture in a window.")
@click.option("--signals", metavar="NAME,…",
              help="Signals to draw, * for any text: 'if1.X.*,if1.output?'; default: all.")  # fmt: skip
@click.option("--from", "since", type=Number(min=0), metavar="SECONDS", help="Begin of the drawn time.")
@click.option("--to", "until", type=Number(min=0), metavar="SECONDS",
              help="End of the drawn time; default: all motion and level changes.")  # fmt: skip
@click.option("--title", default=None, help="Title of the picture; the scene's title or the trace's name if left out.")
def plot(
    trace: Path, out: Path | None, on_screen: bool, signals: str | None, since: float | None, until: float | None,
    title: str | None,
) -> int:  # fmt: skip
    """Draw a trace: positions, velocities, pins, registers and messages on one time axis.

    TRACE is a file written by `--trace`: .csv, .vcd or .parquet.  Results of `axistwin sweep` are drawn as histograms,
    scatter plots and heat maps; a study of `axistwin tune` (.db) as its trials and its best values; a log of
    `axistwin shadow` (.jsonl) as durations and drift.

    \b
    Examples:
      axistwin plot moves.vcd                                  writes moves.png
      axistwin plot moves.csv -o moves.svg --from 2 --to 3.5
      axistwin plot torque.parquet -o torque.svg               results of a sweep
      axistwin plot night.parquet --show --signals 'motor.shaft.*,motor.RPE,motor.G'
    """
    from axistwin.records.plots.trace_chart import of_trace
    from axistwin.records.traces.reading import read
    from axistwin.records.traces.signals import split

    from_ns, until_ns = (None if seconds is None else to_ns(seconds) for seconds in (since, until))
    if from_ns is not None and until_ns is not None and until_ns <= from_ns:
        raise UsageError(f"invalid time range --from {since:g} --to {until:g}: expected --to after --from")
    path = out if out is not None or on_screen else trace.with_suffix(".png")
    if path is not None:
        check_suffix(path)
    given = {"--show": on_screen, "--signals": signals, "--from": since is not None, "--to": until is not None}
    option = next((name for name, is_given in given.items() if is_given), None)
    if results := _results(trace):
        if option:
            expected = f"expected only --out or --title for results of '{results[0]}'"
            raise UsageError(f"cannot use the option {option} for {trace}: {expected}")
        assert path is not None, "nothing is shown on the screen"
        results[1](trace, path, trace.name if title is None else title)
        click.echo(f"axistwin: {path}", err=True)
        return 0
    with working(f"reading {trace.name}"):
        found = read(trace)
    if from_ns is not None and from_ns >= found.end_ns:
        end_s = to_seconds(found.end_ns)
        raise UsageError(f"invalid --from {since:g}: expected a time before the end of the trace at {end_s:g} s")
    chart = of_trace(
        found, split(signals or EVERYTHING), from_ns, until_ns,
        found.about.get("title", trace.name) if title is None else title,
    )  # fmt: skip
    if path is not None:
        with working(f"drawing {path.name}"):
            save(chart, path)
        click.echo(f"axistwin: {path}", err=True)
    if on_screen:
        show(chart)
    return 0


def _results(trace: Path) -> tuple[str, Callable[[Path, Path, str], None]] | None:
    """Return the command that has written other results than a trace, and the function that draws them."""
    if trace.suffix == ".jsonl":
        return "axistwin shadow", _plot_shadow
    if trace.suffix == ".db":
        return "axistwin tune", _plot_study
    is_sweep = trace.suffix == ".parquet" and trace.is_file() and _is_sweep(trace)
    return ("axistwin sweep", _plot_sweep) if is_sweep else None


def _is_sweep(trace: Path) -> bool:
    from axistwin.records.traces.parquet import require_pyarrow
    from axistwin.sweeps import is_sweep

    require_pyarrow()
    return is_sweep(trace)


def _plot_sweep(results: Path, path: Path, title: str) -> None:
    from axistwin.sweeps import journal, pictures

    table = journal.read(results)
    pictures.save(table, journal.plan_of(table), path, title)


def _plot_shadow(log: Path, path: Path, title: str) -> None:
    from axistwin.real.shadow import picture

    picture.save(log, path, title)


def _plot_study(study: Path, path: Path, title: str) -> None:
    from axistwin.sweeps import study_picture
    from axistwin.sweeps.study import load

    study_picture.save(*load(study), path, title)
