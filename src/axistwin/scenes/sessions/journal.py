"""The journal: all external input of a run with its time, from which the run can be replayed exactly.

A moment contains the actions between two advances of the clock, which have the same time.  An action is a `Say` or a
`Do` of a conversation.  Equal actions are stored once, with a number.  A moment stores the time since the previous
moment and the numbers of its actions, so a repeated request of a host takes about 5 bytes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from axistwin.bench.acts import Do, Say
from axistwin.core.errors import UsageError

Act = Say | Do
MAX_BYTES = 64 << 20
"""Maximum size of a journal in bytes.  A host that polls ten times a second fills the journal in two weeks."""
BYTES_PER_ACT = 400  # Approximate size in bytes of each different action.


@dataclass(frozen=True)
class Moment:
    """Recorded actions that have the same virtual time.  The actions occur between two advances of the clock."""

    time_ns: int
    acts: tuple[Act, ...]


@dataclass(frozen=True)
class Cursor:
    """Reading position in a journal (the list of recorded actions of users and hosts)."""

    offset: int = 0
    time_ns: int = 0  # Time of the preceding actions.
    known: int = 0  # Number of different actions before this position.


@dataclass(frozen=True)
class Tail:
    """Recorded actions that `Journal.truncate` has deleted.  `Journal.restore` restores these actions."""

    cursor: Cursor  # Position at which the journal was cut.
    data: bytes
    acts: tuple[Act, ...]
    last_ns: int
    full_ns: int | None


class Journal:
    """The recorded actions of users and hosts, in order of time.  A full journal accepts no more actions."""

    def __init__(self, max_bytes: int = MAX_BYTES) -> None:
        self.full_ns: int | None = None
        """Time at which the journal became full, or None; actions of exactly this time may be missing."""
        self._max_bytes = max_bytes
        self._data = bytearray()
        self._numbers: dict[Act, int] = {}
        self._acts: list[Act] = []
        self._texts, self._last_ns = 0, 0
        self._pass: int | None = None

    @property
    def bytes(self) -> int:
        return len(self._data) + self._texts

    def add(self, time_ns: int, clock_pass: int, act: Act) -> bool:
        """Append an action; return False if the journal is full.  `clock_pass`: clock advances before it."""
        if self.full_ns is None and self.bytes > self._max_bytes:
            self.full_ns = time_ns
        if self.full_ns is not None:
            return False
        self._put((time_ns - self._last_ns) << 1 | (clock_pass != self._pass))
        self._put(self._number(act))
        self._last_ns, self._pass = time_ns, clock_pass
        return True

    def moment(self, cursor: Cursor) -> tuple[Moment, Cursor] | None:
        """Return the moment after `cursor` and the position after this moment; None at the end."""
        if cursor.offset >= len(self._data):
            return None
        word, offset = self._get(cursor.offset)
        number, offset = self._get(offset)
        time_ns, acts, known = cursor.time_ns + (word >> 1), [self._acts[number]], max(cursor.known, number + 1)
        while offset < len(self._data):
            word, after = self._get(offset)
            if word & 1:
                break
            number, offset = self._get(after)
            acts.append(self._acts[number])
            known = max(known, number + 1)
        return Moment(time_ns, tuple(acts)), Cursor(offset, time_ns, known)

    def __iter__(self) -> Iterator[Moment]:
        cursor = Cursor()
        while found := self.moment(cursor):
            moment, cursor = found
            yield moment

    def truncate(self, cursor: Cursor) -> Tail:
        """Delete all moments after this position, and return them for `restore`."""
        tail = Tail(
            cursor, bytes(self._data[cursor.offset :]), tuple(self._acts[cursor.known :]), self._last_ns, self.full_ns
        )
        del self._data[cursor.offset :]
        for act in self._acts[cursor.known :]:
            del self._numbers[act]
            self._texts -= _size(act)
        del self._acts[cursor.known :]
        self._last_ns, self._pass, self.full_ns = cursor.time_ns, None, None
        return tail

    def restore(self, tail: Tail) -> None:
        """Undo `truncate`: replace all moments after the position of `tail` by the deleted ones."""
        self.truncate(tail.cursor)
        self._data += tail.data
        for act in tail.acts:
            self._number(act)
        self._last_ns, self.full_ns = tail.last_ns, tail.full_ns

    def _number(self, act: Act) -> int:
        number = self._numbers.setdefault(act, len(self._acts))
        if number == len(self._acts):
            self._acts.append(act)
            self._texts += _size(act)
        return number

    def _put(self, number: int) -> None:
        """Append a number with seven bits per byte, low bits first; the highest bit is clear in the last byte."""
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
    return BYTES_PER_ACT + len(act.data if isinstance(act, Say) else act.value)


def check(act: Act) -> None:
    """Raise UsageError if the text of an operator's action contains a line end or a semicolon."""
    if isinstance(act, Do) and (";" in act.value or "\n" in act.value):
        value, action = act.value, act.target
        raise UsageError(f"invalid value {value!r} of the action {action}: expected one line without a semicolon")
