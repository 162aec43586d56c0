"""Plays a conversation with the controllers on a bench, in virtual time, up to the first difference.

The one rule about time: it passes in `+`, and in `<` until the last of its characters has been received, and not a
nanosecond longer.  So a `<` need not say when, and a `= clock` behind it says exactly when.
"""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from itertools import takewhile

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.actions import FAULT_ACTS, Value, act_at, agrees, question, shown
from axistwin.bench.acts import Act, Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.codec import Codec
from axistwin.bench.hosts import Host, host_at
from axistwin.conversations.conversation import Conversation
from axistwin.errors import ProgramError, UsageError
from axistwin.units import S, to_seconds

PATIENCE_S = 10.0
"""How long a `<` waits for its next character unless the conversation says otherwise: `; patience: 60`."""


@dataclass(frozen=True)
class Difference:
    """The first thing that was not as the conversation has it."""

    file: str
    line: int
    time_ns: int
    what: str
    expected: str
    got: str

    def __str__(self) -> str:
        """Place, time, and both versions with a caret under the first character that differs."""
        place = f"{self.file}:{self.line}" if self.file else f"line {self.line}"
        alike = takewhile(lambda pair: pair[0] == pair[1], zip(self.expected, self.got, strict=False))
        caret = " " * len(list(alike)) + "^"
        return (
            f"{place}: at {self.time_ns / S:.9f} s {self.what}\n"
            f"  expected  {self.expected or '(nothing)'}\n  got       {self.got or '(nothing)'}\n            {caret}"
        )


SECOND = ".rs485"


def open_channels(conversation: Conversation, bench: Bench) -> None:
    """Connect a host to each second channel that the conversation names (`motor.rs485: > RP`), for all to see.

    Raises ProgramError if there is no such channel.
    """
    for act in conversation.acts:
        if act.controller.endswith(SECOND) and act.controller not in bench.lines:
            try:
                bench.port(act.controller)
            except UsageError as error:
                raise ProgramError(str(error), file=conversation.file, line=act.line) from None


Played = Callable[[], object]
"""Does an act; what it returns is a Difference or means nothing."""


def play(conversation: Conversation, bench: Bench, codec: Codec | None = None) -> Difference | None:
    """Do what the conversation says; returns the first difference, None if there is none.

    Raises ProgramError, before anything is done, if it names what the bench does not have.
    """
    open_channels(conversation, bench)
    with ExitStack() as stack:
        player = Player(conversation, bench, codec or conversation.codec)
        player.listen(stack)
        for act in [player.prepare(act) for act in conversation.acts]:
            if isinstance(difference := act(), Difference):
                return difference
        return player.nothing_left()


