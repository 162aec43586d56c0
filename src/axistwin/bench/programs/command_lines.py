"""Send the lines of an `.if1` file to an IF1 or IF2, as an operator at a terminal would.

The initialisation is done first.  A line is sent when the move, the delay or the sequence of the previous line has
ended, that is when no event is due.  A run (`G`) or a wait for an input causes no events and delays no line.  After a
`+seconds` line the next line is sent when that time has passed, in any state; so are all status requests and `!` lines
that follow without a gap.  Characters are sent only while the interface's DTR line is on.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from math import ceil

from axistwin.bench import Bench, Controller, rules
from axistwin.bench.actions import action
from axistwin.bench.acts import Act, Do, Say, Wait
from axistwin.bench.programs.keyboards import KEYBOARDS, NATIONAL, to_codes
from axistwin.bench.talk import conversation
from axistwin.bench.typography import refuse
from axistwin.controllers.digiplan.interface import is_request
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.units import to_seconds
from axistwin.sim.frames import UartFormat

SELF_TEST_S = 1.5  # From power-up until the interface receives; the manual says "approximately 1 second".
PATIENCE_S, ATTEMPTS = 0.5, 20
READY_S = 1.2  # After the format message; by the manual, the first ramp calculation takes "up to 1 second".

_FRAMES = {(7, 1): 1, (7, 2): 2, (8, 1): 5, (8, 2): 6}
_PARITIES = {"N": 1, "O": 3, "E": 4}


def read_command_lines(text: str, file: str = "") -> Iterator[Act]:
    """Yield the acts of an `.if1` file: commands, each without its CR, `+` lines and `!` lines.

    Comments and blank lines are left out.  The characters of a line keep their columns.
    """
    lines = text.splitlines()
    keyboard = named_keyboard(lines)
    for number, line in enumerate(lines, start=1):
        act = command_line(line, number, file, keyboard)
        if act is not None:
            yield act


def command_line(line: str, number: int, file: str = "", keyboard: str = "us") -> Act | None:
    """Parse one line of an `.if1` file, typed on this national keyboard; None if blank.  Raises ProgramError."""
    words = line.partition(";")[0].rstrip()
    if words.lstrip().startswith(("+", "!")):
        return conversation.parse_line(words, number, file)
    return Say(_characters(to_codes(keyboard, words), number, file), line=number) if words else None


def named_keyboard(lines: Iterable[str]) -> str:
    """Return the national keyboard named in the first comments, `; keyboard: germany`, or "us"."""
    for line in lines:
        if line.strip() and not line.lstrip().startswith(";"):
            break
        key, _, name = line.strip("; \t").partition(":")
        if key == "keyboard" and name.strip() in KEYBOARDS:
            return name.strip()
    return "us"


def prepared_action(controller: Controller, act: Do, file: str) -> Callable[[], object]:
    """Return a function that performs an action, e.g. `!input1 high`.  Raises ProgramError if it is invalid."""
    try:
        return action(controller, act.target, act.value)
    except ProgramError as error:
        raise error.at(file=file, line=act.line, column=0) from None


def run_until_quiet(bench: Bench, deadline_ns: int) -> bool:
    """Run the simulation until no planned events are left.  Returns False if `deadline_ns` is reached first."""
    while not bench.clock.quiet:
        due_ns = bench.clock.next_event_ns()
        if due_ns is None or due_ns > deadline_ns:
            bench.clock.run_to(max(deadline_ns, bench.now))
            return False
        bench.clock.step()
    return True


def send_lines(bench: Bench, acts: Iterable[Act], deadline_ns: int, file: str = "") -> str | None:
    """Initialise the interface, and send the program line by line.  Returns a note if not all lines were sent."""
    sender = _LineSender(bench, deadline_ns, file)
    planned = [(act, sender.prepare(act)) for act in acts]
    sender.initialise()
    if bench.now >= deadline_ns and planned:
        return (
            f"no line was sent, as the interface is ready only at {bench.seconds:g} s: "
            f"run longer with --for SECONDS, e.g. --for {ceil(2 * bench.seconds)}"
        )
    timed = True
    for act, do in planned:
        pause = isinstance(act, Wait)
        if not (timed or pause or run_until_quiet(bench, deadline_ns)) or not do():
            return not_sent(act.line, bench)
        timed = pause or (timed and _never_waits(act))
    return None


def _never_waits(act: Act) -> bool:
    """True for status requests and `!` lines, which take effect at once, even during a move, as does the next line."""
    return isinstance(act, Do) or (isinstance(act, Say) and is_request(act.data.decode()))


def not_sent(line: int, bench: Bench) -> str:
    """Return a note that the simulation ended before the program's line `line` was sent."""
    return (
        f"line {line} and later lines were not sent, because an earlier line is not finished at {bench.seconds:g} s: "
        f"write +SECONDS above line {line} to send line {line} at a given time"
    )


