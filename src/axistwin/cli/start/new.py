"""`axistwin new`: a new scene, or a new device, from a few answers."""

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
from axistwin.ui.guide import new_device, new_scene
from axistwin.ui.guide.new_scene import Answers


@click.command()
@click.argument("directory", type=click.Path(file_okay=False, path_type=Path), metavar="DIR")
@click.option("--models", metavar="MODEL,…", help="Models of the controllers: if1, if2, 1810, 1811, smartmotor.")
@click.option("--axes", metavar="N", help="Axes of each IF1 or IF2: 1 to 3; of a device: 1 to 8.")
@click.option("--travel", metavar="N", help="Position of the plus limit switch, in pulses, counts or units.")
@click.option("--host", metavar="HOST", help="Host: scene (simulated), outside (your program at a port), or both.")
@click.option("--port", metavar="URL", help="Port of the first controller, e.g. tcp://127.0.0.1:5001.")
@click.option("--device", is_flag=True, help="A device of your own, with its test and a scene.")
@click.option("--name", metavar="NAME", help="Name of the device's model, e.g. stage.")
@click.option("--framing", metavar="FRAMING", help="Its requests: cr, lf, crlf (ends of lines), datagrams.")
@click.option("--line", metavar="FORMAT", help="Its serial line, e.g. 9600 8N1.")
@click.option("--units", metavar="UNITS", help="Unit of its positions: steps, or e.g. 80 per mm.")
@click.option("--yes", "-y", is_flag=True, help="Ask no questions: use the default for each missing option.")
@click.option("--panel", metavar="[H:]P", help="Serve the new scene, with a panel for browsers at this port.")
def new(directory: Path, device: bool, yes: bool, panel: str | None, **given: str | None) -> Any:
    """Ask five questions, and write a new scene into the directory DIR.

    The scene has comments, and a first program for each controller.  It can be run at once.  With --device six
    questions make a device of your own, with test and scene.  An option replaces its question.
    No file is overwritten.

    \b
    Examples:
      axistwin new cell
      axistwin new cell --models if1,smartmotor --axes 2 --yes
      axistwin new cell --yes --panel 8080
      axistwin new stage --device --units "80 per mm"
    """
    scene = directory / "scene.toml"
    if scene.exists():
        raise UsageError(f"{scene} exists already: choose a directory without this file")
    _check_options(given, SCENES if device else DEVICES, device)
    if device:
        texts = _device(given, asking=not yes)
    else:
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
    if panel is None or device:
        named = f"axistwin --device {directory / next(iter(texts))}" if device else program()
        click.echo(f"axistwin: next: {named} {'serve' if len(texts) == 1 else 'run'} {scene}", err=True)
        return 0
    from axistwin.cli.serving.serve import serve

    return serve.main([str(scene), "--panel", panel], standalone_mode=False)


def _check_options(given: dict[str, str | None], unused: tuple[str, ...], device: bool) -> None:
    for name in unused:
        if given[name] is not None:
            raise UsageError(f"--{name} {'is not' if device else 'is only'} for --device: leave one of them out")


def _answer(
    given: dict[str, str | None], name: str, question: str, default: str, read: Callable[[str], Any], *, asking: bool
) -> Any:
    text = given[name]
    return _ask(question, default, read) if asking and text is None else read(default if text is None else text)


def _device(given: dict[str, str | None], *, asking: bool) -> dict[str, str]:
    answer = partial(_answer, given, asking=asking)
    name = answer("name", "Name of the model", "stage", new_device.read_name)
    framing = answer("framing", "Requests: cr, lf, crlf (ends of lines) or datagrams", "cr", new_device.read_framing)
    line = answer("line", "Serial line", "9600 8N1", new_device.read_line)
    axes = answer("axes", "Axes, 1 to 8", "2", partial(_whole, "number of axes", 1, new_device.MOST_AXES, "2"))
    units = answer("units", "Unit of positions: steps, or e.g. 80 per mm", "steps", new_device.read_units)
    travel = answer(
        "travel", f"Travel of each axis from 0 to the plus limit switch, in {units.of if units else 'steps'}",
        "250" if units else "20000", partial(_whole, "travel", 2, new_device.MOST_TRAVEL, "250"),
    )  # fmt: skip
    port = new_scene.read_port(given["port"] or "tcp://127.0.0.1:5001")
    return new_device.files(new_device.Answers(name, framing, line, axes, units, travel, port))


def _answers(given: dict[str, str | None], *, asking: bool) -> Answers:
    answer = partial(_answer, given, asking=asking)
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


SCENES, DEVICES = ("models", "host"), ("name", "framing", "line", "units")  # Options of only one of both.
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
