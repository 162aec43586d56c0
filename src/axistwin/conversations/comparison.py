"""A recorded conversation played to its end with a virtual controller: what differs in bytes, by how much in time.

The recorded host acts as it did, and as hosts do: after an answer it goes on when it went on after that answer.  So a
difference in time does not add up.  The time of an answer counts from the last thing that the host had done before it
until its last character had come, in the recording and here; the difference is *twin - hardware*.
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
from axistwin.bench.codec import Codec
from axistwin.conversations.conversation import Conversation, write
from axistwin.conversations.player import Difference, Player, open_channels
from axistwin.errors import ProgramError
from axistwin.numbers import NumberError, decimal
from axistwin.sim.pins import Pin
from axistwin.units import MS, S, to_ns, to_seconds

PATIENCE_S = 2.0
"""How much later than the hardware the twin may answer, unless one says otherwise."""
TERMINATORS = (b"\r", b"\n")
LINES = ("dtr", "rts")


@dataclass(frozen=True)
class Compared:
    """One act of the controller.  Times count from the last act of the host; None: not known, or it did not happen."""

    line: int
    """In the file; 0: not in the file, the twin alone did it."""
    after: str
    """What the host had done, as a line of the conversation."""
    expected: str
    got: str
    hardware_ns: int | None
    twin_ns: int | None

    @property
    def same(self) -> bool:
        """Whether twin and hardware did the same."""
        return self.expected == self.got

    @property
    def later_ns(self) -> int | None:
        """By how much the twin is later."""
        if not self.same or self.hardware_ns is None or self.twin_ns is None:
            return None
        return self.twin_ns - self.hardware_ns


@dataclass(frozen=True)
class Comparison:
    """All that the controller has done."""

    acts: tuple[Compared, ...]

    @property
    def different(self) -> tuple[Compared, ...]:
        """Those that are not the same."""
        return tuple(act for act in self.acts if not act.same)

    @property
    def timed(self) -> list[tuple[int, Compared]]:
        """By how much the twin is later, and where, the least first."""
        return sorted(((act.later_ns, act) for act in self.acts if act.later_ns is not None), key=lambda pair: pair[0])

    @property
    def median_ns(self) -> int | None:
        """By how much the twin is later, as a rule."""
        timed = self.timed
        return timed[len(timed) // 2][0] if timed else None

    @property
    def worst(self) -> Compared | None:
        """Where the times differ most."""
        return max(self.timed, key=lambda pair: abs(pair[0]))[1] if self.timed else None


def compare(conversation: Conversation, bench: Bench, patience_s: float = PATIENCE_S) -> Comparison:
    """Play it to its end, whatever differs.  Raises ProgramError if it names what the bench does not have."""
    open_channels(conversation, bench)
    with ExitStack() as stack:
        comparer = _Comparer(conversation, bench, conversation.codec, to_ns(patience_s))
        comparer.listen(stack)
        for act in [comparer.prepare(act) for act in conversation.acts]:
            act()
        comparer.tell_rest()
    return Comparison(tuple(comparer.found))


def recorded_times(acts: Iterable[Act]) -> Iterator[int | None]:
    """When each act was over in the recording; None where that is not told.

    `= clock` behind an answer tells it; after an answer without that, nothing is known up to the next `= clock`.
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
    except NumberError as error:
        raise ProgramError(f"{error}: write seconds, like = clock 0.25", line=act.line) from None


