"""What a signal has done, in a memory of limited size.

The newest changes are kept as they were.  Of older ones, intervals are: when the first and the last change in it was,
from which value to which, the least and the greatest, and the area below.  There are four sizes of intervals; what
has become too much of one size goes into the next, so that hours take no more room than `MOST_BYTES`, nothing is
forgotten altogether, and an interval with a single change still is that change.  Where the smallest intervals would
hold a few changes each, these go into the next size at once: that saves little room and takes most of the time.
"""

from bisect import bisect
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from axistwin.bench.codec import CHARACTERS

Times = NDArray[np.int64]
Numbers = NDArray[np.float64]

CHANGES = 1 << 16
"""The newest changes: so many are kept as they were."""
ROWS = 1 << 13
"""Intervals of each size."""
SHIFTS = (20, 25, 30, 35)
"""Sizes of intervals, as powers of 2 in ns: 1 ms, 34 ms, 1.1 s, 34 s.  The last grow if hours become weeks."""
MOST_BYTES = CHANGES * 16 + len(SHIFTS) * ROWS * 56
"""What a signal takes up at most: 2.75 MiB."""
WORTH = 16
"""So many changes in each of the smallest intervals, on average, make it worth while to have them."""
SMALL = 1 << 8
TEXTS, LONGEST = 1 << 13, 256
"""Of words: so many changes, and the first so many characters of each."""


class Rows(NamedTuple):
    """Stretches of time in order, in each of which something has changed; a single change begins where it ends."""

    begin: Times
    end: Times
    first: Numbers
    low: Numbers
    high: Numbers
    last: Numbers
    """It stays like this until the next begins."""
    area: Numbers
    """Value times nanoseconds, from `begin` to `end`."""

    def cut(self, part: slice) -> "Rows":
        """Some of them."""
        begin, end, *values = self
        return Rows(begin[part], end[part], *(column[part] for column in values))


def changes(times: Times, values: Numbers) -> Rows:
    """Single changes as rows."""
    return Rows(times, times, values, values, values, values, np.broadcast_to(0.0, values.shape))


