"""Send the lines of a `.181x` file to an 1810 or 1811.

A line is a command, in hex (`33 00 00 61 A8`) or by its name (`go_relative 25000`).  A line is sent when the move or
the sequence of the previous line has ended, that is when no event is due, and the board is ready.  After a `+seconds`
line the next line is sent when that time has passed, in any state.  Messages from the board are read at once.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial

from axistwin.bench import Bench, Controller, is_model, product
from axistwin.bench.acts import Act, Do, Say, Wait
from axistwin.bench.controller import on_a_bus
from axistwin.bench.hosts import Host, host_of
from axistwin.bench.programs.command_lines import not_sent, prepared_action, run_until_quiet
from axistwin.bench.talk import conversation
from axistwin.bench.typography import refuse
from axistwin.controllers.product import Language
from axistwin.core.errors import ProgramError

DEFAULT_MODEL = "1811"  # Default model for a program that does not name its model.


def language_of(target: str) -> Language:
    """Return the command language of a model.  If `target` is not a model, the language of an 1811 is returned."""
    made = product(target if is_model(target) else DEFAULT_MODEL)
    if made.language is None:
        raise ProgramError(f"{made.model} cannot execute the hex commands of a .181x file: expected an 1810 or 1811")
    return made.language


def command_strings(text: str, language: Language, file: str = "") -> Iterator[Act]:
    """Return the lines of a `.181x` file: commands as Say, and `+` and `!` lines as acts."""
    acts = (command_string(line, number, file, language.read) for number, line in enumerate(text.splitlines(), start=1))
    return (act for act in acts if act is not None)


def command_string(line: str, number: int, file: str, read: Callable[[str], bytes]) -> Act | None:
    """Parse one line of a `.181x` file, its command by `read`; None if blank or a comment.  Raises ProgramError."""
    text = line.partition(";")[0].rstrip()
    if text.lstrip().startswith(("+", "!")):
        return conversation.parse_line(text, number, file)
    refuse(text, file, number)
    try:
        return Say(read(text), line=number) if text else None
    except ProgramError as error:
        raise error.at(file=file, line=number, column=error.column) from None


def send_commands(bench: Bench, acts: Iterable[Act], deadline_ns: int, file: str = "") -> str | None:
    """Send the commands to the board one by one.  Returns a note if not all commands were sent."""
    controller = _only_board(bench, file)
    with host_of(controller) as host:
        # Read and discard each message on arrival, because an unread message blocks all later messages.
        host.subscribe_received(lambda message: None)
        planned = [(act, _prepared(act, controller, host, file)) for act in acts]
        timed = False
        for act, do in planned:
            pause = isinstance(act, Wait)
            if not (timed or pause or run_until_quiet(bench, deadline_ns)):
                return not_sent(act.line, bench)
            if isinstance(act, Wait):
                bench.clock.run_to(min(bench.now + act.ns, max(deadline_ns, bench.now)))
            do()
            timed = pause
        run_until_quiet(bench, deadline_ns)
    return None


def _prepared(act: Act, controller: Controller, host: Host, file: str) -> Callable[[], object]:
    match act:
        case Say():
            return partial(host.write, act.data)
        case Do():
            return prepared_action(controller, act, file)
    return lambda: None


def _only_board(bench: Bench, file: str) -> Controller:
    boards = [controller for controller in bench.controllers.values() if on_a_bus(controller)]
    if len(boards) != 1:
        raise ProgramError(
            f"the simulation has {len(boards)} boards, but a .181x file needs exactly one 1810 or 1811: "
            "use a .talk file",
            file=file,
        )
    return boards[0]
