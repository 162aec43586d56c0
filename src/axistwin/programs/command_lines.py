"""Somebody at a terminal: types the lines of an `.if1` file to an IF1 or IF2.

The initialisation comes first.  A line is typed when nothing more is going to happen by itself, that is when the move,
the delay or the sequence of the line before is over; a run (`G`) or a wait for an input goes on without anything
happening and holds nothing up.  After a `+seconds` line the next one is typed when that time has passed, whatever is
going on.  The interface's DTR line is honoured.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial

from axistwin.bench import FAMILIES, Bench, Controller, rules
from axistwin.bench.actions import action
from axistwin.bench.acts import Act, Do, Say, Wait
from axistwin.conversations import conversation
from axistwin.errors import ProgramError, UsageError
from axistwin.sim.frames import UartFormat
from axistwin.units import to_seconds

SELF_TEST_S = 1.5
"""The interface listens after "approximately 1 second"."""
PATIENCE_S, ATTEMPTS = 0.5, 20
READY_S = 1.2
"""From the format message on; the first ramp calculation takes "up to 1 second"."""

_FRAMES = {(7, 1): 1, (7, 2): 2, (8, 1): 5, (8, 2): 6}
_PARITIES = {"N": 1, "O": 3, "E": 4}


def command_lines(text: str, file: str = "") -> Iterator[Act]:
    """The lines of an `.if1` file: what is typed as Say, without the CR, and a conversation's `+` and `!` lines.

    Comments and blank lines are left out.  A line's characters stand in the columns in which they stand in the file.
    """
    for number, line in enumerate(text.splitlines(), start=1):
        act = command_line(line, number, file)
        if act is not None:
            yield act


def command_line(line: str, number: int, file: str = "") -> Act | None:
    """One of them; None if there is nothing to do in it.  Raises ProgramError."""
    words = line.partition(";")[0].rstrip()
    if words.lstrip().startswith(("+", "!")):
        return conversation.parse_line(words, number, file)
    return Say(_characters(words, number, file), line=number) if words else None


def settle(bench: Bench, deadline_ns: int) -> bool:
    """Let everything happen that happens by itself; returns whether that was over by `deadline_ns`."""
    while not bench.clock.quiet:
        due_ns = bench.clock.next_event_ns()
        if due_ns is None or due_ns > deadline_ns:
            bench.clock.run_to(max(deadline_ns, bench.now))
            return False
        bench.clock.step()
    return True


def type_lines(bench: Bench, acts: Iterable[Act], deadline_ns: int, file: str = "") -> str | None:
    """Initialise the interface and type line after line; returns what to tell about lines that were not typed."""
    typist = _Typist(bench, deadline_ns, file)
    planned = [(act, typist.prepare(act)) for act in acts]
    typist.initialise()
    if bench.now >= deadline_ns and planned:
        return f"nothing was typed: the interface is ready at {bench.seconds:g} s only"
    timed = True
    for act, do in planned:
        pause = isinstance(act, Wait)
        if not (timed or pause or settle(bench, deadline_ns)) or not do():
            return f"line {act.line} and what follows: not done by {bench.seconds:g} s, the work before it goes on"
        timed = pause
    return None


class _Typist:
    def __init__(self, bench: Bench, deadline_ns: int, file: str) -> None:
        self.bench, self.deadline_ns, self.file = bench, deadline_ns, file
        self.controller = self._only_interface()
        self.port = self.controller.serial

    def _only_interface(self) -> Controller:
        found = [c for c in self.bench.controllers.values() if FAMILIES[c.product.model] == "digiplan"]
        if len(found) != 1:
            raise ProgramError(
                f"command lines are typed at one IF1 or IF2, here are {len(found)}: write a conversation (.talk)",
                file=self.file,
            )
        return found[0]

    def prepare(self, act: Act) -> Callable[[], bool]:
        """The act as something to call, which tells whether it was done in time."""
        match act:
            case Wait():
                return partial(self._wait, act.ns)
            case Say():
                return partial(self._type, act.data + b"\r")
            case Do():
                return partial(self._do, self._action(act))
        raise AssertionError(act)

    def _action(self, act: Do) -> Callable[[], object]:
        try:
            return action(self.controller, act.target, act.value)
        except ProgramError as error:
            raise ProgramError(error.message, file=self.file, line=act.line) from None

    def initialise(self) -> None:
        """Open bracket until it is answered, then the data format that the host is to have."""
        wanted = self.port.host.format
        self.port.host.format, message = greeting(wanted)
        self.bench.run(SELF_TEST_S)
        heard = bytearray()
        deafen = self.port.hear(lambda byte, _: heard.append(byte))
        for _ in range(ATTEMPTS):
            self.port.write(b"(")
            if self.bench.run_until(lambda: heard.endswith(b"U\r"), PATIENCE_S):
                break
        else:
            raise ProgramError(f"{self.controller.name} does not answer ( at {wanted.baudrate} baud", file=self.file)
        deafen()
        self.port.write(message)
        self.bench.run_until(lambda: not self.port.pending, PATIENCE_S)
        self.bench.run(READY_S)
        self.port.host.format = wanted

    def _wait(self, ns: int) -> bool:
        until_ns = min(self.bench.now + ns, self.deadline_ns)
        self.bench.clock.run_to(max(until_ns, self.bench.now))
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
        """Wait until the line is free and the interface wants to hear more."""
        left_s = to_seconds(max(0, self.deadline_ns - self.bench.now))
        return self.bench.run_until(lambda: self.port.dtr and not self.port.pending, left_s)


def _characters(words: str, number: int, file: str) -> bytes:
    if odd := re.search(r"[^ -~\t]", words):
        message = f"{odd[0]!r} is no ASCII character"
        raise ProgramError(message, file=file, line=number, column=odd.start() + 1, code=rules.NO_ASCII.code)
    return words.replace("\t", " ").encode()


def greeting(wanted: UartFormat) -> tuple[UartFormat, bytes]:
    """In which format the host says open bracket, and the message that then brings the interface to the one wanted."""
    return replace(wanted, bytesize=8, parity="N", stopbits=2), _format_message(wanted)


def _format_message(line: UartFormat) -> bytes:
    """`U` with the interface's codes for the host's own format: 8N2 is U61."""
    try:
        return b"U%d%d\r" % (_FRAMES[line.bytesize, int(line.stopbits)], _PARITIES[line.parity])
    except KeyError:
        raise UsageError(
            f"an IF1 knows no format {line}: 7 or 8 data bits, parity N, O or E, 1 or 2 stop bits"
        ) from None
