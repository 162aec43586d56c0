"""`axistwin learn`: six short lessons for a model, in the terminal."""

import asyncio
import json
import sys
from functools import partial
from pathlib import Path

import click

from axistwin.bench import product
from axistwin.cli.common.parameters import FILE
from axistwin.cli.common.target import bench_for
from axistwin.cli.serving.term import ENDS, converse_with
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.storage import state_file, write_file
from axistwin.ui.teaching.lessons import course


@click.command()
@click.argument("model")
@click.option("--lesson", type=click.IntRange(1, 6),
              help="Begin with this lesson.  [default: the first unfinished lesson]")  # fmt: skip
@click.option("--list", "listing", is_flag=True, help="List the lessons, with a mark at finished lessons.")
@click.option("--progress", type=FILE, help="File for the finished lessons.  [default: in the user's state directory]")
def learn(model: str, lesson: int | None, listing: bool, progress: Path | None) -> int:
    """Learn to use a MODEL in six short lessons in the terminal.

    A lesson opens a terminal to a virtual controller, as `axistwin term MODEL` does, and sets one task after another.
    Each step is checked by its effect on the controller.  `:task` repeats the task, `:show` shows a
    solution, `:why` and `:explain` help, `:quit` leaves.  After a lesson the next one begins.  The next call begins
    with the lesson in which you stopped.

    \b
    Examples:
      axistwin learn if1
      axistwin learn 1811 --lesson 3
      axistwin learn smartmotor --list
    """
    lessons, model = course(model), product(model).model
    file = progress or state_file("lessons.json")
    done = _load(file)
    number = lesson or min(done.get(model, 0) + 1, len(lessons))
    if listing:
        for at, each in enumerate(lessons, start=1):
            click.echo(f"{'done' if at <= done.get(model, 0) else '    '}  {at}  {each.title}")
        return 0
    while True:
        chosen = lessons[number - 1]
        click.echo(f"axistwin: {model}, lesson {number} of {len(lessons)}: {chosen.title}")
        over, code = asyncio.run(converse_with(partial(bench_for, model), ENDS["cr"], chosen))
        if not over:
            return code
        done[model] = max(done.get(model, 0), number)
        code, last = code or _save(file, done), number == len(lessons)
        then = "this was the last lesson" if last else f"axistwin learn {model} begins lesson {number + 1}"
        ends = last or not sys.stdin.isatty()
        click.echo(f"axistwin: lesson {number} is done{f': {then}' if ends else ''}")
        if ends:
            return code
        number += 1


def _load(file: Path) -> dict[str, int]:
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise UsageError(
            f"cannot read your progress from {file} ({error}): delete the file to begin again with lesson 1"
        ) from None
    return {str(model): int(number) for model, number in found.items()} if isinstance(found, dict) else {}


def _save(file: Path, done: dict[str, int]) -> int:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_file(file, json.dumps(done), f"cannot save your progress in {file}")
    except (OSError, AxistwinError) as error:
        click.echo(f"axistwin: {error}", err=True)
        return 1
    return 0
