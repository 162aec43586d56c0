"""Somebody who sends the lines of a `.181x` file to an 1810 or 1811.

A line is a command, in hex (`33 00 00 61 A8`) or by its name (`go_relative 25000`).  It is sent when nothing more is
going to happen by itself, that is when the move or the sequence of the line before is over, and the board takes it;
after a `+seconds` line when that time has passed, whatever is going on.  Messages are read as they come.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial

from axistwin.bench import FAMILIES, Bench, Controller, product
from axistwin.bench.actions import action, on_a_bus
from axistwin.bench.acts import Act, Do, Say, Wait
from axistwin.bench.hosts import Host, host_of
from axistwin.controllers.product import Language
from axistwin.conversations import conversation
from axistwin.errors import ProgramError
from axistwin.programs.command_lines import settle

USUAL = "1811"
"""Whose language a program is in if nothing tells."""


def language_of(target: str) -> Language:
    """The language of a MODEL, or else of an 1811."""
    made = product(target if target.lower() in FAMILIES else USUAL)
    if made.language is None:
        raise ProgramError(f"{made.model} knows no commands in hex: a .181x program is for an 1810 or 1811")
    return made.language


def command_strings(text: str, language: Language, file: str = "") -> Iterator[Act]:
    """The lines of a `.181x` file: commands as Say, and a conversation's `+` and `!` lines."""
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition(";")[0].rstrip()
        if words.lstrip().startswith(("+", "!")):
            yield conversation.parse_line(words, number, file)
        elif words:
            yield Say(_read(words, language, number, file), line=number)


def _read(words: str, language: Language, number: int, file: str) -> bytes:
    try:
        return language.read(words)
    except ProgramError as error:
        raise ProgramError(error.message, file=file, line=number, column=error.column) from None


def send_commands(bench: Bench, acts: Iterable[Act], deadline_ns: int, file: str = "") -> str | None:
    """Send command after command; returns what to tell about lines that were not sent."""
    controller = _only_board(bench, file)
    with host_of(controller) as host:
        host.hear(lambda message: None)  # it is read, so that the next one can come
        planned = [(act, _prepared(act, controller, host, file)) for act in acts]
        timed = False
        for act, do in planned:
            pause = isinstance(act, Wait)
            if not (timed or pause or settle(bench, deadline_ns)):
                return f"line {act.line} and what follows: not done by {bench.seconds:g} s, the work before it goes on"
            if isinstance(act, Wait):
                bench.clock.run_to(min(bench.now + act.ns, max(deadline_ns, bench.now)))
            do()
            timed = pause
        settle(bench, deadline_ns)
    return None


def _prepared(act: Act, controller: Controller, host: Host, file: str) -> Callable[[], object]:
    match act:
        case Say():
            return partial(host.write, act.data)
        case Do():
            try:
                return action(controller, act.target, act.value)
            except ProgramError as error:
                raise ProgramError(error.message, file=file, line=act.line) from None
    return lambda: None


def _only_board(bench: Bench, file: str) -> Controller:
    found = [controller for controller in bench.controllers.values() if on_a_bus(controller)]
    if len(found) != 1:
        raise ProgramError(
            f"commands are sent to one 1810 or 1811, here are {len(found)}: write a conversation (.talk)", file=file
        )
    return found[0]
