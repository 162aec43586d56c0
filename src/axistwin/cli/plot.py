"""`axistwin plot`: draw a trace; and pictures of what has happened on a bench."""

from pathlib import Path

import click

from axistwin.cli.seconds import Number
from axistwin.errors import UsageError
from axistwin.plots.history import History
from axistwin.plots.picture import check_suffix, save, show
from axistwin.traces.signals import EVERYTHING
from axistwin.units import to_ns, to_seconds

FILE = click.Path(dir_okay=False, path_type=Path)


def draw(history: History, path: Path, title: str = "") -> None:
    """Draw what has happened on a bench into an SVG or PNG file."""
    check_suffix(path)
    from axistwin.plots.history_chart import of_history

    save(of_history(history, title), path)


@click.command(short_help="Draw a trace.")
@click.argument("trace", type=FILE)
@click.option("--out", "-o", type=FILE, help="FILE.svg or FILE.png; without it TRACE.png.")
@click.option("--show", "on_screen", is_flag=True, help="In a window on the screen.")
@click.option("--signals", metavar="NAME,…", help="Which signals, * for anything: 'if1.X.*,if1.output?'.  All of them.")
@click.option("--from", "since", type=Number(), metavar="SECONDS", help="Begin of the time to be drawn.")
@click.option(
    "--to", "until", type=Number(), metavar="SECONDS", help="Its end.  Without them: where something happens."
)
@click.option("--title", default=None, help="What stands above the picture; the trace's name if left out.")
def plot(
    trace: Path,
    out: Path | None,
    on_screen: bool,
    signals: str | None,
    since: float | None,
    until: float | None,
    title: str | None,
) -> int:
    """Draw position, velocity, following error, pins, registers and what was said, all on one time axis.

    TRACE is a file that `--trace` has written: .csv, .vcd or .parquet.

    \b
    Examples:
      axistwin plot moves.vcd                                  writes moves.png
      axistwin plot moves.csv -o moves.svg --from 2 --to 3.5
      axistwin plot night.parquet --show --signals 'motor.shaft.*,motor.RPE,motor.G'
    """
    from axistwin.plots.trace_chart import of_trace
    from axistwin.traces.reading import read
    from axistwin.traces.signals import split

    from_ns, until_ns = _time(since), _time(until)
    if from_ns is not None and until_ns is not None and until_ns <= from_ns:
        raise UsageError(f"--from {since:g} --to {until:g}: give a time that ends after it begins")
    path = out if out is not None or on_screen else trace.with_suffix(".png")
    if path is not None:
        check_suffix(path)
    found = read(trace)
    if from_ns is not None and from_ns >= found.end_ns:
        raise UsageError(f"--from {since:g}: the trace ends at {to_seconds(found.end_ns):g} s, give a time before that")
    chart = of_trace(found, split(signals or EVERYTHING), from_ns, until_ns, trace.name if title is None else title)
    if path is not None:
        save(chart, path)
        click.echo(f"axistwin: {path}", err=True)
    if on_screen:
        show(chart)
    return 0


def _time(seconds: float | None) -> int | None:
    return None if seconds is None else to_ns(seconds)
