"""Programs that can be run from the command line; the suffix of the file gives the kind.

`.talk` is a conversation.  `.if1` has IF1/IF2 command lines as typed at a terminal; the initialisation is done first.
`.181x` has commands for an 1810 or 1811, in hex or by name.  In both, `;` starts a comment, and the `+seconds` and
`! input1 high` lines of a conversation are allowed.  `.sms` is the source of a SmartMotor's stored program.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from axistwin.bench import Bench, is_model, product
from axistwin.bench.acts import Act
from axistwin.bench.options import read_options
from axistwin.bench.programs.command_lines import read_command_lines, run_until_quiet, send_lines
from axistwin.bench.programs.hex_commands import command_strings, language_of, send_commands
from axistwin.bench.programs.stored_programs import load_source, only_motor, store_program
from axistwin.bench.talk.conversation import Conversation, is_conversation, load_text, parse
from axistwin.bench.talk.player import Difference, open_channels, play
from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.storage import STANDARD_INPUT
from axistwin.core.units import S

OWN = (".if1", ".181x", ".sms")  # Suffixes of the families' own programs.
COMPILED = ".smx"

BOUND_NS = 3600 * S  # Longest virtual time of a run for which no time is given.
Send = Callable[[Bench, Iterable[Act], int, str], str | None]
STORED_BOUND_NS = 60 * S  # Longest virtual time of a motor's stored program; most of these programs are endless loops.


@dataclass(frozen=True)
class Outcome:
    """The result of running a program file.

    `difference`: the first difference from the conversation in the file.  `note`: a note for the user.
    """

    difference: Difference | None = None
    note: str = ""


@dataclass(frozen=True)
class Program:
    """A loaded program.  `perform(bench, until_ns)` runs the program; None: to its end."""

    perform: Callable[[Bench, int | None], Outcome]
    options: tuple[str, ...] = ()  # Options of the model for this program.
    prepare: Callable[[Bench], object] = lambda bench: None  # Called before observers are connected.


def load(path: Path, target: str = "") -> Program:
    """Load a program for the model or scene `target`.  Raises ProgramError if it cannot be read."""
    match form_of(path, target):
        case ".talk":
            conversation = parse(load_text(path), str(path), model=target)
            prepare = partial(open_channels, conversation)
            return Program(partial(_play, conversation), options(conversation, target), prepare)
        case ".if1":
            return Program(partial(_send, send_lines, tuple(read_command_lines(load_text(path), str(path))), str(path)))
        case ".181x":
            acts = tuple(command_strings(load_text(path), language_of(target), str(path)))
            return Program(partial(_send, send_commands, acts, str(path)))
        case ".sms":
            source = load_source(path)
            return Program(partial(_run_stored, str(path)), prepare=partial(store_program, source, str(path)))
    raise unknown_kind(path, target)


def form_of(path: Path, model: str = "") -> str:
    """Return the suffix that says how a program is read: its own, in lower case, or that of the model's programs.

    A conversation is recognised by its lines, too.  Raises UsageError for a compiled program of a SmartMotor.
    """
    suffix = path.suffix.lower()  # DOS writes suffixes in capitals
    if suffix == COMPILED:
        raise UsageError(f"{path} is a compiled SmartMotor program: expected its source, a .sms file")
    if suffix in (*OWN, ".talk", ".toml"):
        return suffix
    talk = (path is STANDARD_INPUT or path.is_file()) and is_conversation(_text(path).splitlines())
    own = product(model).suffix if is_model(model) and not talk else ""
    return ".talk" if talk else own or suffix


def _text(path: Path) -> str:
    try:
        return load_text(path)
    except AxistwinError:
        return ""


def scene_program() -> Program:
    return Program(_run_scene)


def unknown_kind(path: Path, model: str = "") -> UsageError:
    if is_model(model) and not product(model).suffix:
        return UsageError(f"{path}: unknown kind of program: expected a conversation for {model}, e.g. moves.talk")
    kinds = (
        "expected .talk (conversation), .if1 (command lines), .181x (commands for an 1811) or .sms (SmartMotor source)"
    )
    return UsageError(f"{path}: unknown kind of program: {kinds}")


def options(conversation: Conversation, target: str = "") -> tuple[str, ...]:
    """Return the options in the headers `; options:` and `; line:` of a conversation, as `NAME=VALUE`.

    Raises UsageError if the conversation is for a serial line and `target` is on a bus, or the other way round.
    """
    model = conversation.headers.get("model", "")
    if is_model(model) and is_model(target) and _on_a_line(model) is not _on_a_line(target):
        bus_or_line = "a serial line" if _on_a_line(model) else "a bus"
        file = conversation.file
        raise UsageError(f"{file} cannot run on {target}: expected a controller on {bus_or_line}, e.g. {model}")
    check_headers(conversation, target)
    return (*conversation.option_words, *_line_of(conversation))


def check_headers(conversation: Conversation, model: str) -> None:
    """Raise ProgramError with the line of a header that cannot be read, or that this model does not accept."""
    for key in ("patience", "on-for"):
        conversation.seconds_in(key, 0.0)
    for key, words in (("options", tuple(conversation.option_words)), ("line", _line_of(conversation))):
        if words and is_model(model):
            with conversation.placing_errors_at_header(key):
                Bench().add(model, **read_options(words))


def _line_of(conversation: Conversation) -> tuple[str, ...]:
    headers = conversation.headers
    return (f"line={headers['line']}",) if "line" in headers else ()


def _on_a_line(model: str) -> bool:
    return product(model).line is not None


def _play(conversation: Conversation, bench: Bench, until_ns: int | None) -> Outcome:
    difference = play(conversation, bench)
    if until_ns is not None and difference is None:
        bench.clock.run_to(max(until_ns, bench.now))
    return Outcome(difference)


def _send(send: Send, acts: tuple[Act, ...], file: str, bench: Bench, until_ns: int | None) -> Outcome:
    deadline_ns = BOUND_NS if until_ns is None else until_ns
    return _finish_run(bench, send(bench, acts, deadline_ns, file), until_ns, deadline_ns)


def _run_stored(file: str, bench: Bench, until_ns: int | None) -> Outcome:
    """Run the stored program by RUN; characters in the first 200 ms after power-up prevent the automatic start."""
    only_motor(bench, file).serial.write(b"RUN\r")
    deadline_ns = STORED_BOUND_NS if until_ns is None else until_ns
    return _finish_run(bench, None, until_ns, deadline_ns)


def _run_scene(bench: Bench, until_ns: int | None) -> Outcome:
    deadline_ns = bench.agenda_ns + STORED_BOUND_NS if until_ns is None else until_ns
    bench.clock.run_to(min(bench.agenda_ns, deadline_ns))
    return _finish_run(bench, None, until_ns, deadline_ns)


def _finish_run(bench: Bench, note: str | None, until_ns: int | None, deadline_ns: int) -> Outcome:
    if until_ns is not None:
        bench.clock.run_to(max(until_ns, bench.now))
    elif not run_until_quiet(bench, deadline_ns):
        note = note or "the program does not end"
        return Outcome(note=f"{note}: stopped after {bench.seconds:g} s, set another time with --for SECONDS")
    elif running := [name for c in bench.controllers.values() for name, axis in c.axes.items() if axis.moving]:
        note = note or f"{' and '.join(running)} still running: run longer with --for SECONDS"
    return Outcome(note=note or "")
