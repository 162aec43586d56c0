"""`axistwin run`: a program or a conversation at full speed; what was said and what moved."""

import json
import logging
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, replace
from pathlib import Path

import click

from axistwin.cli.seconds import Number
from axistwin.cli.target import bench_for
from axistwin.diagnostics.checking import errors_in
from axistwin.errors import UsageError
from axistwin.plots.history import History, watching
from axistwin.programs import running
from axistwin.programs.running import Outcome
from axistwin.programs.stored_programs import only_motor
from axistwin.reports import transcript
from axistwin.units import to_ns

FILE = click.Path(dir_okay=False, path_type=Path)


SECONDS = Number(min=0)


@click.command(short_help="Run a program or a conversation at full speed.")
@click.argument("target", metavar="MODEL|SCENE.toml")
@click.argument("program", type=FILE, required=False)
@click.option("--for", "seconds", type=SECONDS, help="Virtual time in all, from switching on.")
@click.option(
    "--trace", "traces", type=FILE, multiple=True, help="Write a trace: FILE.csv, .vcd (GTKWave) or .parquet."
)
@click.option(
    "--signals", metavar="NAME,…", help="What to trace: 'default,motor.RPE', 'if1.X.*', '*'.  See docs/traces.md."
)
@click.option("--plot", type=FILE, help="Draw velocities, positions and levels: FILE.svg or FILE.png.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of text; times in nanoseconds.")
@click.option("--option", "options", metavar="NAME=VALUE", multiple=True, help="An option of the model or an axis.")
@click.option("--state", type=click.Path(file_okay=False, path_type=Path), help="Keeps what is kept without power.")
def run(
    target: str,
    program: Path | None,
    seconds: float | None,
    traces: tuple[Path, ...],
    signals: str | None,
    plot: Path | None,
    as_json: bool,
    options: tuple[str, ...],
    state: Path | None,
) -> int:
    """Run PROGRAM on a MODEL, or on the controllers of a scene, in virtual time at full speed.

    A scene runs by itself, too: its hosts, stored programs and script.  Without --for it is over when nothing more
    happens, or after 60 s.

    PROGRAM is a conversation (.talk), or IF1/IF2 command lines as typed at a terminal (.if1), or commands for an 1810
    or 1811 in hex or by name (.181x), or a SmartMotor's source (.sms), which is stored in the motor before it is
    switched on.  Of command lines the initialisation is done first, a line is sent when the one before is done, `;`
    starts a comment, `+2.5` waits, `! input1 high` drives a pin.  Exit code 1: the controller did not say or do what
    the conversation has.

    \b
    Examples:
      axistwin run if1 moves.if1
      axistwin run if1 moves.if1 --plot moves.png --trace moves.vcd
      axistwin run smartmotor home.sms --trace home.parquet --signals 'default,smartmotor.RPE,smartmotor.a'
      axistwin run 1811 moves.181x --plot moves.svg
      axistwin run smartmotor home.sms --for 10 --option shaft.motor=frame23
      axistwin run if1 forever.if1 --for 3600 --json
      axistwin run if2 locked.talk --state ./battery --option wiring=3-wire
      axistwin run examples/winder/scene.toml --plot winder.svg
      axistwin run if1 limits.if1 --option X.limits=[-100,2000]
    """
    if program is None and not target.endswith(".toml"):
        raise UsageError(f"name a PROGRAM for the {target}: only a scene does something by itself")
    loaded = running.scene_program() if program is None else running.load(program, target)
    what = target if program is None else program.name
    if plot is not None:
        from axistwin.plots.picture import check_suffix

        check_suffix(plot)
    logging.basicConfig(format="axistwin: %(message)s")
    bench = bench_for(target, (*loaded.options, *options), state)
    loaded.prepare(bench)
    with ExitStack() as stack:
        history = stack.enter_context(watching(bench))
        for path in traces:
            from axistwin.traces.signals import split
            from axistwin.traces.trace import tracing

            stack.enter_context(
                tracing(bench, path, split(signals), lambda words: click.echo(f"axistwin: {words}", err=True))
            )
        with _progress(f"running {what}"):
            outcome = loaded.perform(bench, None if seconds is None else to_ns(seconds))
            if program is not None and running.is_stored(program):
                notes = (outcome.note, errors_in(program, only_motor(bench, str(program)).product))
                outcome = replace(outcome, note="; ".join(note for note in notes if note))
    for controller in bench.controllers.values():
        controller.store.end()
    if plot is not None:
        from axistwin.cli.plot import draw

        draw(history, plot, target if program is None else f"{target}  {program.name}")
    _report(history, outcome, as_json)
    return 1 if outcome.difference else 0


def _report(history: History, outcome: Outcome, as_json: bool) -> None:
    if as_json:
        difference = asdict(outcome.difference) if outcome.difference else None
        click.echo(json.dumps({**transcript.as_dict(history), "difference": difference, "note": outcome.note}))
        return
    for line in transcript.text(history):
        click.echo(line)
    click.echo()
    for line in transcript.summary(history):
        click.echo(line)
    if not history.complete:
        click.echo("axistwin: too much happened to keep it all: this is the latest of it", err=True)
    there = history.bench.controllers.values()
    troubles = (f"{controller.name}: {controller.trouble}" for controller in there if controller.trouble)
    for note in (outcome.note, *troubles, *sorted({controller.product.note() for controller in there})):
        if note:
            click.echo(f"axistwin: {note}", err=True)
    if outcome.difference:
        click.echo(f"axistwin: {outcome.difference}", err=True)


@contextmanager
def _progress(words: str) -> Iterator[None]:
    """Something that turns, if somebody is looking."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(words):
        yield
