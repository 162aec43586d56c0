"""The history of a signal, in memory of limited size.

The newest changes are stored exactly.  Older changes are merged into intervals.  An interval stores the times of its
first and last change, its first, last, least and greatest value, and its integral.

There are four levels of intervals, each with longer intervals than the level before.  When a level is full, its oldest
intervals are merged into the next level, so that hours of data take at most `MOST_BYTES`.  If the intervals of the
first level would contain only a few changes each, the changes are merged into the second level directly.
"""

from bisect import bisect
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from axistwin.bench.codec import CHARACTERS

Times = NDArray[np.int64]
Numbers = NDArray[np.float64]

CHANGES = 1 << 16  # Largest number of changes of a signal that are stored exactly.
ROWS = 1 << 13  # Largest number of intervals in each level.
SHIFTS = (20, 25, 30, 35)
"""Length of the intervals in each level, as powers of 2 in ns: 1 ms, 34 ms, 1.1 s, 34 s.

The length in the last level doubles whenever that level is full.
"""
MOST_BYTES = CHANGES * 16 + len(SHIFTS) * ROWS * 56  # Largest memory for one signal: 2.75 MiB.
WORTH = 16  # Smallest average number of changes per interval for which the first level of intervals is used.
SMALL = 1 << 8
TEXTS, LONGEST = 1 << 13, 256  # Largest number of stored texts, and largest number of characters of each.


ZEROS = np.zeros(CHANGES)
ZEROS.flags.writeable = False


class Rows(NamedTuple):
    """Intervals in order of time, as columns.  A single change is a row whose `begin` and `end` are equal."""

    begin: Times
    end: Times
    first: Numbers
    low: Numbers
    high: Numbers
    last: Numbers  # Value from the end of each row until the next row begins.
    area: Numbers  # Integral of the value from `begin` to `end`, in value × ns.

    def cut(self, part: slice) -> "Rows":
        begin, end, *values = self
        return Rows(begin[part], end[part], *(column[part] for column in values))


def changes(times: Times, values: Numbers) -> Rows:
    return Rows(times, times, values, values, values, values, ZEROS[: len(values)])


