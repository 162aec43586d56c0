"""Programs that can be run from the command line, told apart by the suffix of their file.

`.talk` is a conversation.  `.if1` are IF1/IF2 command lines as typed at a terminal; the initialisation is done first.
`.181x` are commands for an 1810 or 1811, in hex or by name.  In both `;` starts a comment, and a conversation's
`+seconds` and `! input1 high` lines may stand between them.  `.sms` is the source of a SmartMotor's stored program.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from axistwin.bench import FAMILIES, Bench, product
from axistwin.bench.acts import Act
from axistwin.bench.options import read_options
from axistwin.conversations.conversation import Conversation, load_text, parse
from axistwin.conversations.player import Difference, open_channels, play
from axistwin.errors import UsageError
from axistwin.programs.command_lines import command_lines, settle, type_lines
from axistwin.programs.hex_commands import command_strings, language_of, send_commands
from axistwin.programs.stored_programs import load_source, only_motor, store_program
from axistwin.units import S

BOUND_NS = 3600 * S
"""A program that never ends is watched for so long, unless one says how long."""
STORED_BOUND_NS = 60 * S
"""The same for a motor's stored program: most of them are loops that never end."""


@dataclass(frozen=True)
class Outcome:
    """How a program went: the first difference of a conversation, and what a person should know besides."""

    difference: Difference | None = None
    note: str = ""


@dataclass(frozen=True)
class Program:
    """`perform(bench, until_ns)` it, until it is over if that is None; `options` of the model that it asks for."""

    perform: Callable[[Bench, int | None], Outcome]
    options: tuple[str, ...] = ()
    prepare: Callable[[Bench], object] = lambda bench: None
    """What is done to the bench before anybody looks."""


def load(path: Path, target: str = "") -> Program:
    """The program in a file, for a MODEL or a scene.  Raises ProgramError if it cannot be read."""
    match path.suffix.lower():  # DOS wrote them in capitals
        case ".talk":
            conversation = parse(load_text(path), str(path), model=target)
            prepare = partial(open_channels, conversation)
            return Program(partial(_converse, conversation), options(conversation, target), prepare)
        case ".if1":
            return Program(partial(_type, tuple(command_lines(load_text(path), str(path))), str(path)))
        case ".181x":
            acts = tuple(command_strings(load_text(path), language_of(target), str(path)))
            return Program(partial(_send, acts, str(path)))
        case ".sms":
            source = load_source(path)
            return Program(partial(_run_stored, str(path)), prepare=partial(store_program, source, str(path)))
    raise no_program(path)


def of_itself() -> Program:
    """What a scene does by itself: its hosts, its stored programs, its script."""
    return Program(_live)


def is_stored(path: Path) -> bool:
    """True if the file is the source of a motor's stored program."""
    return path.suffix.lower() == ".sms"


def no_program(path: Path) -> UsageError:
    """What to tell about a file of no known kind."""
    kinds = "name a conversation .talk, command lines .if1, commands for an 1811 .181x, a SmartMotor's source .sms"
    return UsageError(f"{path} is no kind of program: {kinds}")


def options(conversation: Conversation, target: str = "") -> tuple[str, ...]:
    """The `NAME=VALUE` words in its `; options:` and `; line:` headers.  Raises UsageError if `target` cannot be meant.

    A conversation on a serial line is none with a board on a bus, nor the other way round.
    """
    headers = conversation.headers
    of = headers.get("model", "")
    if {of.lower(), target.lower()} <= FAMILIES.keys() and _on_a_line(of) is not _on_a_line(target):
        ways = f"{of} {_reached(of)}, and {target} {_reached(target)}"
        raise UsageError(f"{conversation.file} is of another model: {ways}: name one such as {of}")
    check_headers(conversation, target)
    return (*conversation.words, *_line_of(conversation))


def check_headers(conversation: Conversation, model: str) -> None:
    """Raises ProgramError with the line of a header that cannot be read, or that this model does not take."""
    for key in ("patience", "on-for"):
        conversation.seconds_in(key, 0.0)
    for key, words in (("options", tuple(conversation.words)), ("line", _line_of(conversation))):
        if words and model.lower() in FAMILIES:
            with conversation.blaming_header(key):
                Bench().add(model, **read_options(words))


def _line_of(conversation: Conversation) -> tuple[str, ...]:
    headers = conversation.headers
    return (f"line={headers['line']}",) if "line" in headers else ()


def _on_a_line(model: str) -> bool:
    return product(model).line is not None


def _reached(model: str) -> str:
    return "has a serial line" if _on_a_line(model) else "is on a bus"


def _converse(conversation: Conversation, bench: Bench, until_ns: int | None) -> Outcome:
    difference = play(conversation, bench)
    if until_ns is not None and difference is None:
        bench.clock.run_to(max(until_ns, bench.now))
    return Outcome(difference)


def _type(acts: tuple[Act, ...], file: str, bench: Bench, until_ns: int | None) -> Outcome:
    deadline_ns = BOUND_NS if until_ns is None else until_ns
    return _settled(bench, type_lines(bench, acts, deadline_ns, file), until_ns, deadline_ns)


def _send(acts: tuple[Act, ...], file: str, bench: Bench, until_ns: int | None) -> Outcome:
    deadline_ns = BOUND_NS if until_ns is None else until_ns
    return _settled(bench, send_commands(bench, acts, deadline_ns, file), until_ns, deadline_ns)


def _run_stored(file: str, bench: Bench, until_ns: int | None) -> Outcome:
    """The motor has just been switched on: a word in its first 200 ms keeps it from starting by itself."""
    motor = only_motor(bench, file)
    motor.serial.write(b"RUN\r")
    deadline_ns = STORED_BOUND_NS if until_ns is None else until_ns
    return _settled(bench, None, until_ns, deadline_ns)


def _live(bench: Bench, until_ns: int | None) -> Outcome:
    deadline_ns = bench.agenda_ns + STORED_BOUND_NS if until_ns is None else until_ns
    bench.clock.run_to(min(bench.agenda_ns, deadline_ns))
    return _settled(bench, None, until_ns, deadline_ns)


def _settled(bench: Bench, note: str | None, until_ns: int | None, deadline_ns: int) -> Outcome:
    if until_ns is not None:
        bench.clock.run_to(max(until_ns, bench.now))
    elif not settle(bench, deadline_ns):
        note = note or "it goes on for ever"
        return Outcome(note=f"{note}: stopped after {bench.seconds:g} s, say --for SECONDS for another time")
    elif running := [name for c in bench.controllers.values() for name, axis in c.axes.items() if axis.moving]:
        note = note or f"{' and '.join(running)} still running: say --for SECONDS to see more of it"
    return Outcome(note=note or "")
