"""`axistwin new`: a new scene from a few answers."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click

from axistwin.bench.models import models
from axistwin.cli.common.repeating import program
from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, whole
from axistwin.core.storage import write_error
from axistwin.ui.guide import new_scene
from axistwin.ui.guide.new_scene import Answers


@click.command()
@click.argument("directory", type=click.Path(file_okay=False, path_type=Path), metavar="DIR")
@click.option("--models", metavar="MODEL,…", help="Models of the controllers: if1, if2, 1810, 1811, smartmotor.")
@click.option("--axes", metavar="N", help="Axes of each IF1 or IF2: 1 to 3.")
@click.option("--travel", metavar="N", help="Position of the plus limit switch, in pulses or counts.")
@click.option("--host", metavar="HOST", help="Host: scene (simulated), outside (your program at a port), or both.")
@click.option("--port", metavar="URL", help="Port of the first controller, e.g. tcp://127.0.0.1:5001.")
@click.option("--yes", "-y", is_flag=True, help="Ask no questions: use the default for each missing option.")
@click.option("--panel", metavar="[H:]P", help="Serve the new scene, with a panel for browsers at this port.")
def new(directory: Path, yes: bool, panel: str | None, **given: str | None) -> Any:
    """Ask five questions, and write a new scene into the directory DIR.

    The scene has comments, and a first program for each controller.  It can be run at once.  An option replaces its
    question.
    No file is overwritten.

    \b
    Examples:
      axistwin new cell
      axistwin new cell --models if1,smartmotor --axes 2 --yes
      axistwin new cell --yes --panel 8080
    """
    scene = directory / "scene.toml"
    if scene.exists():
        raise UsageError(f"{scene} exists already: choose a directory without this file")
    texts = new_scene.files(_answers(given, asking=not yes), program(directory))
    if existing_files := [directory / name for name in texts if (directory / name).exists()]:
        raise UsageError(f"{existing_files[0]} exists already: choose a directory without this file")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (directory / name).write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise write_error(f"cannot write to {directory}", error, "choose another directory") from None
    for name in texts:
        click.echo(directory / name)
    if panel is None:
        click.echo(f"axistwin: next: {program()} {'serve' if len(texts) == 1 else 'run'} {scene}", err=True)
        return 0
    from axistwin.cli.serving.serve import serve

    return serve.main([str(scene), "--panel", panel], standalone_mode=False)


def _answers(given: dict[str, str | None], *, asking: bool) -> Answers:
    def answer(name: str, question: str, default: str, read: Callable[[str], Any]) -> Any:
        text = given[name]
        return _ask(question, default, read) if asking and text is None else read(default if text is None else text)

    chosen = answer("models", f"Models, of {', '.join(models())}", "if1", new_scene.read_models)
    return Answers(
        chosen,
        answer("axes", "Axes of each IF1 or IF2, 1 to 3 (other models have one)", "2", partial(_whole, *_AXES)),
        answer(
            "travel",
            "Travel of each axis from 0 to the plus limit switch, in motor pulses or encoder counts",
            "20000",
            partial(_whole, *_TRAVEL),
        ),
        answer("host", "Host: scene (simulated), outside (your own program), both", new_scene.BOTH, _host),
        answer("port", "Port of the first controller", "tcp://127.0.0.1:5001", new_scene.read_port),
    )


def _ask(question: str, default: str, read: Callable[[str], Any]) -> Any:
    while True:
        try:
            return read(click.prompt(question, default=default, err=True))
        except UsageError as error:
            click.echo(f"axistwin: {error}", err=True)
        except click.Abort as end:
            if isinstance(end.__context__, EOFError):
                raise UsageError(
                    "stdin has ended before all questions were answered: "
                    "expected more lines with answers, or --yes to use the default answers"
                ) from None
            raise


_AXES = "number of axes", 1, len(new_scene.DIGIPLAN_AXES), "2"
_TRAVEL = "travel", new_scene.LEAST_TRAVEL, new_scene.MOST_TRAVEL, "20000"


def _whole(quantity: str, low: int, high: int, example: str, text: str) -> int:
    try:
        return whole(text, low, high)
    except NumberError:
        raise UsageError(f"invalid {quantity} {text!r}: expected {low} to {high}, e.g. {example}") from None


def _host(text: str) -> str:
    if text not in new_scene.HOSTS:
        raise UsageError(f"invalid host {text!r}: expected one of {', '.join(new_scene.HOSTS)}")
    return text