class _LineSender:
    def __init__(self, bench: Bench, deadline_ns: int, file: str) -> None:
        self.bench, self.deadline_ns, self.file = bench, deadline_ns, file
        self.controller = self._only_interface()
        self.port = self.controller.serial

    def _only_interface(self) -> Controller:
        interfaces = [c for c in self.bench.controllers.values() if c.product.family == "digiplan"]
        if len(interfaces) != 1:
            raise ProgramError(
                f"the simulation has {len(interfaces)} controllers of the type IF1 or IF2, "
                "but an .if1 file contains commands for exactly one: for several controllers, use a .talk file",
                file=self.file,
            )
        return interfaces[0]

    def prepare(self, act: Act) -> Callable[[], bool]:
        """Return a function that performs one line; it returns False if the deadline comes first."""
        match act:
            case Wait():
                return partial(self._wait, act.ns)
            case Say():
                return partial(self._type, act.data + b"\r")
            case Do():
                return partial(self._do, prepared_action(self.controller, act, self.file))
        raise AssertionError(f"invalid action {act!r}: expected an object of the class Wait, Say or Do")

    def initialise(self) -> None:
        """Send `(` until the interface answers `U`, and then the data format message."""
        wanted = self.port.host.format
        self.port.host.format, message = greeting(wanted)
        self.bench.run(SELF_TEST_S)
        heard = bytearray()
        unsubscribe = self.port.subscribe_received(lambda byte, _: heard.append(byte))
        for _ in range(ATTEMPTS):
            self.port.write(b"(")
            if self.bench.run_until(lambda: heard.endswith(b"U\r"), PATIENCE_S):
                break
        else:
            interface, baud_rate = self.controller.name, wanted.baudrate
            raise ProgramError(
                f"{interface} does not answer '(' at {baud_rate} baud: expected the answer 'U'", file=self.file
            )
        unsubscribe()
        self.port.write(message)
        self.bench.run_until(lambda: not self.port.pending, PATIENCE_S)
        self.bench.run(READY_S)
        self.port.host.format = wanted

    def _wait(self, ns: int) -> bool:
        self.bench.clock.run_to(max(min(self.bench.now + ns, self.deadline_ns), self.bench.now))
        return self.bench.now < self.deadline_ns

    def _do(self, do: Callable[[], object]) -> bool:
        do()
        return True

    def _type(self, line: bytes) -> bool:
        for character in line:
            if not self._free():
                return False
            self.port.write(bytes([character]))
        return True

    def _free(self) -> bool:
        """Run until the interface can receive a character; return False if the deadline comes first."""
        left_s = to_seconds(max(0, self.deadline_ns - self.bench.now))
        return self.bench.run_until(lambda: self.port.dtr and not self.port.pending, left_s)


def _characters(words: str, number: int, file: str) -> bytes:
    refuse(words, file, number)
    if odd := re.search(r"[^ -~\t]", words):
        character, keyboard_hint = odd[0], ""
        if character in NATIONAL:
            keyboard_hint = ": for a national keyboard write, for example, ; keyboard: germany in the first line"
        column, code = odd.start() + 1, rules.NO_ASCII.code
        raise ProgramError(
            f"{character!r} is not an ASCII character{keyboard_hint}", file=file, line=number, column=column, code=code
        )
    return words.replace("\t", " ").encode()


def greeting(wanted: UartFormat) -> tuple[UartFormat, bytes]:
    """Return the line format for the open bracket, and the message that selects the format `wanted`."""
    return replace(wanted, bytesize=8, parity="N", stopbits=2), _format_message(wanted)


def _format_message(line_format: UartFormat) -> bytes:
    try:
        return b"U%d%d\r" % (_FRAMES[line_format.bytesize, int(line_format.stopbits)], _PARITIES[line_format.parity])
    except KeyError:
        raise UsageError(
            f"an IF1 does not support the line format {line_format}: "
            "expected 7 or 8 data bits, parity N, O or E, and 1 or 2 stop bits, e.g. 9600 8N2"
        ) from None
