"""`axistwin sweep`: run a scene many times with different values; measure, and test claims."""

import json
from pathlib import Path
from typing import Any

import click

from axistwin.cli.common.parameters import FILE, Number
from axistwin.cli.common.working import counting
from axistwin.core.errors import UsageError
from axistwin.sweeps import journal
from axistwin.sweeps.designs import DESIGNS
from axistwin.sweeps.summary import lines, summary
from axistwin.sweeps.sweep import Design, Sweep
from axistwin.sweeps.sweep_file import is_sweep_file, load
from axistwin.sweeps.workers import LIMIT_S

COUNT = click.IntRange(min=1)


@click.command()
@click.argument("target", metavar="SCENE.toml|SWEEP.toml|RESULT.parquet", type=FILE)
@click.option("--vary", metavar="PATH=VALUES", multiple=True,
              help="A parameter and its values, e.g. table.X.load.torque=0.05..0.4:8.")  # fmt: skip
@click.option("--measure", metavar="NAME:EXPRESSION", multiple=True,
              help="A measurement, e.g. 'end: final table.X.position'.")  # fmt: skip
@click.option("--claim", metavar="NAME:EXPRESSION", multiple=True,
              help="A claim that every run must meet, e.g. 'safe: never table.X passes 12000'.")  # fmt: skip
@click.option("--out", "-o", type=FILE, help="Results: FILE.parquet.  The same command continues an interrupted sweep.")
@click.option("--for", "seconds", type=Number(min=0, min_open=True), help="Virtual time of each run.")
@click.option("--design", type=click.Choice(list(DESIGNS)),
              help="Design that chooses the parameter values; grid if left out.")  # fmt: skip
@click.option("--runs", type=COUNT, help="Number of runs of a random design, or of random draws per grid point.")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of random values and of a search; 0 if left out.")
@click.option("--search", type=COUNT, metavar="N", help="Search in N runs for the run that fails the claims most.")
@click.option("--program", type=FILE, help="A program or conversation that is part of every run.")
@click.option("--host", metavar="MODULE:FUNCTION", help="A Python host, called with the bench of each run.")
@click.option("--workers", type=click.IntRange(min=0),
              help="Number of processes; 0: run in this process; default: one for each core.")  # fmt: skip
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="Run on the Dask cluster of this scheduler.")
@click.option("--limit", type=Number(min=0, min_open=True), default=LIMIT_S, show_default=True,
              help="Longest real time of a run, in seconds.")  # fmt: skip