class Player:
    """Does the acts of a conversation one by one."""

    def __init__(self, conversation: Conversation, bench: Bench, codec: Codec) -> None:
        self.conversation, self.bench, self.codec = conversation, bench, codec
        self.heard: dict[str, bytearray] = {name: bytearray() for name in endpoints.names(bench)}
        self.hosts: dict[str, Host] = {}
        self.patience_s = self._patience()

    def listen(self, stack: ExitStack) -> None:
        """Hear what is said from now on, for as long as the stack stands."""
        for name, heard in self.heard.items():
            self.hosts[name] = stack.enter_context(host_at(self.bench, name))
            self.hosts[name].hear(heard.extend)

    def prepare(self, act: Act) -> Played:
        """The act as something to call; whatever is wrong with it is found here."""
        with self.conversation.blaming(act):
            played = self._played(act)
        return partial(self._do, act, played) if isinstance(act, Do) else played

    def _do(self, act: Do, played: Played) -> object:
        """There are faults that have no place or time any more when they are to begin."""
        with self.conversation.blaming(act):
            return played()

    def _played(self, act: Act) -> Played:
        match act:
            case Comment():
                return lambda: None
            case Wait():
                return partial(self._wait, act.ns)
            case Say():
                return partial(self.hosts[self._partner(act)].write, act.data)
            case Hear():
                return partial(self._hear, act, self._partner(act))
            case Do():
                return act_at(self.bench, self._whose(act), act.target, act.value)
            case Expect():
                look = self._clock if act.subject == "clock" else question(self._controller(act), act.subject)
                agrees(look(), act.value)  # so that a value that can never be is found now
                return lambda: self._expect(act, look())
        raise AssertionError(act)

    def _whose(self, act: Do) -> str:
        """Whose things it is about; a fault names them itself if need be."""
        if act.controller in self.heard or (act.target in FAULT_ACTS and len(self.bench.controllers) != 1):
            return act.controller
        return self._controller(act).name

    def _controller(self, act: Act) -> Controller:
        if act.controller or len(self.bench.controllers) == 1:
            return self.bench[act.controller or next(iter(self.bench.controllers))]
        names = ", ".join(self.bench.controllers)
        raise ProgramError(f"which controller? Begin the line with its name and a colon: there are {names}")

    def _partner(self, act: Act) -> str:
        """Whom the host talks to."""
        if act.controller:
            if act.controller not in self.heard:
                raise ProgramError(f"no controller {act.controller!r} to talk to: there are {', '.join(self.heard)}")
            return act.controller
        if len(self.heard) == 1 or len(self.bench.controllers) == 1:
            return next(iter(self.heard))
        raise ProgramError(
            f"which controller? Begin the line with its name and a colon: there are {', '.join(self.heard)}"
        )

    def _patience(self) -> float:
        return self.conversation.seconds_in("patience", PATIENCE_S)

    def _clock(self) -> Decimal:
        return Decimal(self.bench.now) / S

    def _wait(self, ns: int) -> None:
        self.bench.clock.run_to(self.bench.now + ns)

    def _hear(self, act: Hear, name: str) -> Difference | None:
        heard = self.heard[name]
        if not act.data:
            return self._unexpected(act.line, heard) if heard else None
        while len(heard) < len(act.data) and act.data.startswith(heard):
            if not self._more(heard, self.patience_s):
                what = f"nothing more has come for {self.patience_s:g} s"
                return self._difference(act.line, what, act.data, bytes(heard))
        if not heard.startswith(act.data):
            return self._something_else(act, name, heard)
        del heard[: len(act.data)]
        return None

    def _more(self, heard: bytearray, seconds: float) -> bool:
        before = len(heard)
        return self.bench.run_until(lambda: len(heard) > before, seconds)

    def _something_else(self, act: Hear, name: str, heard: bytearray) -> Difference:
        """The wrong character has come; let it finish its words, so that one can see what it meant."""
        now_ns = self.bench.now
        pause_s = to_seconds(self.hosts[name].pause_ns)
        while len(heard) < len(act.data) + 32 and self._more(heard, pause_s):
            pass
        return self._difference(act.line, "the controller says something else", act.data, bytes(heard), now_ns)

    def _unexpected(self, line: int, heard: bytearray) -> Difference:
        return self._difference(line, "the controller has said what nobody expected", b"", bytes(heard))

    def nothing_left(self) -> Difference | None:
        """At the end everything that was received must have been told."""
        last = self.conversation.acts[-1].line if self.conversation.acts else 0
        return next((self._unexpected(last, heard) for heard in self.heard.values() if heard), None)

    def _expect(self, act: Expect, value: Value) -> Difference | None:
        if agrees(value, act.value):
            return None
        return Difference(
            self.conversation.file, act.line, self.bench.now, f"{act.subject} is different", act.value, shown(value)
        )

    def _difference(self, line: int, what: str, expected: bytes, got: bytes, time_ns: int | None = None) -> Difference:
        at_ns = self.bench.now if time_ns is None else time_ns
        show = self.codec.show
        return Difference(self.conversation.file, line, at_ns, what, show(expected), show(got))
