"""`axistwin check`: what is wrong with a program, with line, column and the manual's chapter.

The family's own checker finds it; here a program becomes characters with places, whatever it is written in.
"""

import json
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path

import click

from axistwin.apps import conversation
from axistwin.apps.conversation import Act, Do, Say, parse_line
from axistwin.apps.programs import no_program
from axistwin.apps.stored import load_source
from axistwin.apps.typist import command_line
from axistwin.apps.visible import CHARACTERS, Codec, codec_of
from axistwin.bench import FAMILIES, product
from axistwin.controllers.diagnostics import Checker, Diagnostic, Sent, Session, Severity
from axistwin.errors import ProgramError, UsageError

KINDS = {".if1": "digiplan", ".181x": "compumotor", ".sms": "smartmotor"}
"""The families that kinds of programs are for; conversations are for all."""


@click.command(short_help="Find what is wrong with a program.")
@click.argument("model")
@click.argument("program", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of text.")
def check(model: str, program: Path, as_json: bool) -> int:
    """Find what a MODEL would refuse in PROGRAM, and what can hardly be meant, without running it.

    PROGRAM is a conversation (.talk), of which the host's lines are checked, or IF1/IF2 command lines as typed at a
    terminal (.if1), or commands for an 1810 or 1811 in hex or by name (.181x), or a SmartMotor's source (.sms).  For
    each finding one line is printed, in order of place:

    \b
      moves.if1:3:5: error: unknown character 'x': commands are upper case (manual: Full command list)

    An error is refused by the controller.  A warning is obeyed, or ignored, but hardly as it was meant.

    Exit code 1: there are errors.

    \b
    Examples:
      axistwin check if1 moves.if1
      axistwin check if2 tests/session.talk --json
      axistwin check 1811 moves.181x
      axistwin check smartmotor home.sms
    """
    made = product(model)
    if made.check is None:
        raise UsageError(f"programs for {made.model} cannot be checked")
    if (family := KINDS.get(program.suffix.lower(), FAMILIES[made.model])) != FAMILIES[made.model]:
        models = " or ".join(name for name in FAMILIES if FAMILIES[name] == family)
        raise UsageError(f"{program} is a program for {models}, not for {made.model}")
    found = diagnose(program, made.check, codec_of(made))
    errors = sum(diagnostic.severity is Severity.ERROR for diagnostic in found)
    if as_json:
        listed = [{"file": str(program), **asdict(diagnostic)} for diagnostic in found]
        click.echo(json.dumps({"model": model, "errors": errors, "diagnostics": listed}, ensure_ascii=False))
    else:
        _tell(program, found)
        click.echo(f"axistwin: {program}: {_summary(errors, len(found) - errors)}", err=True)
    return 1 if errors else 0


def diagnose(program: Path, checker: Checker, codec: Codec = CHARACTERS) -> list[Diagnostic]:
    """Everything that is wrong with a program file.  Raises UsageError or ProgramError if it is none."""
    text = _text(program)
    lines, unread = text.splitlines(), []
    acts: list[Act] = []
    read = _reader(program, codec)
    for number, line in enumerate(lines, start=1):
        try:
            act = read(line, number, str(program))
        except ProgramError as error:
            unread.append(Diagnostic(number, error.column or 1, Severity.ERROR, error.message))
        else:
            acts += [act] if act is not None else []
    hosts = _hosts(program, acts, lines, codec)
    return sorted([*unread, *(diagnostic for sessions in hosts for diagnostic in checker(sessions))])


def _text(program: Path) -> str:
    """Of a motor's source, what is no ASCII stands in comments."""
    return load_source(program).decode("ascii") if program.suffix.lower() == ".sms" else conversation.load_text(program)


def _reader(program: Path, codec: Codec) -> Callable[[str, int, str], Act | None]:
    """What reads a line of such a program."""
    match program.suffix.lower():
        case ".talk":
            return lambda line, number, file: parse_line(line, number, file, codec) if line.strip() else None
        case ".181x":
            return partial(_command, codec)
        case ".if1":
            return command_line
        case ".sms":
            return lambda line, number, _: Say(line.encode("ascii"), line=number)
    raise no_program(program)


def _command(codec: Codec, line: str, number: int, file: str) -> Act | None:
    """A command for a board on a bus, in hex or by name."""
    words = line.partition(";")[0].rstrip()
    if words.lstrip().startswith(("+", "!")):
        return parse_line(words, number, file)
    return Say(codec.read(words), line=number) if words else None


def _hosts(program: Path, acts: Iterable[Act], lines: Sequence[str], codec: Codec) -> Iterable[Sequence[Session]]:
    """What is sent to each controller."""
    match program.suffix.lower():
        case ".talk":
            return _conversation(acts, lines, codec)
        case ".181x":
            return _commands(acts, lines, codec)
        case ".sms":
            return _stored(acts)
        case _:
            return _typed(acts)


@dataclass
class _Host:
    """What has been sent to one controller, between one switching off and the next."""

    sessions: list[Session] = field(default_factory=list)
    characters: list[Sent] = field(default_factory=list)
    initialised: bool = False

    def switch_off(self) -> None:
        self.sessions.append(Session(tuple(self.characters), self.initialised))
        self.characters, self.initialised = [], False


def _conversation(acts: Iterable[Act], lines: Sequence[str], codec: Codec) -> Iterator[Sequence[Session]]:
    hosts: dict[str, _Host] = {}
    for act in acts:
        host = hosts.setdefault(act.controller, _Host())
        if isinstance(act, Say):
            line = lines[act.line - 1].rstrip()
            begin = re.compile(r"[^>]*>\s*").match(line)
            assert begin is not None
            places = (begin.end() + column + 1 for column in codec.places(line[begin.end() :]))
            host.characters += map(Sent, act.data, [act.line] * len(act.data), places)
        _power(act, host)
    for host in hosts.values():
        host.switch_off()
        yield host.sessions


def _typed(acts: Iterable[Act]) -> Iterator[Sequence[Session]]:
    """A line is ended by Enter, which stands behind its last character."""
    host = _Host(initialised=True)
    for act in acts:
        if isinstance(act, Say):
            host.characters += [Sent(byte, act.line, column) for column, byte in enumerate(act.data + b"\r", start=1)]
        _power(act, host)
    host.switch_off()
    yield host.sessions


def _commands(acts: Iterable[Act], lines: Sequence[str], codec: Codec) -> Iterator[Sequence[Session]]:
    """Commands for a board on a bus, one per line."""
    host = _Host(initialised=True)
    for act in acts:
        if isinstance(act, Say):
            words = lines[act.line - 1].partition(";")[0].rstrip()
            host.characters += map(Sent, act.data, [act.line] * len(act.data), (at + 1 for at in codec.places(words)))
        _power(act, host)
    host.switch_off()
    yield host.sessions


def _stored(acts: Iterable[Act]) -> Iterator[Sequence[Session]]:
    """A motor's source: all its characters, comments too, each line ended by CR."""
    characters = [
        Sent(byte, act.line, column)
        for act in acts
        if isinstance(act, Say)
        for column, byte in enumerate(act.data + b"\r", start=1)
    ]
    yield [Session(tuple(characters), stored=True)]


def _power(act: Act, host: _Host) -> None:
    if isinstance(act, Do) and act.target == "power" and act.value in ("off", "low"):
        host.switch_off()


def _tell(program: Path, found: Iterable[Diagnostic]) -> None:
    colours = {Severity.ERROR: "red", Severity.WARNING: "yellow"}
    lines = _text(program).splitlines() if sys.stdout.isatty() else []
    for diagnostic in found:
        place = click.style(f"{program}:{diagnostic.line}:{diagnostic.column}:", bold=True)
        severity = click.style(f"{diagnostic.severity}:", fg=colours[diagnostic.severity], bold=True)
        chapter = f" (manual: {diagnostic.chapter})" if diagnostic.chapter else ""
        click.echo(f"{place} {severity} {diagnostic.message}{chapter}")
        if lines:  # somebody is looking: show the place
            line = lines[diagnostic.line - 1].expandtabs(1)
            click.echo(f"    {line}\n    {' ' * (diagnostic.column - 1)}^")


def _summary(errors: int, warnings: int) -> str:
    counts = [(errors, "error"), (warnings, "warning")]
    told = [f"{count} {noun}{'s' * (count != 1)}" for count, noun in counts if count]
    return ", ".join(told) or "nothing wrong"