class _Comparer(Player):
    """Plays on whatever comes, and notes it."""

    def __init__(self, conversation: Conversation, bench: Bench, codec: Codec, patience_ns: int) -> None:
        super().__init__(conversation, bench, codec)
        self.found: list[Compared] = []
        self._patience_ns = patience_ns
        self._when: dict[str, deque[int]] = {name: deque() for name in self.heard}
        self._levels: dict[tuple[str, str], deque[tuple[int, bool]]] = {}
        try:
            times = list(recorded_times(conversation.acts))
        except ProgramError as error:
            raise error.at(conversation.file, error.line, 0) from None
        self._recorded = dict(zip(map(id, conversation.acts), times, strict=True))
        self._after = ""
        self._after_recorded_ns: int | None = 0
        self._after_ns = bench.now
        self._last_recorded_ns: int | None = 0

    def listen(self, stack: ExitStack) -> None:
        """Note also when what comes, and how control lines change."""
        super().listen(stack)
        for name, when in self._when.items():
            stack.callback(self.hosts[name].hear(partial(self._note_when, when)))
            if name in self.bench.ports and self.bench.ports[name].handshake:
                self._watch(name, stack)

    def _watch(self, name: str, stack: ExitStack) -> None:
        for subject in LINES:
            changes = self._levels[name, subject] = deque()
            stack.callback(self._line(name, subject).watch(partial(self._note_level, changes)))

    def _line(self, name: str, subject: str) -> Pin:
        port = self.bench.ports[name]
        return port.dtr_line if subject == "dtr" else port.rts_line

    def _note_when(self, when: deque[int], data: bytes) -> None:
        when.extend([self.bench.now] * len(data))

    def _note_level(self, changes: deque[tuple[int, bool]], pin: Pin) -> None:
        changes.append((self.bench.now, pin.level))

    # What the player does, and what is noted of it

    def _played(self, act: Act) -> "partial[None]":
        if self._means_nothing(act):
            return partial(self._pass, act)
        return partial(self._do, act, super()._played(act))

    def _means_nothing(self, act: Act) -> bool:
        """The clock of the recording is looked at elsewhere; a twin without control lines minds none."""
        if isinstance(act, Expect) and act.subject == "clock":
            return True
        subject = act.target if isinstance(act, Do) else act.subject if isinstance(act, Expect) else ""
        return subject in LINES and (self._partner(act), subject) not in self._levels

    def _do(self, act: Act, do: Callable[[], object]) -> None:
        if isinstance(act, Say | Do):
            self._after = write((act,), self.codec).strip()
            self._after_recorded_ns, self._after_ns = self._recorded[id(act)], self.bench.now
        do()
        self._pass(act)

    def _pass(self, act: Act) -> None:
        self._last_recorded_ns = self._recorded[id(act)]

    def _hear(self, act: Hear, name: str) -> Difference | None:
        heard, deadline_ns = self.heard[name], self._deadline_ns(act)
        while len(heard) < len(act.data) and act.data.startswith(heard):
            if not self._more(heard, to_seconds(deadline_ns - self.bench.now)):
                break
        count = len(act.data) if heard.startswith(act.data) and act.data else self._other_words(act, name)
        got, time_ns = self._take(name, count)
        self._note(act, self.codec.show(act.data), self.codec.show(got), time_ns)
        return None

    def _other_words(self, act: Hear, name: str) -> int:
        """How much of what has been heard stands for this act: up to what was to be said, or else one message."""
        heard, pause_s = self.heard[name], to_seconds(self.hosts[name].pause_ns)
        while heard and len(heard) < len(act.data) + 32 and self._more(heard, pause_s):
            pass
        at = heard.find(act.data) if act.data else -1
        if at >= 0:
            return at + len(act.data)
        if act.data.endswith(TERMINATORS):
            return min((n + 1 for n, byte in enumerate(heard) if bytes([byte]) in TERMINATORS), default=len(heard))
        return len(heard)

    def _take(self, name: str, count: int) -> tuple[bytes, int | None]:
        got, when = bytes(self.heard[name][:count]), self._when[name]
        del self.heard[name][:count]
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
        """A control line changes: the next change to that level since the host's last act, if it comes in time.

        Recordings look at lines now and then, so what was over before that act may well have been missed there.  A
        line that has that level already is right, but nobody knows since when in the hardware.
        """
        name, wanted = self._partner(act), f"{act.subject} {act.value}"
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
        """So long it took in the recording, and some patience."""
        then_ns, before_ns = self._recorded[id(act)], self._last_recorded_ns
        gap_ns = to_ns(self.patience_s) if then_ns is None or before_ns is None else max(0, then_ns - before_ns)
        return self.bench.now + gap_ns + self._patience_ns

    def _note(self, act: Act, expected: str, got: str, time_ns: int | None) -> None:
        then_ns, after_ns = self._recorded[id(act)], self._after_recorded_ns
        hardware_ns = None if then_ns is None or after_ns is None else then_ns - after_ns
        twin_ns = None if time_ns is None else time_ns - self._after_ns
        self.found.append(Compared(act.line, self._after, expected, got, hardware_ns, twin_ns))

    def tell_rest(self) -> None:
        """What the twin has said that nobody expected."""
        self.bench.run(to_seconds(20 * MS))
        for name, heard in self.heard.items():
            if heard:
                got, time_ns = self._take(name, len(heard))
                twin_ns = None if time_ns is None else time_ns - self._after_ns
                self.found.append(Compared(0, self._after, "", self.codec.show(got), None, twin_ns))