def joined(parts: list[Rows]) -> Rows:
    """One after the other."""
    return parts[0] if len(parts) == 1 else Rows(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def summed(rows: Rows, shift: int) -> Rows:
    """Those of the same interval of `2 ** shift` ns as one."""
    places = rows.begin >> shift
    starts = np.concatenate(((0,), np.flatnonzero(places[1:] != places[:-1]) + 1))
    ends = np.append(starts[1:], len(rows.begin)) - 1
    area = np.empty(len(rows.begin))
    np.multiply(rows.last[:-1], rows.begin[1:] - rows.end[:-1], out=area[:-1])
    if rows.begin is not rows.end:  # single changes have none
        area[:-1] += rows.area[:-1]
    area[ends] = rows.area[ends]
    return Rows(
        rows.begin[starts],
        rows.end[ends],
        rows.first[starts],
        np.fmin.reduceat(rows.low, starts),
        np.fmax.reduceat(rows.high, starts),
        rows.last[ends],
        np.add.reduceat(area, starts),
    )


NOTHING = changes(np.empty(0, np.int64), np.empty(0))


class Track:
    """One signal.  Where its value is not a number nobody was looking."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._times, self._values = np.empty(SMALL, np.int64), np.empty(SMALL)
        self._size = 0
        self._older = [NOTHING] * len(SHIFTS)
        self._shifts = list(SHIFTS)

    @property
    def nbytes(self) -> int:
        """What it takes up."""
        older = sum(column.nbytes for rows in self._older for column in rows)
        return self._times.nbytes + self._values.nbytes + older

    @property
    def exact_ns(self) -> int:
        """From here on every change is known by itself."""
        return int(self._times[0]) if any(len(rows.begin) for rows in self._older) else 0

    def add(self, times: Times, values: Numbers) -> None:
        """What has come, later than all before; what is no change is left out."""
        changed = np.empty(len(values), bool)
        changed[:1] = values[:1] != (self._values[self._size - 1] if self._size else np.nan)
        np.not_equal(values[1:], values[:-1], out=changed[1:])
        if not changed.all():
            times, values = times[changed], values[changed]
        half = CHANGES // 2
        for at in range(0, len(times), half):
            self._append(times[at : at + half], values[at : at + half])

    def interrupt(self, time_ns: int) -> None:
        """Nobody looks from here on."""
        self.add(np.array([time_ns], np.int64), np.array([np.nan]))

    def rows(self, from_ns: int, to_ns: int) -> Rows:
        """What begins before `to_ns`, from the one on that it is like at `from_ns`; perhaps some earlier ones."""
        size = self._size
        raw = changes(self._times[:size], self._values[:size])
        if size and raw.begin[0] <= from_ns:
            return _slice(raw, from_ns, to_ns)
        parts = [*reversed(self._older), raw]
        return joined([_slice(part, from_ns, to_ns) for part in parts if len(part.begin)] or [NOTHING])

    def frozen(self) -> Self:
        """As it is now; it does not go on."""
        copy = type(self).__new__(type(self))
        copy.__dict__ |= self.__dict__
        copy._times, copy._values = self._times[: self._size].copy(), self._values[: self._size].copy()
        copy._older = list(self._older)
        return copy

    def _append(self, times: Times, values: Numbers) -> None:
        if self._size + len(times) > len(self._times):
            self._make_room(len(times))
        end = self._size + len(times)
        self._times[self._size : end], self._values[self._size : end] = times, values
        self._size = end

    def _make_room(self, count: int) -> None:
        if self._size + count <= CHANGES:
            room = min(CHANGES, max(2 * len(self._times), self._size + count))
            self._times, self._values = np.resize(self._times, room), np.resize(self._values, room)
            return
        self._grow_to_most()
        over = min(self._size, CHANGES // 2)
        self._keep_older(changes(self._times[:over], self._values[:over]))
        left = self._size - over
        self._times[:left], self._values[:left] = self._times[over : self._size], self._values[over : self._size]
        self._size = left

    def _grow_to_most(self) -> None:
        if len(self._times) < CHANGES:
            self._times, self._values = np.resize(self._times, CHANGES), np.resize(self._values, CHANGES)

    def _keep_older(self, rows: Rows) -> None:
        """Changes that are kept as intervals from now on."""
        span = int(rows.begin[-1] - rows.begin[0])
        level = 0 if len(rows.begin) << self._shifts[0] >= WORTH * span else 1
        if level and len(self._older[0].begin):
            self._add_older(level, self._older[0])
            self._older[0] = NOTHING
        self._add_older(level, rows)

    def _add_older(self, level: int, rows: Rows) -> None:
        """They become intervals of this level; if there are too many of those, the first go on to the next."""
        all_ = joined([self._older[level], summed(rows, self._shifts[level])])
        over = len(all_.begin) - ROWS
        if over > 0 and level + 1 < len(SHIFTS):
            over += ROWS // 2
            self._add_older(level + 1, all_.cut(slice(over)))
            all_ = joined([NOTHING, all_.cut(slice(over, None))])  # a copy, or what went on would be kept as well
        elif over > 0:
            all_ = self._coarser(level, all_)
        self._older[level] = all_

    def _coarser(self, level: int, rows: Rows) -> Rows:
        """Larger intervals, until half the room is free."""
        while len(rows.begin) > ROWS // 2:
            self._shifts[level] += 1
            rows = summed(rows, self._shifts[level])
        return rows


def _slice(rows: Rows, from_ns: int, to_ns: int) -> Rows:
    first = max(int(np.searchsorted(rows.begin, from_ns, "right")) - 1, 0)
    return rows.cut(slice(first, max(int(np.searchsorted(rows.begin, to_ns)), first + 1)))


class Words(Track):
    """Texts: as a track it is 1 where there is one; the newest are known by their words."""

    def __init__(self, kind: str, growing: bool) -> None:
        super().__init__(kind)
        self.growing = growing
        """Whether a text that begins with the one before is the same message, character by character."""
        self.changes: list[tuple[int, str]] = []
        self.begins: list[int] = []
        """When messages have begun."""
        self.messages: list[str] = []
        self._newest = b""
        self._forgotten_ns = 0

    @property
    def exact_ns(self) -> int:
        """From here on all words are known."""
        return max(super().exact_ns, self._forgotten_ns)

    def say(self, times: Times, texts: list[bytes]) -> None:
        """What has been said."""
        for time_ns, text in zip(times.tolist(), texts, strict=True):
            self._change(time_ns, text[:LONGEST])
        self.add(times, np.array([float(bool(text)) for text in texts]))

    def at(self, time_ns: int) -> str:
        """What it was then."""
        place = bisect(self.changes, time_ns, key=lambda change: change[0]) - 1
        return self.changes[place][1] if place >= 0 else ""

    def frozen(self) -> Self:
        """As it is now."""
        copy = super().frozen()
        copy.changes, copy.begins, copy.messages = list(self.changes), list(self.begins), list(self.messages)
        return copy

    def _change(self, time_ns: int, text: bytes) -> None:
        before, self._newest = self._newest, text
        if text == before:
            return
        shown = CHARACTERS.show(text)
        self.changes.append((time_ns, shown))
        if self.growing and before and text.startswith(before):
            self.messages[-1] = shown
        elif text:
            self.begins.append(time_ns)
            self.messages.append(shown)
        if len(self.changes) > TEXTS:
            self._forget()

    def _forget(self) -> None:
        """A quarter of the words, from the beginning on."""
        del self.changes[: TEXTS // 4]
        self._forgotten_ns = self.changes[0][0]
        gone = bisect(self.begins, self._forgotten_ns) - 1
        del self.begins[: max(gone, 0)], self.messages[: max(gone, 0)]
