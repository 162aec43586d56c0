"""`axistwin term`: a terminal for a virtual controller in this process, or for a controller at a port."""

import asyncio
import os
import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any

import click

from axistwin.bench import Bench, Controller, is_model, product
from axistwin.bench.codec import CHARACTERS
from axistwin.bench.models import models
from axistwin.bench.options import read_options
from axistwin.bench.programs import command_lines
from axistwin.bench.programs.keyboards import KEYBOARDS, to_codes, to_glyphs
from axistwin.cli.common.completing import complete_model
from axistwin.core.errors import LinkError, ProgramError, UsageError
from axistwin.core.units import S
from axistwin.links.pacing import read_speed
from axistwin.ui.teaching.lessons import STARTED_S, Lesson
from axistwin.ui.teaching.pupil import Pupil
from axistwin.ui.terminal.commands import LocalCommands
from axistwin.ui.terminal.screen import Screen

if TYPE_CHECKING:
    from axistwin.ui.terminal.virtual import VirtualEnd

ENDS = {"cr": b"\r", "lf": b"\n", "crlf": b"\r\n"}
INITIALISED_NS = 30 * S  # Longest virtual time of an automatic initialisation; then it is left to the user.

LOOK_S = 0.1  # Interval in seconds between two checks of a lesson's step.

Lines = asyncio.Queue[bytes | LinkError | None]
"""Queue of typed lines, of None at the end of the input, and of the error of a failed port."""


@click.command()
@click.argument("target", metavar="MODEL|PORT", shell_complete=complete_model)
@click.option("--no-init", is_flag=True, help="Do not initialise a virtual controller.")
@click.option("--speed", default="1", show_default=True, metavar="N|max", help="Virtual time per real time.")
@click.option("--line", metavar="FORMAT", help="Line format, e.g. '9600 8N2'; for a virtual controller also 'instant'.")
@click.option("--end", type=click.Choice(list(ENDS)), help="Characters sent for Enter; default: the model's, or cr.")
@click.option(
    "--tutor/--no-tutor",
    default=None,
    help="Explain typed lines and answers, for a virtual controller.  [default: only at a terminal]",
)
@click.option(
    "--keyboard",
    type=click.Choice(list(KEYBOARDS)),
    default="us",
    show_default=True,
    help="National keyboard, for an IF1 or IF2: on uk, £ sends the code of #.",
)
@click.option("--option", "options", metavar="NAME=VALUE", multiple=True, help="An option of the model or an axis.")
@click.option("--state", type=click.Path(file_okay=False, path_type=Path),
              help="Directory for the data kept without power.")  # fmt: skip
def term(
    target: str, no_init: bool, speed: str, line: str | None, end: str | None, tutor: bool | None, keyboard: str,
    options: tuple[str, ...], state: Path | None,
) -> int:  # fmt: skip
    """Open a terminal to a virtual MODEL in this process, or to a controller at a PORT.

    PORT is a URL or a device of pyserial.  A typed line is sent on Enter.  Received data are shown at once, with
    control characters by name.  `:help` lists the terminal's own commands, `:next` says what to type.  At a
    terminal the line can be edited, Tab completes, the last line shows time, positions and state, and asides in grey
    explain refused lines and answers.

    A virtual 1810 or 1811 takes commands in hex or by name, such as `go_relative 25000`, and its messages are shown by
    name, too.  A virtual IF1 or IF2 is initialised first.  Lines from a pipe are sent one by one, each when the
    controller has finished the previous line.

    \b
    Examples:
      axistwin term if1
      axistwin term if1 --keyboard uk
      axistwin term if1 --speed 10 --option X.limits=[-100,5000]
      printf 'X1000$\\nE\\n:axes\\n' | axistwin term if1 --speed max
      axistwin term 1811
      axistwin term smartmotor --option shaft.motor=frame23
      axistwin term socket://127.0.0.1:5001
      axistwin term rfc2217://127.0.0.1:2217 --line '2400 7E1'
      axistwin term /dev/ttyUSB0
      axistwin term COM3
    """
    known = is_model(target)
    if not known and not _is_port(target):
        names = ", ".join(models())
        raise UsageError(
            f"unknown model or port {target!r}: expected {names}, or a port such as socket://127.0.0.1:5001"
        )
    local = {"no_init": no_init, "speed": speed != "1", "option": bool(options), "state": state is not None}
    local["tutor"] = bool(tutor)
    if keyboard != "us" and known and product(target).family != "digiplan":
        raise UsageError(f"--keyboard {keyboard} is only for an IF1 or IF2: leave out this option for {target}")
    if known:
        made = partial(_bench, target, state=state, line=line, **read_options(options))
        ending = ENDS[end] if end else product(target).endings[0]
        return asyncio.run(_virtual(made, read_speed(speed), ending, keyboard, not no_init, tutor))
    if option := next((name.replace("_", "-") for name, given in local.items() if given), None):
        raise UsageError(f"--{option} is only for a virtual controller: give a model instead of a port, e.g. if1")
    return asyncio.run(_port(target, line, ENDS[end or "cr"], keyboard))


def _is_port(target: str) -> bool:
    return bool(set(target) & set("/:")) or re.fullmatch(r"COM\d+", target, re.IGNORECASE) is not None


def _bench(model: str, **options: Any) -> Bench:
    bench = Bench()
    bench.add(model, **options)
    return bench


