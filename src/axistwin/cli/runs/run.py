"""`axistwin run`: run a program or a conversation at full speed; print messages and moves."""

import json
import logging
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import asdict, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

import click

from axistwin.bench import Bench, product
from axistwin.bench.programs import running
from axistwin.bench.programs.running import Outcome, Program
from axistwin.bench.talk.conversation import MOST_MIB
from axistwin.cli.common.completing import complete_program, complete_target
from axistwin.cli.common.parameters import FILE, PROGRAM, TRACE_LIMIT, Number, Size
from axistwin.cli.common.repeating import program as repeated
from axistwin.cli.common.target import bench_for
from axistwin.cli.common.working import RunProgress, working
from axistwin.controllers.product import Product
from axistwin.core.errors import UsageError
from axistwin.core.storage import contents
from axistwin.core.units import to_ns
from axistwin.records.traces.provenance import provenance
from axistwin.scenes.diagnostics.checking import HostProgram, host_programs, kind_of, load
from axistwin.scenes.reports import transcript
from axistwin.scenes.reports.page import Page, check_path, write_page
from axistwin.scenes.reports.refusals import RefusedLine, models_at, refusals
from axistwin.scenes.reports.run_record import RunRecord, recording_run

if TYPE_CHECKING:
    from axistwin.records.plots.chart import Chart
    from axistwin.records.traces.memory import MemoryTrace
    from axistwin.records.traces.trace import tracing

SECONDS = Number(min=0)
INTERRUPTED = 130


@click.command()
@click.argument("target", metavar="MODEL|SCENE.toml", shell_complete=complete_target)
@click.argument("program", type=PROGRAM, required=False, shell_complete=complete_program)
@click.option("--for", "seconds", type=SECONDS, help="Total virtual time in seconds, from power-up.")
@click.option("--trace", "traces", type=FILE, multiple=True,
              help="Write a trace: FILE.csv, .vcd (GTKWave), .sigrok.vcd or .parquet.")  # fmt: skip
@click.option("--signals", metavar="NAME,…",
              help="Signals to trace: 'default,motor.RPE', 'if1.X.*', '*'.  See docs/traces.md.")  # fmt: skip
@click.option("--trace-limit", type=Size(), default=TRACE_LIMIT, show_default=True, metavar="SIZE|none",
              help="Largest size of each trace, e.g. 5GB.")  # fmt: skip
@click.option("--plot", type=FILE, help="Draw velocities, positions and levels: FILE.svg or FILE.png.")
@click.option("--report", type=FILE, help="Write a page with picture, conversation, verdict and provenance: FILE.html.")
@click.option("--strict", is_flag=True, hidden=True, expose_value=False)  # now always so
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of text; times in nanoseconds.")
@click.option("--option", "options", metavar="NAME=VALUE", multiple=True, help="An option of the model or an axis.")
@click.option("--state", type=click.Path(file_okay=False, path_type=Path),
              help="Directory for the data kept without power.")  # fmt: skip
def run(
    target: str, program: Path | None, seconds: float | None, traces: tuple[Path, ...], signals: str | None,
    trace_limit: int | None, plot: Path | None, report: Path | None, as_json: bool, options: tuple[str, ...],
    state: Path | None,
) -> int:  # fmt: skip
    """Run PROGRAM on a MODEL, or on the controllers of a scene, in virtual time at full speed.

    A scene also runs its own hosts, stored programs and script.  Without --for the run ends when no event is due. An
    endless run ends after 60 s, one of command lines after an hour.

    PROGRAM is a conversation (.talk), IF1/IF2 command lines as typed at a terminal (.if1), commands for an 1810 or 1811
    in hex or by name (.181x), or a SmartMotor's source (.sms), which is stored in the motor before power-up.  With a
    MODEL, a file of another name is such a program, too, and `-` is the standard input.  Before command lines the
    initialisation is done.  A line is sent when the previous line has ended; `;` starts a comment,
    `+2.5` waits, `! input1 high` drives a pin.  `!` and a code mark each line that the controller refuses.

    Ctrl-C ends the run; the results up to then are printed and drawn, with the note that the run was interrupted.

    Exit code 1: the controller differs from the conversation, refuses a line, or a file of --trace or --state cannot
    be written.

    \b
    Examples:
      axistwin run if1 moves.if1
      axistwin run if1 moves.if1 --plot moves.png --trace moves.vcd
      axistwin run smartmotor home.sms --trace home.parquet --signals 'default,smartmotor.RPE,smartmotor.a'
      axistwin run 1811 moves.181x --plot moves.svg
      axistwin run smartmotor home.sms --for 10 --option shaft.motor=frame23
      axistwin run if1 moves.if1 --report moves.html
      axistwin run if1 forever.if1 --for 3600 --json
      axistwin run if2 locked.talk --state ./battery --option wiring=3-wire
      axistwin run examples/winder/scene.toml --plot winder.svg
      axistwin run if1 limits.if1 --option X.limits=[-100,2000]
    """
    if program is None and not target.endswith(".toml"):
        made = product(target)
        example = f"axistwin run {made.model} moves{made.suffix or '.talk'}"
        raise UsageError(f"the PROGRAM is missing: expected a file for {made.indefinite}, e.g. {example}")
    loaded = running.scene_program() if program is None else running.load(program, target)
    if plot is not None:
        from axistwin.records.plots.picture import check_suffix

        check_suffix(plot)
    if report is not None:
        check_path(report)
    logging.basicConfig(format="axistwin: %(message)s")
    bench = bench_for(target, (*loaded.options, *options), state)
    loaded.prepare(bench)
    place = bench.origin.get("title", target)
    what, title = (target, place) if program is None else (program.name, f"{place}  {program.name}")
    with _remembering(bench, (plot, report)) as memory, recording_run(bench) as record:
        with (
            _tracing(bench, traces, signals, trace_limit) as traced,
            working(RunProgress(what, bench, seconds, traces)),
        ):
            outcome, interrupted = _perform(loaded, bench, seconds)
        for controller in bench.controllers.values():
            controller.store.end()
    memories = (controller.store for controller in bench.controllers.values())
    incomplete = any(trace.incomplete for trace in traced) or any(memory.lost for memory in memories)
    chart = _chart(memory, title)
    if plot is not None and chart is not None:
        from axistwin.records.plots.picture import save

        with working(f"drawing {plot.name}"):
            save(chart, plot)
    refused = refusals(record.said, _sent_programs(target, program, bench))
    if refused:
        checked = f"{'' if target.endswith('.toml') else target + ' '}{target if program is None else program}"
        outcome = _with_refusals(outcome, refused, checked)
    _report(record, outcome, refused, as_json)
    code = INTERRUPTED if interrupted else 1 if outcome.difference or refused or incomplete else 0
    if report is not None:
        with working(f"writing {report.name}"):
            write_page(_page(title, record, outcome, refused, chart, code, program), report)
    return code


