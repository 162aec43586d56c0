"""What has come from outside, with its time: enough to run a bench again so that the same happens.

A moment is a nanosecond, and the acts that were done in it without the clock having gone on between them; each act is
what a conversation has (`Say`, `Do`).  A host that polls for hours says the same all the time, so acts are kept once
each, and a moment is the time since the one before and the numbers of its acts: some 5 bytes for a poll.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from axistwin.bench.acts import Do, Say
from axistwin.errors import UsageError

Act = Say | Do
MOST_BYTES = 64 << 20
"""A journal that has grown to this is full: hosts that poll ten times a second take two weeks for it."""
OF_AN_ACT = 400
"""Bytes, about, for each act that is not as one before."""


@dataclass(frozen=True)
class Moment:
    """Acts with no pass of the clock between them."""

    time_ns: int
    acts: tuple[Act, ...]


@dataclass(frozen=True)
class Cursor:
    """A place between two moments of a journal."""

    offset: int = 0
    time_ns: int = 0
    """Of the moment before it."""
    known: int = 0
    """Different acts up to there."""


class Journal:
    """Moments in order of time.  It ends where it is full; what is done after that is not in it."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self.full_ns: int | None = None
        """Since when it is full; None: it is not.  What was done at that nanosecond is not whole."""
        self._most_bytes = most_bytes
        self._data = bytearray()
        self._numbers: dict[Act, int] = {}
        self._acts: list[Act] = []
        self._texts = 0
        self._last_ns = 0
        self._pass: int | None = None

    @property
    def bytes(self) -> int:
        """How much memory it takes, about."""
        return len(self._data) + self._texts

    def add(self, time_ns: int, clock_pass: int, act: Act) -> bool:
        """An act is done now, in this pass of the clock.  Returns whether it is kept."""
        if self.full_ns is None and self.bytes > self._most_bytes:
            self.full_ns = time_ns
        if self.full_ns is not None:
            return False
        begins = clock_pass != self._pass
        self._put((time_ns - self._last_ns) << 1 | begins)
        self._put(self._number(act))
        self._last_ns, self._pass = time_ns, clock_pass
        return True

    def moment(self, cursor: Cursor) -> tuple[Moment, Cursor] | None:
        """The moment that follows, and the place behind it; None: there is none."""
        if cursor.offset >= len(self._data):
            return None
        word, offset = self._get(cursor.offset)
        number, offset = self._get(offset)
        time_ns, acts, known = cursor.time_ns + (word >> 1), [self._acts[number]], max(cursor.known, number + 1)
        while offset < len(self._data):
            word, behind = self._get(offset)
            if word & 1:
                break
            number, offset = self._get(behind)
            acts.append(self._acts[number])
            known = max(known, number + 1)
        return Moment(time_ns, tuple(acts)), Cursor(offset, time_ns, known)

    def __iter__(self) -> Iterator[Moment]:
        cursor = Cursor()
        while found := self.moment(cursor):
            moment, cursor = found
            yield moment

    def forget_from(self, cursor: Cursor) -> None:
        """What is behind this place has never been."""
        del self._data[cursor.offset :]
        for act in self._acts[cursor.known :]:  # they are numbered as they come
            del self._numbers[act]
            self._texts -= _size(act)
        del self._acts[cursor.known :]
        self._last_ns, self._pass, self.full_ns = cursor.time_ns, None, None

    def _number(self, act: Act) -> int:
        number = self._numbers.setdefault(act, len(self._acts))
        if number == len(self._acts):
            self._acts.append(act)
            self._texts += _size(act)
        return number

    def _put(self, number: int) -> None:
        """Seven bits a byte, the low ones first; the last byte has its top bit clear."""
        while number > 0x7F:
            self._data.append(number & 0x7F | 0x80)
            number >>= 7
        self._data.append(number)

    def _get(self, offset: int) -> tuple[int, int]:
        number = shift = 0
        while (byte := self._data[offset]) & 0x80:
            number |= (byte & 0x7F) << shift
            shift, offset = shift + 7, offset + 1
        return number | byte << shift, offset + 1


def _size(act: Act) -> int:
    return OF_AN_ACT + len(act.data if isinstance(act, Say) else act.value)


def check(act: Act) -> None:
    """Raises UsageError for what cannot stand on a line of a scene or a conversation, so that it could not be kept."""
    if isinstance(act, Do) and (";" in act.value or "\n" in act.value):
        raise UsageError(f"{act.target} {act.value}: no ; and no new line can stand there")