async def _virtual(
    build: Callable[[], Bench], speed: float | None, end: bytes, keyboard: str, initialise: bool, tutor: bool | None
) -> int:
    from axistwin.scenes.sessions.session import Session
    from axistwin.ui.terminal.virtual import virtual_end

    session = Session(build, speed)
    screen, (controller,) = _screen(keyboard), session.bench.controllers.values()
    _greet(controller.product.title)
    if initialise and controller.product.family == "digiplan":
        _initialise(session.bench, controller, screen)
    other = virtual_end(session, screen)
    other.tutor.on = screen.person if tutor is None else tutor
    try:
        return await _with_person(screen, LocalCommands(other, screen, other), Lines(), end, keyboard, other)
    finally:
        other.close()


async def converse_with(build: Callable[[], Bench], end: bytes, lesson: Lesson) -> tuple[bool, int]:
    """Open a terminal for a lesson.  Return True if the lesson has been finished, and the exit code."""
    from axistwin.scenes.sessions.session import Session
    from axistwin.ui.terminal.virtual import virtual_end

    person = sys.stdin.isatty()
    session = Session(build, 1.0 if person else None)
    screen, (controller,) = _screen("us"), session.bench.controllers.values()
    _greet(controller.product.title)
    if controller.product.family == "digiplan" and lesson.initialised:
        _initialise(session.bench, controller, screen)
    else:
        session.bench.run(STARTED_S)
    other = virtual_end(session, screen)
    commands = LocalCommands(other, screen, other)
    commands.lesson = pupil = Pupil(lesson, session.bench)
    screen.show(pupil.task)
    lines = Lines()
    watching = asyncio.create_task(_watch(commands, lines)) if person else None
    try:
        code = await _with_person(screen, commands, lines, end, "us", other)
    finally:
        if watching is not None:
            watching.cancel()
        pupil.close()
        other.close()
    return pupil.finished, code


async def _watch(commands: LocalCommands, lines: Lines) -> None:
    while not commands.check_lesson():
        await asyncio.sleep(LOOK_S)
    lines.put_nowait(None)


async def _port(target: str, line: str | None, end: bytes, keyboard: str) -> int:
    from axistwin.real.hosts.port_end import PortEnd

    screen, lines = _screen(keyboard), Lines()
    other = PortEnd(target, line, screen.show_received, lines.put_nowait)
    _greet(target)
    try:
        return await _with_person(screen, LocalCommands(other, screen), lines, end, keyboard)
    finally:
        other.close()


async def _with_person(
    screen: Screen, commands: LocalCommands, lines: Lines, end: bytes, keyboard: str,
    virtual: "VirtualEnd | None" = None,
) -> int:  # fmt: skip
    if not _edited():
        Thread(target=_read_lines, args=(asyncio.get_running_loop(), lines), daemon=True).start()
        return await _converse(screen, commands, lines, end, keyboard)
    from prompt_toolkit.patch_stdout import patch_stdout

    from axistwin.ui.terminal.editor import LineEditor, history

    model = "port" if virtual is None else virtual.controller.product.model
    with patch_stdout(raw=True):
        screen.out = sys.stdout
        editor = LineEditor(virtual, history(model))
        reading = asyncio.create_task(editor.read(lines))
        try:
            code = await _converse(screen, commands, lines, end, keyboard)
        finally:
            editor.close()
            await reading
    return 130 if editor.interrupted else code


def _edited() -> bool:
    return sys.stdin.isatty() and sys.stdout.isatty() and os.environ.get("TERM", "") not in ("", "dumb")


def _screen(keyboard: str) -> Screen:
    glyphs = partial(to_glyphs, keyboard)
    person, colours = sys.stdin.isatty(), sys.stdout.isatty()
    return Screen(sys.stdout, person=person, colours=colours, editor=_edited(), glyphs=glyphs)


def _greet(what: str) -> None:
    if sys.stdin.isatty():
        click.echo(f"axistwin: {what}.  :help lists the commands, :quit leaves.", err=True)


def _initialise(bench: Bench, controller: Controller, screen: Screen) -> None:
    """Initialise the controller before the first line; no real time passes."""
    ends = (
        controller.serial.subscribe_sent(screen.show_sent),
        controller.serial.subscribe_received(lambda byte, _: screen.show_received(bytes([byte]))),
    )
    try:
        command_lines.send_lines(bench, (), INITIALISED_NS)
    except ProgramError as error:
        screen.show(str(error))
    for end in ends:
        end()


async def _converse(screen: Screen, commands: LocalCommands, lines: Lines, end: bytes, keyboard: str) -> int:
    screen.prompt()
    while (line := await lines.get()) is not None:
        if isinstance(line, LinkError):
            screen.close()
            raise line
        screen.typed(line.decode(errors="replace"))
        if commands.knows(line):
            if not await commands.obey(line.decode(errors="replace")):
                break
        else:
            try:
                data = _codes(keyboard, line) + end if end else CHARACTERS.read(line.decode(errors="replace"))
                screen.aside(*commands.asides(data))
                commands.end.send(data)
            except ProgramError as error:
                screen.show(error.message)
                screen.aside(*commands.asides_about(error))
        if not screen.person:
            await commands.end.run_until_quiet()
            if commands.check_lesson():
                break
        screen.prompt()
    screen.close()
    return 0


def _codes(keyboard: str, line: bytes) -> bytes:
    return line if keyboard == "us" else to_codes(keyboard, line.decode(errors="replace")).encode("ascii", "replace")


def _read_lines(loop: asyncio.AbstractEventLoop, lines: Lines) -> None:
    rest = b""
    try:
        while data := os.read(sys.stdin.fileno(), 4096):
            *whole, rest = (rest + data).split(b"\n")
            for line in whole:
                loop.call_soon_threadsafe(lines.put_nowait, line.removesuffix(b"\r"))
        if rest:
            loop.call_soon_threadsafe(lines.put_nowait, rest)
        loop.call_soon_threadsafe(lines.put_nowait, None)
    except RuntimeError:  # `axistwin term` has ended, and needs no more lines from stdin.
        return
