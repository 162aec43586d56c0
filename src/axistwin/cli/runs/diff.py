"""`axistwin diff`: the first difference between two traces, or the motion of two machines side by side."""

import json
from dataclasses import asdict
from pathlib import Path

import click

from axistwin.cli.common.parameters import FILE, Number
from axistwin.cli.common.working import working
from axistwin.core.errors import UsageError
from axistwin.core.units import S, to_ns
from axistwin.records.traces.differences import Comparison, Difference, Tolerance, compare
from axistwin.scenes.reports.columns import columns

MOST = 20  # Largest number of differing signals that are printed.


@click.command()
@click.argument("first", type=FILE)
@click.argument("second", type=FILE)
@click.option("--signals", metavar="NAME,…",
              help="Signals to compare, * for any text: 'if1.X.*,if1.output?'; default: all.")  # fmt: skip
@click.option("--tolerance", "--within", type=Number(min=0), default=0.0, help="Accepted difference of numbers.")
@click.option("--time-tolerance", "--time", type=Number(min=0), default=0.0, metavar="SECONDS",
              help="Accepted difference of times.")  # fmt: skip
@click.option("--positions", is_flag=True, help="Compare the motion only, of machines with any controllers and hosts.")
@click.option("--align", type=click.Choice(["time", "move"]),
              help="Compare positions at the same times (default), or from the begin of each move on.")  # fmt: skip
@click.option("--axes", metavar="A=B,…", help="Pairs of axes for --positions; default: by name, else in their order.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of text; times in nanoseconds.")
@click.option(
    "--plot", type=FILE, help="Draw both traces around the first difference, or their motion: FILE.svg or FILE.png."
)
def diff(
    first: Path, second: Path, signals: str | None, tolerance: float, time_tolerance: float, positions: bool,
    align: str | None, axes: str | None, as_json: bool, plot: Path | None,
) -> int:  # fmt: skip
    """Compare two traces, FIRST and SECOND, signal by signal, up to the end of the shorter trace.

    The files may be of different kinds: .csv, .vcd, .parquet.  The output is the first difference in time, then the
    signals that differ, each with the time of its first difference.  With --positions, it is a table of the moves.
    Exit code 1 if there is a difference.

    \b
    Examples:
      axistwin diff yesterday.parquet today.parquet
      axistwin diff before.csv after.csv --signals 'table.*' --time-tolerance 0.001
      axistwin diff good.vcd bad.vcd --plot where.png
      axistwin diff old.csv new.csv --positions --within 2 --time 0.001 --align move
    """
    if plot is not None:
        from axistwin.records.plots.picture import check_suffix

        check_suffix(plot)
    accepted = Tolerance(tolerance, to_ns(time_tolerance))
    if not positions:
        for option, value in {"--align": align, "--axes": axes}.items():
            if value is not None:
                raise UsageError(f"{option} is for positions: add --positions, e.g. --positions {option} {value}")
        return _diff_signals(first, second, accepted, signals, as_json, plot)
    if signals is not None:
        raise UsageError("--signals does not go with --positions: choose axes, e.g. --axes X=X")
    return _diff_positions(first, second, accepted, align == "move", axes or "", as_json, plot)


def _diff_signals(
    first: Path, second: Path, accepted: Tolerance, signals: str | None, as_json: bool, plot: Path | None
) -> int:
    from axistwin.records.traces.reading import read
    from axistwin.records.traces.signals import EVERYTHING, split

    patterns = split(signals or EVERYTHING)
    with working(f"comparing {first.name} with {second.name}"):
        one, other = read(first), read(second)
        found = compare(one, other, accepted, patterns)
    if plot is not None and found.differences:
        from axistwin.records.plots.diff_chart import of_difference
        from axistwin.records.plots.picture import save

        save(of_difference(one, other, found, f"{first.name} and {second.name}"), plot)
    _report(found, as_json)
    return 1 if found.differences or found.ends[0] != found.ends[1] else 0


def _diff_positions(
    first: Path, second: Path, accepted: Tolerance, by_move: bool, axes: str, as_json: bool, plot: Path | None
) -> int:
    from axistwin.cli.runs.diff_motion import report, report_json, same
    from axistwin.records.traces.motion import compare_motion
    from axistwin.records.traces.reading import read

    with working(f"comparing {first.name} with {second.name}"):
        found = compare_motion(read(first), read(second), accepted.time_ns, by_move=by_move, names=axes)
    if plot is not None:
        from axistwin.records.plots.motion_chart import of_motion
        from axistwin.records.plots.picture import save

        names = first.name, second.name
        save(of_motion(found, found.broken(accepted), names, f"{first.name} and {second.name}"), plot)
    if as_json:
        report_json(found, accepted)
    else:
        report(found, accepted, (first.name, second.name))
    return 0 if same(found, accepted) else 1


def _report(found: Comparison, as_json: bool) -> None:
    if as_json:
        differences = [asdict(difference) for difference in found.differences]
        told = {"equal": not differences and found.ends[0] == found.ends[1], "compared": found.compared}
        click.echo(json.dumps({**told, "until_ns": found.until_ns, "ends_ns": found.ends, "differences": differences}))
        return
    for line in _lines(found):
        click.echo(line)


def _lines(found: Comparison) -> list[str]:
    lines = []
    if found.differences:
        first = found.differences[0]
        lines.append(f"first difference at {_seconds(first.time_ns)} s: {first.signal} is {_values(first, ' and ')}")
        rows = [(_seconds(d.time_ns), d.signal, _values(d, "  |  ")) for d in found.differences]
        lines += ["", *columns(rows[:MOST])]
        lines += [f"… and {len(rows) - MOST} more"] * (len(rows) > MOST)
    if found.ends[0] != found.ends[1]:
        lines.append(f"one ends at {_seconds(found.ends[0])} s, the other at {_seconds(found.ends[1])} s")
    return lines or [f"no difference in {found.compared} signals up to {_seconds(found.until_ns)} s"]


def _seconds(time_ns: int) -> str:
    return f"{time_ns // S}.{time_ns % S:09d}"


def _values(difference: Difference, between: str) -> str:
    values = (difference.first, difference.second)
    return between.join("missing" if value is None else repr(value) if value == "" else str(value) for value in values)
