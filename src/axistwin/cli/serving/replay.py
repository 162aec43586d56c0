"""`axistwin replay`: compare a virtual controller with a recording of a real one."""

import json
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path

import click

from axistwin.bench.programs import running
from axistwin.bench.talk.comparison import PATIENCE_S, Compared, Comparison, compare
from axistwin.bench.talk.conversation import load_text, parse
from axistwin.cli.common.parameters import FILE, Seconds
from axistwin.cli.common.target import bench_for
from axistwin.cli.common.working import RunProgress, working
from axistwin.core.errors import UsageError
from axistwin.core.units import MS

WIDEST = 40  # Largest width of a message in the table, in characters.


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("file", type=FILE, metavar="FILE.talk")
@click.option("--model", metavar="MODEL|SCENE.toml",
              help="The virtual controller; default: the model in the recording.")  # fmt: skip
@click.option("--option", "options", multiple=True, metavar="NAME=VALUE", help="An option of the model or an axis.")
@click.option("--on-for", type=Seconds(), metavar="SECONDS",
              help="Time since the controller was switched on; default: as recorded.")  # fmt: skip
@click.option("--patience", type=Seconds(), default=PATIENCE_S, show_default=True, metavar="SECONDS",
              help="Accepted delay relative to the hardware.")  # fmt: skip
@click.option("--brief", is_flag=True, help="Print only the acts that differ in bytes.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of text; times in nanoseconds.")
def replay(
    file: Path, model: str | None, options: tuple[str, ...], on_for: float | None, patience: float, brief: bool,
    as_json: bool,
) -> int:  # fmt: skip
    """Compare a virtual controller (the twin) with the recording of a real controller.

    The table shows each reply of the hardware and each change of its control lines, if the twin does the same, and both
    delays from the host's last act.  A summary follows: the number of differences in bytes, and the differences in time
    (median, worst).  Exit code 1 if anything differs in bytes.

    \b
    axistwin replay session.talk --model if1
    axistwin replay session.talk --model smartmotor --option shaft.motor=frame23 --brief
    axistwin replay session.talk --model if2 --option wiring=3-wire --json
    """
    conversation = parse(load_text(file), str(file), model=model or "")
    model = model or conversation.headers.get("model")
    if not model:
        raise UsageError(f"{file} contains no model: add --model, e.g. --model if1")
    given = () if model.endswith(".toml") else running.options(conversation, model)
    bench = bench_for(model, (*given, *options))
    with working(RunProgress(file.name, bench)):
        bench.run(conversation.seconds_in("on-for", 0.0) if on_for is None else on_for)
        comparison = compare(conversation, bench, patience)
    if as_json:
        click.echo(json.dumps(as_dict(comparison)))
    else:
        for line in (*table(comparison, brief=brief), *summary(comparison)):
            click.echo(line)
    return 1 if comparison.different else 0


def table(comparison: Comparison, *, brief: bool = False) -> Iterator[str]:
    acts = comparison.different if brief else comparison.acts
    if not acts:
        return
    yield f"{'line':>6}  {'hardware ms':>12}  {'twin ms':>12}  {'later by ms':>12}"
    for act in acts:
        times = (act.hardware_ns, act.twin_ns, act.later_ns)
        yield f"{act.line or 'end':>6}  {'  '.join(_ms(ns) for ns in times)}  {_reply_text(act)}"
        if not act.same:
            yield from _difference(act)


def _ms(ns: int | None) -> str:
    return f"{'-' if ns is None else f'{ns / MS:.3f}':>12}"


def _reply_text(act: Compared) -> str:
    words = act.expected if act.same else "differs"
    return "  ".join(_short(text) for text in (act.after, f"< {words}" if act.same else words) if text)


def _short(text: str) -> str:
    return text if len(text) <= WIDEST else f"{text[: WIDEST - 1]}…"


def _difference(act: Compared) -> Iterator[str]:
    alike = takewhile(lambda pair: pair[0] == pair[1], zip(act.expected, act.got, strict=False))
    yield f"{'hardware':>14}  {act.expected or '(nothing)'}"
    yield f"{'twin':>14}  {act.got or '(nothing)'}"
    yield f"{'':14}  {' ' * len(list(alike))}^"


def summary(comparison: Comparison) -> Iterator[str]:
    count, different = len(comparison.acts), len(comparison.different)
    yield f"{count} {'act' if count == 1 else 'acts'} of the controller, {different or 'none'} different in bytes"
    worst = comparison.worst
    if worst is not None and worst.later_ns is not None and comparison.median_ns is not None:
        median, most = comparison.median_ns / MS, worst.later_ns / MS
        yield f"the twin is later by {median:.3f} ms (median), at worst by {most:.3f} ms in line {worst.line}"


def as_dict(comparison: Comparison) -> dict[str, object]:
    """Return the comparison for `--json`.  `later_ns`: delay of the twin; null if unknown or if the bytes differ."""
    worst = comparison.worst
    return {
        "acts": [
            {
                "line": act.line or None,
                "after": act.after,
                "hardware": act.expected,
                "twin": act.got,
                "same": act.same,
                "hardware_ns": act.hardware_ns,
                "twin_ns": act.twin_ns,
                "later_ns": act.later_ns,
            }
            for act in comparison.acts
        ],
        "different": len(comparison.different),
        "median_later_ns": comparison.median_ns,
        "worst_later_ns": None if worst is None else worst.later_ns,
        "worst_line": None if worst is None else worst.line,
    }