def joined(parts: list[Rows]) -> Rows:
    return parts[0] if len(parts) == 1 else Rows(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def summed(rows: Rows, shift: int) -> Rows:
    """Summarise rows by intervals of `2 ** shift` ns; a row belongs to the one in which it begins."""
    places = rows.begin >> shift
    starts = np.concatenate(((0,), np.flatnonzero(places[1:] != places[:-1]) + 1))
    ends = np.append(starts[1:], len(rows.begin)) - 1
    area = np.empty(len(rows.begin))
    np.multiply(rows.last[:-1], rows.begin[1:] - rows.end[:-1], out=area[:-1])
    rows_have_duration = rows.begin is not rows.end
    if rows_have_duration:
        area[:-1] += rows.area[:-1]
    area[ends] = rows.area[ends]
    return Rows(
        rows.begin[starts], rows.end[ends], rows.first[starts], np.fmin.reduceat(rows.low, starts),
        np.fmax.reduceat(rows.high, starts), rows.last[ends], np.add.reduceat(area, starts),
    )  # fmt: skip


NOTHING = changes(np.empty(0, np.int64), np.empty(0))


class Track:
    """The history of one signal.  NaN stands for values that were not recorded."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._times, self._values = np.empty(SMALL, np.int64), np.empty(SMALL)
        self._size = 0
        self._older = [NOTHING] * len(SHIFTS)
        self._shifts = list(SHIFTS)
        self.flat, self._only = True, np.nan
        """True while the signal has had only one value, apart from values that were not recorded."""

    @property
    def nbytes(self) -> int:
        older = sum(column.nbytes for rows in self._older for column in rows)
        return self._times.nbytes + self._values.nbytes + older

    @property
    def exact_ns(self) -> int:
        """Time after which all changes are stored exactly."""
        return int(self._times[0]) if any(len(rows.begin) for rows in self._older) else 0

    def add(self, times: Times, values: Numbers) -> bool:
        """Append samples without repetitions of a value; return False if none has been appended."""
        changed = np.empty(len(values), bool)
        changed[:1] = values[:1] != (self._values[self._size - 1] if self._size else np.nan)
        np.not_equal(values[1:], values[:-1], out=changed[1:])
        if not changed.all():
            times, values = times[changed], values[changed]
        if self.flat:
            self._compare(values)
        half = CHANGES // 2
        for at in range(0, len(times), half):
            self._append(times[at : at + half], values[at : at + half])
        return len(times) > 0

    def _compare(self, values: Numbers) -> None:
        known = values[~np.isnan(values)]
        if len(known):
            self._only = known[0] if np.isnan(self._only) else self._only
            self.flat = bool((known == self._only).all())

    def interrupt(self, time_ns: int) -> None:
        self.add(np.array([time_ns], np.int64), np.array([np.nan]))

    def rows(self, from_ns: int, to_ns: int) -> Rows:
        """Return all rows between `from_ns` and `to_ns`, and at least the last row before them."""
        times, values = self._times[: self._size], self._values[: self._size]
        if len(times) and times[0] <= from_ns:
            part = _part(times, from_ns, to_ns)
            return changes(times[part], values[part])
        parts = [*reversed(self._older), changes(times, values)]
        return joined([part.cut(_part(part.begin, from_ns, to_ns)) for part in parts if len(part.begin)] or [NOTHING])

    def frozen(self) -> Self:
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
        if len(self._times) < CHANGES:
            self._times, self._values = np.resize(self._times, CHANGES), np.resize(self._values, CHANGES)
        over = min(self._size, CHANGES // 2)
        self._keep_older(changes(self._times[:over], self._values[:over]))
        left = self._size - over
        self._times[:left], self._values[:left] = self._times[over : self._size], self._values[over : self._size]
        self._size = left

    def _keep_older(self, rows: Rows) -> None:
        span = int(rows.begin[-1] - rows.begin[0])
        level = 0 if len(rows.begin) << self._shifts[0] >= WORTH * span else 1
        if level and len(self._older[0].begin):
            self._add_older(level, self._older[0])
            self._older[0] = NOTHING
        self._add_older(level, rows)

    def _add_older(self, level: int, rows: Rows) -> None:
        """Merge rows into intervals of this level; if the level is full, move its older half to the next level."""
        all_ = joined([self._older[level], summed(rows, self._shifts[level])])
        over = len(all_.begin) - ROWS
        if over > 0 and level + 1 < len(SHIFTS):
            over += ROWS // 2
            self._add_older(level + 1, all_.cut(slice(over)))
            # Copy the remaining rows: without a copy, NumPy would also keep the removed rows in memory.
            all_ = joined([NOTHING, all_.cut(slice(over, None))])
        elif over > 0:
            all_ = self._coarser(level, all_)
        self._older[level] = all_

    def _coarser(self, level: int, rows: Rows) -> Rows:
        while len(rows.begin) > ROWS // 2:
            self._shifts[level] += 1
            rows = summed(rows, self._shifts[level])
        return rows


def _part(times: Times, from_ns: int, to_ns: int) -> slice:
    """Return the part from `from_ns` to `to_ns`, and at least the last time before them."""
    first = max(int(times.searchsorted(from_ns, "right")) - 1, 0)
    return slice(first, max(int(times.searchsorted(to_ns)), first + 1))


class Words(Track):
    """The history of a text signal.  The numeric value of the signal is 1 during a text, otherwise 0."""

    def __init__(self, kind: str, growing: bool) -> None:
        super().__init__(kind)
        self.growing = growing  # A text that begins with the previous one is the same message with more characters.
        self.changes: list[tuple[int, str]] = []
        self.begins: list[int] = []  # Start times of messages.
        self.messages: list[str] = []
        self._newest = b""
        self._forgotten_ns = 0

    @property
    def exact_ns(self) -> int:
        return max(super().exact_ns, self._forgotten_ns)

    def say(self, times: Times, texts: list[bytes]) -> bool:
        """Append texts with their start times to the history of a text signal.  Return False if `texts` is empty."""
        for time_ns, text in zip(times.tolist(), texts, strict=True):
            self._change(time_ns, text[:LONGEST])
        self.add(times, np.array([float(bool(text)) for text in texts]))
        return bool(texts)

    def at(self, time_ns: int) -> str:
        """Return the text at this time; "" without a text."""
        place = bisect(self.changes, time_ns, key=lambda change: change[0]) - 1
        return self.changes[place][1] if place >= 0 else ""

    def frozen(self) -> Self:
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
        del self.changes[: TEXTS // 4]
        self._forgotten_ns = self.changes[0][0]
        gone = bisect(self.begins, self._forgotten_ns) - 1
        del self.begins[: max(gone, 0)], self.messages[: max(gone, 0)]
