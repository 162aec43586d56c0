"""What is wrong with a text of any kind that axistwin reads: the work behind `axistwin check` and the language server.

A family's own checker finds it; here a program becomes characters with places, whatever it is written in.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import takewhile
from pathlib import Path

from axistwin.bench import FAMILIES, product, rules
from axistwin.bench.acts import Act, Comment, Do, Say
from axistwin.bench.codec import CHARACTERS, Codec, codec_of
from axistwin.controllers.diagnostics import Checker, Diagnostic, Edit, Fix, Sent, Session, Severity
from axistwin.controllers.product import Product
from axistwin.conversations import conversation
from axistwin.conversations.conversation import named_model, parse_line
from axistwin.errors import PlacedError, ProgramError, UsageError
from axistwin.programs.command_lines import command_line
from axistwin.programs.hex_commands import command_string
from axistwin.programs.running import check_headers, unknown_kind
from axistwin.programs.stored_programs import load_source

MODELS = {".if1": "if1", ".181x": "1811", ".sms": "smartmotor"}
"""The model that a program is for, if neither the user nor its first comments say another one."""
PROGRAMS = (".talk", *MODELS)
SCENE = ".toml"


def kind_of(program: Path) -> str:
    """Its suffix; DOS wrote them in capitals."""
    return program.suffix.lower()


def check_kind(program: Path, made: Product) -> None:
    """Raises UsageError if it is a kind of program for another family; conversations are for all."""
    meant = FAMILIES[MODELS.get(kind_of(program), made.model)]
    if meant != FAMILIES[made.model]:
        models = " or ".join(name for name, family in FAMILIES.items() if family == meant)
        raise UsageError(f"{program} is a program for {models}, not for {made.model}")


def product_for(suffix: str, text: str) -> Product:
    """The product that a program is for, by its `; model:` or else by its suffix.  Raises UsageError."""
    model = named_model(text.splitlines()) or MODELS.get(suffix, "")
    if not model:
        raise UsageError("this conversation does not say whose it is: give the MODEL, or begin it with '; model: if1'")
    return product(model)


def diagnose(program: Path, checker: Checker, codec: Codec = CHARACTERS) -> list[Diagnostic]:
    """Everything that is wrong with a program file.  Raises UsageError or ProgramError if it is none."""
    return _diagnose(load(program), kind_of(program), checker, codec, str(program))


def errors_in(program: Path, made: Product) -> str:
    """Return a note on the errors of a motor's program, which the motor itself ignores; "" without errors."""
    assert made.check is not None, "a motor's programs can be checked"
    errors = sum(found.severity is Severity.ERROR for found in diagnose(program, made.check))
    return (
        f"{errors} error{'s' * (errors != 1)} in the program: axistwin check {made.model} {program}" if errors else ""
    )


def diagnose_text(text: str, suffix: str, made: Product, file: str = "") -> list[Diagnostic]:
    """Everything that is wrong with the text of a program for this product.  Raises UsageError if it is none."""
    if made.check is None:
        raise UsageError(f"programs for {made.model} cannot be checked")
    found = _diagnose(text, suffix, made.check, codec_of(made), file)
    return sorted([*found, *_headers(text, made)]) if suffix == ".talk" else found


def _headers(text: str, made: Product) -> Iterator[Diagnostic]:
    """The first thing that is wrong with the first comments of a conversation, which `run` refuses."""
    lines = takewhile(lambda line: not line.strip() or line.lstrip().startswith(";"), text.splitlines())
    head = [(number, line) for number, line in enumerate(lines, start=1) if line.strip()]
    acts = (Comment(line.strip()[1:].strip(), line=number) for number, line in head)
    try:
        check_headers(conversation.Conversation(tuple(acts)), made.model)
    except ProgramError as error:
        yield as_diagnostic(error)


def load(program: Path) -> str:
    """Its text.  Of a motor's source, what is no ASCII stands in comments.  Raises UsageError or ProgramError."""
    return load_source(program).decode("ascii") if kind_of(program) == ".sms" else conversation.load_text(program)