def _page(
    title: str, record: RunRecord, outcome: Outcome, refused: Sequence[RefusedLine], chart: "Chart | None", code: int,
    program: Path | None,
) -> Page:  # fmt: skip
    ended = "interrupted" if code == INTERRUPTED else "failed" if code else "completed"
    verdict = f"{ended} at {record.bench.seconds:g} s of virtual time"
    reasons = [outcome.note, str(outcome.difference or "")]
    about = {}
    if program is not None:
        about["program"] = f"{program.name}, SHA-256 {sha256(contents(program, MOST_MIB)).hexdigest()}"
    return Page(
        title, verdict, not code, list(transcript.text(record, refused)), {**about, **provenance(record.bench)}, chart,
        [*transcript.summary(record), *transcript.extremes(record)], [reason for reason in reasons if reason],
    )  # fmt: skip


def _perform(loaded: Program, bench: Bench, seconds: float | None) -> tuple[Outcome, bool]:
    """Run the program; return the outcome, and a flag that is True if the user has interrupted the run."""
    try:
        return loaded.perform(bench, None if seconds is None else to_ns(seconds)), False
    except KeyboardInterrupt:
        return Outcome(note=f"interrupted at {bench.seconds:g} s"), True


def _remembering(bench: Bench, files: Sequence[Path | None]) -> "AbstractContextManager[MemoryTrace | None]":
    if not any(files):
        return nullcontext()
    from axistwin.records.traces.memory import tracing_in_memory

    return tracing_in_memory(bench)


def _chart(memory: "MemoryTrace | None", title: str) -> "Chart | None":
    if memory is None:
        return None
    from axistwin.records.plots.trace_chart import of_trace

    return of_trace(memory.trace(), title=title)


@contextmanager
def _tracing(bench: Bench, files: Sequence[Path], signals: str | None, limit: int | None) -> "Iterator[list[tracing]]":
    with ExitStack() as stack:
        traced = []
        for file in files:
            from axistwin.records.traces.signals import split
            from axistwin.records.traces.trace import tracing

            trace = tracing(
                bench, file, split(signals), lambda words: click.echo(f"axistwin: {words}", err=True), limit
            )
            traced.append(stack.enter_context(trace))
        yield traced


def _with_refusals(outcome: Outcome, refused: Sequence[RefusedLine], checked: str) -> Outcome:
    lines = len({(each.file, each.error.line) for each in refused})
    note = f"{lines} line{'s' * (lines != 1)} refused: {repeated()} check {checked}"
    return replace(outcome, note="; ".join(each for each in (outcome.note, note) if each))


def _sent_programs(target: str, program: Path | None, bench: Bench) -> list[HostProgram]:
    models = models_at(bench)
    named: list[tuple[str, Path]] = []
    if target.endswith(".toml"):
        # Import `Scene` only for a scene file (.toml), not for a model name such as if1, because the import is slow.
        from axistwin.scenes.scene import Scene

        named += Scene.load(Path(target)).named_programs()
    if program is not None:
        fits = [name for name, made in models.items() if name and _is_for(program, made)]
        named.append((fits[0] if len(bench.controllers) > 1 and kind_of(program) != ".talk" and fits else "", program))
    made = None if target.endswith(".toml") else product(target)
    return [
        sent
        for endpoint, file in named
        for sent in host_programs(load(file, made), kind_of(file, made), endpoint, models, str(file))[0]
    ]


def _is_for(program: Path, made: Product) -> bool:
    return bool(made.suffix) and kind_of(program) == made.suffix


def _report(record: RunRecord, outcome: Outcome, refused: Sequence[RefusedLine], as_json: bool) -> None:
    if as_json:
        difference = asdict(outcome.difference) if outcome.difference else None
        click.echo(json.dumps({**transcript.as_dict(record, refused), "difference": difference, "note": outcome.note}))
        return
    for line in transcript.text(record, refused):
        click.echo(line)
    click.echo()
    for line in transcript.summary(record):
        click.echo(line)
    if not record.complete:
        click.echo("axistwin: the output is incomplete: only the latest events were kept", err=True)
    there = record.bench.controllers.values()
    hints = (f"{controller.name}: {controller.hint}" for controller in there if controller.hint)
    for note in (outcome.note, *hints, *sorted({controller.product.note() for controller in there})):
        if note:
            click.echo(f"axistwin: {note}", err=True)
    if outcome.difference:
        click.echo(f"axistwin: {outcome.difference}", err=True)