@click.option("--summary", "as_text", is_flag=True, help="Print a summary of the results.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
def sweep(target: Path, out: Path | None, as_text: bool, as_json: bool, **options: Any) -> int:
    """Run a scene many times with different parameter values; write one row per run to a Parquet file.

    PATH is controller.axis.option, controller.option, controller.program.NAME (the number first assigned to NAME),
    controller.NAME (a variable or gain at power-up), fault.NAME.parameter, script.N.at, wire.N.delay_ms or seed.
    VALUES: a..b (whole numbers: each), a..b:n, a..b:n:log, [a, b, c], normal(m, s), uniform(a, b),
    triangular(a, c, b).  A run ends after --for, or when no event is due, after 3,600 s at most.

    A sweep file has the same options as keys; `axistwin check` checks the file.  Runs that fail a claim are kept as
    scenes beside the results, up to 20.  docs/sweeps.md lists all sentences.

    Exit code 0: all claims hold.  1: a claim or a run fails.  2: wrong usage.  130: interrupted.

    \b
    Examples:
      axistwin sweep scene.toml --vary table.X.load.torque=0.05..0.4:8 \\
          --measure 'lost: final table.X.lost' --out torque.parquet --summary
      axistwin sweep scene.toml --vary seed=0..99 --claim 'safe: never table.X passes 12000' --out seeds.parquet
      axistwin sweep scene.toml --vary 'knife.KP=normal(80, 8)' --runs 200 --for 5 \\
          --measure 'error: max |knife.shaft.following_error|' --out gains.parquet
      axistwin sweep scene.toml --vary script.0.at=0.1..5.0 --search 500 --claim 'safe: …' --out worst.parquet
      axistwin sweep scene.toml --vary table.X.load.torque=0.1..0.5 --vary wire.0.delay_ms=1..50 --runs 64 \\
          --design saltelli --measure 'cycle: …' --out shares.parquet --summary
      axistwin sweep study.toml --scheduler tcp://127.0.0.1:8786 --out study.parquet
      axistwin sweep study.toml --out study.parquet
      axistwin sweep study.parquet --summary
    """
    if target.suffix == ".parquet":
        return _summarise(target, as_text=not as_json, as_json=as_json)
    if out is None:
        raise UsageError("the file for the results is missing: add --out, e.g. --out results.parquet")
    made, design, seconds = _from_file(target, options) if is_sweep_file(target) else _from_options(target, options)
    run = {"seconds": seconds, "design": design, "workers": options["workers"], "limit": options["limit"]}
    run["scheduler"] = options["scheduler"]
    try:
        with counting("runs", "0 failing") as show:
            made.run(
                out, **run, tell=lambda words: click.echo(f"axistwin: {words}", err=True),
                progress=show and (lambda done, every, failing: show(done, every, f"{failing} failing")),
            )  # fmt: skip
    except KeyboardInterrupt:
        parts = any(out.with_name(f"{out.name}.parts").glob("part-*.parquet"))
        done = journal.read(out).num_rows if parts else 0
        click.echo(f"axistwin: interrupted after {done:,} runs: the same command goes on from there", err=True)
        return 130
    return _summarise(out, as_text=as_text, as_json=as_json)


def _from_options(target: Path, options: dict[str, Any]) -> tuple[Sweep, Design, float | None]:
    made = Sweep(target, options["program"], options["host"])
    for each in options["vary"]:
        made.vary(*path_and_values("vary", each))
    for option, add in (("measure", made.measure), ("claim", made.claim)):
        for each in options[option]:
            add(*named(option, each))
    if not made.varied:
        raise UsageError("the sweep varies no value: add --vary PATH=VALUES, e.g. --vary seed=0..99")
    return (
        made,
        Design(options["design"] or "grid", options["runs"], options["seed"] or 0, options["search"]),
        options["seconds"],
    )


def path_and_values(option: str, text: str) -> tuple[str, str]:
    """Split an argument PATH=VALUES into its two parts.  Raises UsageError if PATH or the equals sign is missing."""
    path, equals, values = text.partition("=")
    if not equals or not path:
        raise UsageError(f"invalid --{option} {text!r}: expected PATH=VALUES, e.g. table.X.load.torque=0.05..0.4:8")
    return path, values


def named(option: str, text: str) -> tuple[str, str]:
    """Split `end: final table.X.position` into name and expression.  Raises UsageError if it has no valid name."""
    name, colon, sentence = text.partition(":")
    if not colon or " " in name.strip():
        raise UsageError(
            f"invalid --{option} {text!r}: expected a name and an expression, e.g. 'end: final table.X.position'"
        )
    return name.strip(), sentence.strip()


def _from_file(target: Path, options: dict[str, Any]) -> tuple[Sweep, Design, float | None]:
    given = ("vary", "measure", "claim", "seconds", "design", "runs", "seed", "search", "program", "host")
    options_in_use = [f"--{'for' if name == 'seconds' else name}" for name in given if options[name] not in (None, ())]
    if options_in_use:
        raise UsageError(
            f"{', '.join(options_in_use)} cannot be combined with a sweep file: set these values in {target}"
        )
    contents = load(target)
    return contents.sweep(target), contents.chosen(), contents.seconds


def _summarise(out: Path, *, as_text: bool, as_json: bool) -> int:
    table = journal.read(out)
    found = summary(table, journal.plan_of(table))
    if as_json:
        click.echo(json.dumps(found, ensure_ascii=False))
    elif as_text:
        for line in lines(found):
            click.echo(line)
    for path in found["without_effect"]:
        click.echo(f"axistwin: {path} changed no measure and no claim in any run", err=True)
    failing = {name: one["fails"] for name, one in found["claims"].items() if one["fails"]}
    for name, count in failing.items():
        worst = found["claims"][name]["worst"][0]["run"]
        click.echo(f"axistwin: {name} fails in {count} of {found['runs']} runs; the worst is run {worst}", err=True)
    bad = {name: count for name, count in found["ended"].items() if name in ("error", "limit", "killed")}
    for name, count in bad.items():
        row = next(row for row in table.to_pylist() if row["ended"] == name)
        click.echo(f"axistwin: {count} runs ended by {name}, such as run {row['run']}: {row['notes']}", err=True)
    return 1 if failing or bad else 0
