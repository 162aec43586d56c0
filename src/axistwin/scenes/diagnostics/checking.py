"""Check programs of every kind, for `axistwin check` and the language server.

This module converts a program to characters with their lines and columns.  The checker of a family finds the errors.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import takewhile
from pathlib import Path

from axistwin.bench import product, rules
from axistwin.bench.acts import Act, Comment, Do, Say
from axistwin.bench.codec import CHARACTERS, Codec, codec_of
from axistwin.bench.programs.command_lines import command_line, named_keyboard
from axistwin.bench.programs.hex_commands import command_string
from axistwin.bench.programs.running import check_headers, form_of, unknown_kind
from axistwin.bench.programs.stored_programs import read_source
from axistwin.bench.talk import conversation
from axistwin.bench.talk.conversation import named_model, parse_line
from axistwin.bench.typography import as_ascii
from axistwin.controllers.diagnostics import Checker, Diagnostic, Edit, Fix, Sent, Session, Severity
from axistwin.controllers.product import Product
from axistwin.controllers.registry import OURS
from axistwin.core.errors import PlacedError, ProgramError, UsageError
from axistwin.scenes.diagnostics.typed import typographic

MODELS = {".if1": "if1", ".181x": "1811", ".sms": "smartmotor"}  # Default model for a program, by its suffix.
PROGRAMS = (".talk", *MODELS)
SCENE = ".toml"


def kind_of(program: Path, made: Product | None = None) -> str:
    return form_of(program, made.model if made else "")


def check_kind(program: Path, made: Product) -> None:
    """Raise UsageError if a program is for another family; a conversation is for any family."""
    kind = kind_of(program)
    if kind in MODELS and kind != made.suffix:
        own_models = " or ".join(name for name in OURS if product(name).suffix == kind)
        raise UsageError(
            f"{program} is a program for {own_models}, not for {made.model}: choose another program or another model"
        )
    if not made.suffix and kind_of(program, made) not in (".talk", SCENE):
        raise unknown_kind(program, made.model)


def product_for(suffix: str, text: str) -> Product:
    """Return the model of the header `; model:` or of the file suffix.  Raises UsageError if it is unknown."""
    model = named_model(text.splitlines()) or MODELS.get(suffix, "")
    if not model:
        raise UsageError(
            "unknown controller model: expected the argument MODEL, or a line in the file, e.g. '; model: if1'"
        )
    return product(model)


def diagnose(program: Path, checker: Checker, codec: Codec = CHARACTERS) -> list[Diagnostic]:
    """Return all errors and warnings of a program file.

    Raises UsageError if the file cannot be read, and ProgramError if the file is not text.
    """
    return _diagnose(load(program), kind_of(program), checker, codec, str(program))


def diagnose_text(text: str, suffix: str, made: Product, file: str = "") -> list[Diagnostic]:
    """Return all errors and warnings of a program text.  Raises UsageError if the model has no checker."""
    if made.check is None:
        raise UsageError(f"programs for {made.model} cannot be checked: expected a model with a checker, e.g. if1")
    text = text.partition(conversation.END_OF_FILE)[0]
    found = _diagnose(text, suffix, made.check, codec_of(made), file)
    return sorted([*found, *_headers(text, made)]) if suffix == ".talk" else found


@dataclass(frozen=True)
class HostProgram:
    """The data that a program sends to one endpoint, with the errors and warnings in these data."""

    file: str
    endpoint: str
    suffix: str
    sessions: Sequence[Session]
    found: Sequence[Diagnostic]

    @property
    def errors(self) -> list[Diagnostic]:
        return [each for each in self.found if each.severity is Severity.ERROR]


def host_programs(
    text: str, suffix: str, endpoint: str, models: Mapping[str, Product], file: str = ""
) -> tuple[list[HostProgram], list[Diagnostic]]:
    """Return the data that a host program sends to each endpoint, e.g. to each controller.

    Also returns the diagnostics of unreadable lines.  `endpoint`: the endpoint of lines that do not name one; `models`:
    the product at each endpoint.
    """
    lines, typed = as_ascii(text).splitlines(), list(typographic(text.splitlines(), suffix))
    model = named_model(lines) if suffix == ".talk" else ""
    made = product(model) if model else models.get(endpoint)
    codec = CHARACTERS if made is None else codec_of(made)
    acts, unread = read_acts(lines, suffix, codec, file)
    if suffix == ".talk":
        sent = {name or endpoint: sessions for name, sessions in _by_controller(acts, lines, codec).items()}
    else:
        (only,) = sessions(acts, lines, suffix, codec)
        sent = {endpoint: only}
    programs = [
        HostProgram(file, name, suffix, listed, [*checker(listed), *(typed if suffix == ".sms" else ())])
        for name, listed in sent.items()
        if name in models and (checker := models[name].check) is not None
    ]
    return programs, unread if suffix == ".sms" and programs else [*unread, *typed]


def diagnose_named(
    text: str, suffix: str, endpoint: str, models: Mapping[str, Product], file: str = ""
) -> list[Diagnostic]:
    """Return the problems of a program that is sent to `endpoint`; a conversation may name others."""
    sent, unread = host_programs(text, suffix, endpoint, models, file)
    return sorted([*unread, *(found for each in sent for found in each.found)])


def _headers(text: str, made: Product) -> Iterator[Diagnostic]:
    lines = takewhile(lambda line: not line.strip() or line.lstrip().startswith(";"), text.splitlines())
    head = [(number, line) for number, line in enumerate(lines, start=1) if line.strip()]
    acts = (Comment(line.strip()[1:].strip(), line=number) for number, line in head)
    try:
        check_headers(conversation.Conversation(tuple(acts)), made.model)
    except ProgramError as error:
        yield as_diagnostic(error)


def load(program: Path, made: Product | None = None) -> str:
    """Return the text of a program file.  Raises UsageError or ProgramError if the file cannot be read."""
    return read_source(program) if kind_of(program, made) == ".sms" else conversation.load_text(program)


def as_diagnostic(error: PlacedError) -> Diagnostic:
    line, column = error.line or 1, error.column or 1
    end = column + error.width
    fix = None
    if error.instead:
        fix = Fix(f"write {error.instead}", (Edit(line, column, line, end, error.instead),), error.sure)
    code = error.code or rules.UNREADABLE.code
    return Diagnostic(line, column, Severity.ERROR, error.message, "", code, line, end, fix)


def _diagnose(text: str, suffix: str, checker: Checker, codec: Codec, file: str) -> list[Diagnostic]:
    lines = as_ascii(text).splitlines()
    acts, unread = read_acts(lines, suffix, codec, file)
    hosts = sessions(acts, lines, suffix, codec)
    typed = typographic(text.splitlines(), suffix)
    return sorted([*unread, *typed, *(diagnostic for each in hosts for diagnostic in checker(each))])


def read_acts(lines: Sequence[str], suffix: str, codec: Codec, file: str = "") -> tuple[list[Act], list[Diagnostic]]:
    acts: list[Act] = []
    unread: list[Diagnostic] = []
    read = _reader(suffix, codec, file, lines)
    for number, line in enumerate(lines, start=1):
        try:
            act = read(line, number, file)
        except ProgramError as error:
            unread.append(as_diagnostic(error.at(file, number, error.column or 1)))
        else:
            acts += [act] if act is not None else []
    return acts, unread


def _reader(suffix: str, codec: Codec, file: str, lines: Sequence[str]) -> Callable[[str, int, str], Act | None]:
    match suffix:
        case ".talk":
            return lambda line, number, file: parse_line(line, number, file, codec) if line.strip() else None
        case ".181x":
            return partial(command_string, read=codec.read)
        case ".if1":
            return partial(command_line, keyboard=named_keyboard(lines))
        case ".sms":
            # A SmartMotor program file contains no actions of the operator, e.g. `!input1 high`.
            return lambda line, number, file: None
    raise unknown_kind(path=Path(file))


def sessions(acts: Iterable[Act], lines: Sequence[str], suffix: str, codec: Codec) -> Iterable[Sequence[Session]]:
    match suffix:
        case ".talk":
            return _by_controller(acts, lines, codec).values()
        case ".181x":
            return _typed(acts, lambda act: _sent(act, codec.places(lines[act.line - 1].partition(";")[0].rstrip())))
        case ".sms":
            return _stored(lines)
        case _:
            return _typed(acts, _line)


@dataclass
class _SentData:
    sessions: list[Session] = field(default_factory=list)
    characters: list[Sent] = field(default_factory=list)
    initialised: bool = False

    def switch_off(self) -> None:
        self.sessions.append(Session(tuple(self.characters), self.initialised))
        self.characters, self.initialised = [], False


def _by_controller(acts: Iterable[Act], lines: Sequence[str], codec: Codec) -> dict[str, Sequence[Session]]:
    hosts: dict[str, _SentData] = {}
    for act in acts:
        host = hosts.setdefault(act.controller, _SentData())
        if isinstance(act, Say):
            line = lines[act.line - 1].rstrip()
            begin = re.compile(r"[^>]*>\s*").match(line)
            assert begin is not None
            host.characters += _sent(act, codec.places(line[begin.end() :]), begin.end())
        _power(act, host)
    for host in hosts.values():
        host.switch_off()
    return {name: host.sessions for name, host in hosts.items()}


def _typed(acts: Iterable[Act], sent: Callable[[Say], Iterable[Sent]]) -> Iterator[Sequence[Session]]:
    host = _SentData(initialised=True)
    for act in acts:
        if isinstance(act, Say):
            host.characters += sent(act)
        _power(act, host)
    host.switch_off()
    yield host.sessions


def _stored(lines: Iterable[str]) -> Iterator[Sequence[Session]]:
    typed = (_characters(map(ord, line.expandtabs(1)), number) for number, line in enumerate(lines, start=1))
    yield [Session(tuple(sent for line in typed for sent in line), stored=True)]


def _sent(act: Say, places: Iterable[tuple[int, int]], begin: int = 0) -> Iterator[Sent]:
    pairs = zip(act.data, places, strict=True)
    return (Sent(byte, act.line, begin + column + 1, width) for byte, (column, width) in pairs)


def _line(act: Say) -> Iterator[Sent]:
    return _characters(act.data, act.line)


def _characters(codes: Iterable[int], line: int) -> Iterator[Sent]:
    column = 0
    for column, code in enumerate(codes, start=1):
        yield Sent(code, line, column)
    yield Sent(ord("\r"), line, column + 1, 0)


def _power(act: Act, host: _SentData) -> None:
    if isinstance(act, Do) and act.target == "power" and act.value in ("off", "low"):
        host.switch_off()
