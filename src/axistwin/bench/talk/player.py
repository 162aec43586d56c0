"""Play a conversation with the controllers on a bench, in virtual time, up to the first difference.

Time passes only in `+`, in `<` until its last character has been received, and at the end until the characters of the
last `>` have been sent.  A `= clock` after a `<` therefore checks the exact time of the last character.
"""

from collections.abc import Callable, Collection
from contextlib import ExitStack
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from itertools import takewhile

from axistwin.bench import Bench, Controller, endpoints
from axistwin.bench.actions import FAULT_ACTS, Value, act_at, agrees, question, shown
from axistwin.bench.acts import Act, Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.hosts import Host, host_at
from axistwin.bench.talk.conversation import Conversation, write
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.numbers import clipped
from axistwin.core.units import S, to_seconds

PATIENCE_S = 10.0  # Default time that a `<` waits for its next character; a header such as `; patience: 60` changes it.


@dataclass(frozen=True)
class Difference:
    """The first deviation from the conversation."""

    file: str
    line: int
    time_ns: int
    what: str
    expected: str
    got: str

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}" if self.file else f"line {self.line}"
        alike = takewhile(lambda pair: pair[0] == pair[1], zip(self.expected, self.got, strict=False))
        caret = " " * len(list(alike)) + "^"
        return (
            f"{place}: at {self.time_ns / S:.9f} s {self.what}\n"
            f"  expected  {self.expected or '(nothing)'}\n  got       {self.got or '(nothing)'}\n            {caret}"
        )


SECOND = ".rs485"


def open_channels(conversation: Conversation, bench: Bench) -> None:
    """Connect the host to each RS-485 channel that is named.  Raises ProgramError if one does not exist."""
    for act in conversation.acts:
        if act.controller.endswith(SECOND) and act.controller not in bench.lines:
            try:
                bench.port(act.controller)
            except UsageError as error:
                raise ProgramError(message=str(error), file=conversation.file, line=act.line) from None


Played = Callable[[], object]  # Function that plays one line; a `Difference` that it returns ends the conversation.


def play(conversation: Conversation, bench: Bench) -> Difference | None:
    """Play a conversation, and return the first difference from the expected replies, or None.

    Raises ProgramError, before any act, if the bench lacks something that the conversation names.
    """
    open_channels(conversation, bench)
    with ExitStack() as stack:
        player = Player(conversation, bench)
        player.subscribe(stack)
        for act in [player.prepare(act) for act in conversation.acts]:
            if isinstance(difference := act(), Difference):
                return difference
        player.send_all()
        return player.unclaimed_reply()


class Player:
    """Plays the lines of a conversation one by one."""

    def __init__(self, conversation: Conversation, bench: Bench) -> None:
        self.conversation, self.bench, self.codec = conversation, bench, conversation.codec
        self.received: dict[str, bytearray] = {name: bytearray() for name in endpoints.names(bench)}
        self.hosts: dict[str, Host] = {}
        self.patience_s = conversation.seconds_in("patience", PATIENCE_S)

    def subscribe(self, stack: ExitStack) -> None:
        for name, received in self.received.items():
            self.hosts[name] = stack.enter_context(host_at(self.bench, name))
            self.hosts[name].subscribe_received(received.extend)

    def prepare(self, act: Act) -> Played:
        """Return a function that plays one line.  Raises ProgramError for a line that cannot be played."""
        with self.conversation.placing_errors(act):
            played = self._played(act)
        return partial(self._do, act, played) if isinstance(act, Do) else played

    def _do(self, act: Do, played: Played) -> object:
        with self.conversation.placing_errors(act):
            return played()

    def _played(self, act: Act) -> Played:
        match act:
            case Comment():
                return lambda: None
            case Wait():
                return lambda: self.bench.clock.run_to(self.bench.now + act.ns)
            case Say():
                return partial(self.hosts[self._endpoint(act)].write, act.data)
            case Hear():
                return partial(self._hear, act, self._endpoint(act))
            case Do():
                return act_at(self.bench, self._controller_name(act), act.target, act.value)
            case Expect():
                read_value: Callable[[], Value] = lambda: Decimal(self.bench.now) / S  # noqa: E731
                if act.subject != "clock":
                    read_value = question(self._controller(act), act.subject)
                # Report an invalid expected value, e.g. "abc" instead of a number, before the conversation is played.
                agrees(read_value(), act.value)
                return lambda: self._expect(act, read_value())
        raise AssertionError(f"unknown action {act!r}: expected an object from axistwin.bench.acts, e.g. a Wait")

    def _controller_name(self, act: Do) -> str:
        """Return the controller of an action; a fault may name it in its place."""
        if act.controller in self.received or (act.target in FAULT_ACTS and len(self.bench.controllers) != 1):
            return act.controller
        return self._controller(act).name

    def _controller(self, act: Act) -> Controller:
        if act.controller or len(self.bench.controllers) == 1:
            return self.bench[act.controller or next(iter(self.bench.controllers))]
        raise self._unnamed(act, self.bench.controllers)

    def _endpoint(self, act: Act) -> str:
        if act.controller:
            if act.controller not in self.received:
                raise ProgramError(f"unknown controller {act.controller!r}: expected one of {', '.join(self.received)}")
            return act.controller
        if len(self.received) == 1 or len(self.bench.controllers) == 1:
            return next(iter(self.received))
        raise self._unnamed(act, self.received)

    def _unnamed(self, act: Act, known: Collection[str]) -> ProgramError:
        action = clipped(write([act], self.codec).strip())
        controllers, name = ", ".join(known), next(iter(known), "if1")
        return ProgramError(
            f"missing controller name before `{action}`: expected one of {controllers}, e.g. `{name}: {action}`"
        )

    def _hear(self, act: Hear, name: str) -> Difference | None:
        received = self.received[name]
        if not act.data:
            return self._difference(act.line, "unexpected reply", b"", bytes(received)) if received else None
        while len(received) < len(act.data) and act.data.startswith(received):
            if not self._wait_for_more(received, self.patience_s):
                what = f"the reply is incomplete after {self.patience_s:g} s of silence"
                return self._difference(act.line, what, act.data, bytes(received))
        if not received.startswith(act.data):
            return self._wrong_reply(act, name, received)
        del received[: len(act.data)]
        return None

    def _wait_for_more(self, received: bytearray, seconds: float) -> bool:
        before = len(received)
        return self.bench.run_until(lambda: len(received) > before, seconds)

    def _wrong_reply(self, act: Hear, name: str, received: bytearray) -> Difference:
        now_ns = self.bench.now
        pause_s = to_seconds(self.hosts[name].pause_ns)
        while len(received) < len(act.data) + 32 and self._wait_for_more(received, pause_s):
            pass
        return self._difference(act.line, "the reply is different", act.data, bytes(received), now_ns)

    def send_all(self) -> None:
        """Wait until the data of the last `>` lines have been sent, for at most the patience."""
        self.bench.run_until(lambda: not any(host.sending for host in self.hosts.values()), self.patience_s)

    def unclaimed_reply(self) -> Difference | None:
        """Return a difference if characters were received that no `<` line expects; otherwise None."""
        last = self.conversation.acts[-1].line if self.conversation.acts else 0
        found = next((bytes(received) for received in self.received.values() if received), None)
        return None if found is None else self._difference(last, "unexpected reply", b"", found)

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
