"""Compare a recorded conversation with a virtual controller: differences in bytes and in time.

The conversation is played to its end.  The virtual host keeps the recorded delay between each answer and the next act
of the host, so differences in time do not add up.  The time of an answer is measured from the last act of the host to
the end of the last character of the answer.  A difference in time is *twin - hardware*.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

from axistwin.bench import Bench
from axistwin.bench.actions import Value, agrees, level_name, shown
from axistwin.bench.acts import Act, Comment, Do, Expect, Hear, Say, Wait
from axistwin.bench.talk.conversation import Conversation, write
from axistwin.bench.talk.player import Difference, Player, open_channels
from axistwin.core.errors import ProgramError
from axistwin.core.numbers import NumberError, decimal, shortened
from axistwin.core.units import MS, S, to_ns, to_seconds
from axistwin.sim.pins import Pin

PATIENCE_S = 2.0  # Default for the accepted delay of the twin relative to the hardware.
TERMINATORS = (b"\r", b"\n")
LINES = ("dtr", "rts")


@dataclass(frozen=True)
class Compared:
    """One compared action of the controller; times are relative to the host's last action, None if unknown."""

    line: int  # Line number in the file; 0 for an action of the twin that is not in the file.
    after: str  # The host's last action before it, as a line of the conversation.
    expected: str
    got: str
    hardware_ns: int | None
    twin_ns: int | None

    @property
    def same(self) -> bool:
        """True if the action of the emulated controller equals the recorded action of the real controller."""
        return self.expected == self.got

    @property
    def later_ns(self) -> int | None:
        """Delay of the twin relative to the hardware; None if unknown."""
        if not self.same or self.hardware_ns is None or self.twin_ns is None:
            return None
        return self.twin_ns - self.hardware_ns