def as_diagnostic(error: PlacedError, severity: Severity = Severity.ERROR) -> Diagnostic:
    """A line that could not be read at all."""
    line, column = error.line or 1, error.column or 1
    end = column + error.width
    fix = None
    if error.instead:
        fix = Fix(f"write {error.instead}", (Edit(line, column, line, end, error.instead),), error.sure)
    code = error.code or rules.UNREADABLE.code
    return Diagnostic(line, column, severity, error.message, "", code, line, end, fix)


def _diagnose(text: str, suffix: str, checker: Checker, codec: Codec, file: str) -> list[Diagnostic]:
    lines = text.splitlines()
    acts, unread = read_acts(lines, suffix, codec, file)
    hosts = sessions(acts, lines, suffix, codec)
    return sorted([*unread, *(diagnostic for each in hosts for diagnostic in checker(each))])


def read_acts(lines: Sequence[str], suffix: str, codec: Codec, file: str = "") -> tuple[list[Act], list[Diagnostic]]:
    """The lines that can be read, and what is wrong with the others."""
    acts: list[Act] = []
    unread: list[Diagnostic] = []
    read = _reader(suffix, codec, file)
    for number, line in enumerate(lines, start=1):
        try:
            act = read(line, number, file)
        except ProgramError as error:
            unread.append(as_diagnostic(error.at(file, number, error.column or 1)))
        else:
            acts += [act] if act is not None else []
    return acts, unread


def _reader(suffix: str, codec: Codec, file: str) -> Callable[[str, int, str], Act | None]:
    """What reads a line of such a program."""
    match suffix:
        case ".talk":
            return lambda line, number, file: parse_line(line, number, file, codec) if line.strip() else None
        case ".181x":
            return partial(command_string, read=codec.read)
        case ".if1":
            return command_line
        case ".sms":
            return lambda line, number, _: Say(line.expandtabs(1).encode("ascii", "replace"), line=number)
    raise unknown_kind(Path(file))


def sessions(acts: Iterable[Act], lines: Sequence[str], suffix: str, codec: Codec) -> Iterable[Sequence[Session]]:
    """What is sent to each controller."""
    match suffix:
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

    def say(self, act: Say, places: Iterable[tuple[int, int]], begin: int = 0) -> None:
        """The bytes of `act`, each at its column from `begin` on."""
        self.characters += (
            Sent(byte, act.line, begin + column + 1, width)
            for byte, (column, width) in zip(act.data, places, strict=True)
        )

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
            host.say(act, codec.places(line[begin.end() :]), begin.end())
        _power(act, host)
    for host in hosts.values():
        host.switch_off()
        yield host.sessions


def _typed(acts: Iterable[Act]) -> Iterator[Sequence[Session]]:
    host = _Host(initialised=True)
    for act in acts:
        if isinstance(act, Say):
            host.characters += _line(act)
        _power(act, host)
    host.switch_off()
    yield host.sessions


def _commands(acts: Iterable[Act], lines: Sequence[str], codec: Codec) -> Iterator[Sequence[Session]]:
    """Commands for a board on a bus, one per line."""
    host = _Host(initialised=True)
    for act in acts:
        if isinstance(act, Say):
            host.say(act, codec.places(lines[act.line - 1].partition(";")[0].rstrip()))
        _power(act, host)
    host.switch_off()
    yield host.sessions


def _stored(acts: Iterable[Act]) -> Iterator[Sequence[Session]]:
    """A motor's source: all its characters, comments too."""
    yield [Session(tuple(sent for act in acts if isinstance(act, Say) for sent in _line(act)), stored=True)]


def _line(act: Say) -> Iterator[Sent]:
    """A line of characters, ended by a CR that is behind its last one and takes up no column."""
    yield from (Sent(byte, act.line, column) for column, byte in enumerate(act.data, start=1))
    yield Sent(ord("\r"), act.line, len(act.data) + 1, 0)


def _power(act: Act, host: _Host) -> None:
    if isinstance(act, Do) and act.target == "power" and act.value in ("off", "low"):
        host.switch_off()
