"""The level of a wire over time, calculated exactly with integers.

A wire is at mark, except during its *spaces*.  An instant is `number / per` nanoseconds: the bits of a sender at B
baud begin at whole multiples of 1/B ns.  Two instants are compared by cross-multiplication.

mark  ──┐     ┌──┐        ┌──
space   └─────┘  └────────┘
        begin end                   half open: at `begin` the wire is at space, at `end` at mark

Each space is stored once and removed once, and only the earliest stored space is read.  The computing time per
character is therefore constant.
"""

from collections import deque
from collections.abc import Iterable
from fractions import Fraction
from math import lcm

from axistwin.sim.frames import Frame


class Space:
    """The wire is at space from `begin` to `end`, in units of 1/`per` ns."""

    __slots__ = ("begin", "end", "per", "unread")

    def __init__(self, begin: int, end: int, per: int, unread: bool) -> None:
        self.begin, self.end, self.per = begin, end, per
        self.unread = unread  # True if the receiver may still take the falling edge as a start bit.


class Levels:
    """The planned levels of a wire, from the present time on. They must be read in order of time."""

    def __init__(self) -> None:
        self._spaces: deque[Space] = deque()

    def __len__(self) -> int:
        return len(self._spaces)

    def put(self, frame: Frame) -> None:
        """Put a frame on the wire.  Where frames overlap, the wire is at space if one of them is."""
        bit, per = frame.bit, frame.per
        start = frame.start_ns * per
        new = [Space(start + first * bit, start + last * bit, per, not frame.own) for first, last in frame.spaces]
        if self._spaces and new and _before(new[0].begin, per, self._spaces[-1].end, self._spaces[-1].per):
            new = _merged((*self._take_from(new[0]), *new))
        self._spaces.extend(new)

    def cut(self, now_ns: int) -> None:
        """Hold the wire high (mark, logic 1) from the time `now_ns` until the next call of `put`."""
        spaces = self._spaces
        while spaces and spaces[-1].begin >= now_ns * spaces[-1].per:
            spaces.pop()
        if spaces:
            spaces[-1].end = min(spaces[-1].end, now_ns * spaces[-1].per)

    def low(self, at: int, per: int) -> bool:
        """True if the wire is low at the given time.  The time is `at/per` ns.  Earlier spaces are discarded."""
        self.forget(at, per)
        spaces = self._spaces
        return bool(spaces) and spaces[0].begin * per <= at * spaces[0].per

    def sample(self, at: int, step: int, per: int, count: int) -> int:
        """Return `count` levels as bits: bit 0 at `at/per` ns, bit 1 at `(at + step)/per` ns, and so on.

        Spaces before the last but one sample are discarded; a receiver may sample the newer ones once more.
        """
        levels, forgotten = (1 << count) - 1, 0
        for space in self._spaces:
            since, width = at * space.per, step * space.per
            first_low = max(0, (space.begin * per - since + width - 1) // width)
            if first_low >= count:
                break
            # Index of the first sample after this low pulse, or `count` if no sample follows the pulse.
            next_high = min(count, (space.end * per - since + width - 1) // width)
            if next_high > first_low:
                levels &= ~((1 << next_high) - (1 << first_low))
            forgotten += next_high <= count - 2
        for _ in range(forgotten):
            self._spaces.popleft()
        return levels

    def at(self, time_ns: Fraction) -> bool:
        return not any(space.begin <= time_ns * space.per < space.end for space in self._spaces)

    def forget(self, at: int, per: int = 1) -> None:
        """Discard all spaces that end by `at/per` ns."""
        spaces = self._spaces
        while spaces and spaces[0].end * per <= at * spaces[0].per:
            spaces.popleft()

    def free(self, now_ns: int) -> bool:
        """True if all low pulses on the serial wire have ended by the time `now_ns`."""
        return not self._spaces or self._spaces[-1].end <= now_ns * self._spaces[-1].per

    def falls(self, since: int, per: int) -> Iterable[Space]:
        """Yield the unread spaces whose falling edge is at `since/per` ns or later; each space is yielded once."""
        for space in self._spaces:
            if space.unread:
                space.unread = False
                if space.begin * per >= since * space.per:
                    yield space

    def _take_from(self, first: Space) -> list[Space]:
        taken = []
        while self._spaces and _before(first.begin, first.per, self._spaces[-1].end, self._spaces[-1].per):
            taken.append(self._spaces.pop())
        return taken


def _before(one: int, per_one: int, other: int, per_other: int) -> bool:
    return one * per_other < other * per_one


def _merged(spaces: Iterable[Space]) -> list[Space]:
    """Merge overlapping spaces; those that only touch stay apart, each with its own start bit."""
    merged: list[Space] = []
    for space in sorted(spaces, key=lambda space: Fraction(space.begin, space.per)):
        last = merged[-1] if merged else None
        if last is None or not _before(space.begin, space.per, last.end, last.per):
            merged.append(space)
            continue
        if space.begin * last.per == last.begin * space.per:
            last.unread |= space.unread
        if _before(last.end, last.per, space.end, space.per):
            per = lcm(last.per, space.per)
            last.begin, last.end, last.per = last.begin * (per // last.per), space.end * (per // space.per), per
    return merged