@dataclass(frozen=True)
class Comparison:
    """All actions of the emulated controller, compared with the recorded actions of the real controller."""

    acts: tuple[Compared, ...]

    @property
    def different(self) -> tuple[Compared, ...]:
        return tuple(act for act in self.acts if not act.same)

    @property
    def timed(self) -> list[tuple[int, Compared]]:
        """Pairs of the twin's delay in ns and its action, the smallest delay first."""
        return sorted(((act.later_ns, act) for act in self.acts if act.later_ns is not None), key=lambda pair: pair[0])

    @property
    def median_ns(self) -> int | None:
        """Median delay of the emulated controller relative to the real controller, in ns."""
        timed = self.timed
        return timed[len(timed) // 2][0] if timed else None

    @property
    def worst(self) -> Compared | None:
        return max(self.timed, key=lambda pair: abs(pair[0]))[1] if self.timed else None


def compare(conversation: Conversation, bench: Bench, patience_s: float = PATIENCE_S) -> Comparison:
    """Play a conversation to its end, even after differences.  Raises ProgramError for a name that the bench lacks."""
    open_channels(conversation, bench)
    with ExitStack() as stack:
        comparer = _Comparer(conversation, bench, to_ns(patience_s))
        comparer.subscribe(stack)
        for act in [comparer.prepare(act) for act in conversation.acts]:
            act()
        comparer.note_rest()
    return Comparison(tuple(comparer.found))


def recorded_times(acts: Iterable[Act]) -> Iterator[int | None]:
    """Yield the end of each recorded action, from `= clock` lines; None if it is unknown.

    After an answer without such a line, times are unknown until the next one.
    """
    acts = tuple(acts)
    now_ns: int | None = 0
    for act, following in pairwise((*acts, Comment())):
        if isinstance(act, Wait) and now_ns is not None:
            now_ns += act.ns
        elif isinstance(act, Hear):
            now_ns = _clock(following)
        elif isinstance(act, Expect) and act.subject == "clock":
            now_ns = _clock(act)
        yield now_ns


def _clock(act: Act) -> int | None:
    if not isinstance(act, Expect) or act.subject != "clock":
        return None
    try:
        return round(decimal(act.value) * S)
    except NumberError:
        raise ProgramError(f"invalid time {shortened(act.value)}: expected seconds, e.g. 0.25", line=act.line) from None


class _Comparer(Player):
    def __init__(self, conversation: Conversation, bench: Bench, patience_ns: int) -> None:
        super().__init__(conversation, bench)
        self.found: list[Compared] = []
        self._patience_ns = patience_ns
        self._times: dict[str, deque[int]] = {name: deque() for name in self.received}
        self._levels: dict[tuple[str, str], deque[tuple[int, bool]]] = {}
        try:
            times = list(recorded_times(conversation.acts))
        except ProgramError as error:
            raise error.at(file=conversation.file, line=error.line, column=0) from None
        self._recorded = dict(zip(map(id, conversation.acts), times, strict=True))
        self._after = ""
        self._after_recorded_ns: int | None = 0
        self._after_ns = bench.now
        self._last_recorded_ns: int | None = 0

    def subscribe(self, stack: ExitStack) -> None:
        super().subscribe(stack)
        for name, when in self._times.items():
            stack.callback(self.hosts[name].subscribe_received(partial(self._note_times, when)))
            if name in self.bench.ports and self.bench.ports[name].handshake:
                self._subscribe_lines(name, stack)

    def _subscribe_lines(self, name: str, stack: ExitStack) -> None:
        for subject in LINES:
            changes = self._levels[name, subject] = deque()
            stack.callback(self._line(name, subject).subscribe(partial(self._note_level, changes)))

    def _line(self, name: str, subject: str) -> Pin:
        port = self.bench.ports[name]
        return port.dtr_line if subject == "dtr" else port.rts_line

    def _note_times(self, when: deque[int], data: bytes) -> None:
        when.extend([self.bench.now] * len(data))

    def _note_level(self, changes: deque[tuple[int, bool]], pin: Pin) -> None:
        changes.append((self.bench.now, pin.level))

    def _played(self, act: Act) -> "partial[None]":
        return partial(self._pass, act) if self._is_skipped(act) else partial(self._do, act, super()._played(act))

    def _is_skipped(self, act: Act) -> bool:
        """True for a `= clock` line, which `recorded_times` reads, and for a control line that the twin lacks."""
        if isinstance(act, Expect) and act.subject == "clock":
            return True
        subject = act.target if isinstance(act, Do) else act.subject if isinstance(act, Expect) else ""
        return subject in LINES and (self._endpoint(act), subject) not in self._levels

    def _do(self, act: Act, do: Callable[[], object]) -> None:
        if isinstance(act, Say | Do):
            self._after = write((act,), self.codec).strip()
            self._after_recorded_ns, self._after_ns = self._recorded[id(act)], self.bench.now
        do()
        self._pass(act)

    def _pass(self, act: Act) -> None:
        self._last_recorded_ns = self._recorded[id(act)]

    def _hear(self, act: Hear, name: str) -> Difference | None:
        received, deadline_ns = self.received[name], self._deadline_ns(act)
        while len(received) < len(act.data) and act.data.startswith(received):
            if not self._wait_for_more(received, to_seconds(deadline_ns - self.bench.now)):
                break
        count = len(act.data) if received.startswith(act.data) and act.data else self._different_reply_length(act, name)
        got, time_ns = self._take(name, count)
        self._note(act, self.codec.show(act.data), self.codec.show(got), time_ns)
        return None

    def _different_reply_length(self, act: Hear, name: str) -> int:
        """Return how many received bytes belong to this line: up to the expected text, or one message."""
        received, pause_s = self.received[name], to_seconds(self.hosts[name].pause_ns)
        while received and len(received) < len(act.data) + 32 and self._wait_for_more(received, pause_s):
            pass
        at = received.find(act.data) if act.data else -1
        if at >= 0:
            return at + len(act.data)
        if act.data.endswith(TERMINATORS):
            return min(
                (n + 1 for n, byte in enumerate(received) if bytes([byte]) in TERMINATORS), default=len(received)
            )
        return len(received)

    def _take(self, name: str, count: int) -> tuple[bytes, int | None]:
        got, when = bytes(self.received[name][:count]), self._times[name]
        del self.received[name][:count]
        times = [when.popleft() for _ in range(count)]
        return got, times[-1] if times else None

    def _expect(self, act: Expect, value: Value) -> Difference | None:
        if act.subject in LINES:
            self._expect_line(act)
        else:
            got = act.value if agrees(value, act.value) else shown(value)
            self._note(act, f"{act.subject} {act.value}", f"{act.subject} {got}", None)
        return None

    def _expect_line(self, act: Expect) -> None:
        """Wait until a control line has the expected level, and record the result.

        The change must follow the host's last action: a recording samples the lines, and may miss changes before it.
        Of a line that has the level already, the time of the hardware's change is unknown.
        """
        name, wanted = self._endpoint(act), f"{act.subject} {act.value}"
        changes, deadline_ns = self._levels[name, act.subject], self._deadline_ns(act)
        while changes and changes[0][0] < self._after_ns:
            changes.popleft()
        if not changes and agrees(self._line(name, act.subject).level, act.value):
            self._note(act, wanted, wanted, None)
            return
        left_s = to_seconds(max(0, deadline_ns - self.bench.now))
        self.bench.run_until(lambda: any(agrees(level, act.value) for _, level in changes), left_s)
        while len(changes) > 1 and not agrees(changes[0][1], act.value):
            changes.popleft()
        time_ns, level = changes.popleft() if changes else (None, None)
        got = "" if level is None else f"{act.subject} {level_name(level)}"
        self._note(act, wanted, got, time_ns)

    def _deadline_ns(self, act: Act) -> int:
        then_ns, before_ns = self._recorded[id(act)], self._last_recorded_ns
        gap_ns = to_ns(self.patience_s) if then_ns is None or before_ns is None else max(0, then_ns - before_ns)
        return self.bench.now + gap_ns + self._patience_ns

    def _note(self, act: Act, expected: str, got: str, time_ns: int | None) -> None:
        then_ns, after_ns = self._recorded[id(act)], self._after_recorded_ns
        hardware_ns = None if then_ns is None or after_ns is None else then_ns - after_ns
        twin_ns = None if time_ns is None else time_ns - self._after_ns
        self.found.append(Compared(act.line, self._after, expected, got, hardware_ns, twin_ns))

    def note_rest(self) -> None:
        self.bench.run(to_seconds(20 * MS))
        for name, received in self.received.items():
            if received:
                got, time_ns = self._take(name, len(received))
                twin_ns = None if time_ns is None else time_ns - self._after_ns
                self.found.append(Compared(0, self._after, "", self.codec.show(got), None, twin_ns))
