"""The external encoder, or step source, whose two lines are wired to pins A and B of a servo motor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import floor
from typing import Protocol

from axistwin.errors import UsageError
from axistwin.numbers import shortened
from axistwin.sim.by_hand import ByHand, check_counts
from axistwin.sim.clock import Clock
from axistwin.units import to_ns

MOST_RATIO = 1_000_000
"""Counts for each unit of the axis that an encoder sits on."""


class Followed(Protocol):
    """An axis that a master may sit on."""

    on_motion: list[Callable[[], None]]
    """Called when it begins to move, or takes another course."""

    @property
    def position(self) -> int:
        """Where it stands."""

    @property
    def resting(self) -> bool:
        """Whether it stays there until `on_motion` is called."""

    @property
    def foreseen(self) -> bool:
        """Whether `positions_at` can tell its course up to the next call of `on_motion`."""

    @property
    def follows(self) -> "Followed | None":
        """The axis that its own motor's master sits on, if it has one."""

    def positions_at(self, times_ns: Sequence[int]) -> Sequence[int]:
        """Where it will stand at these times, in order, as things are now."""


@dataclass(frozen=True, slots=True)
class Run:
    """From `base` on, `counts` edges evenly spread over `duration_ns`, beginning at `start_ns`; then rest."""

    start_ns: int
    base: int
    counts: int
    duration_ns: int

    @property
    def end_ns(self) -> int:
        """When its last edge comes."""
        return self.start_ns + self.duration_ns

    def at(self, time_ns: int) -> int:
        """The count at a time not before the start.

        The n-th edge comes `n * duration_ns / |counts|` after the start, or in the first nanosecond after that; so the
        count is rounded towards where the run began, in either direction.
        """
        if time_ns >= self.end_ns:
            return self.base + self.counts
        edges = abs(self.counts) * (time_ns - self.start_ns) // self.duration_ns
        return self.base + (edges if self.counts > 0 else -edges)


class Master:
    """What is wired to pins A and B: a quadrature encoder, or a step source of so many steps.

    There are no events for edges; who needs them calculates the count, from which the levels of A and B follow.
    `own`: the axis of the motor that it is wired to.
    """

    def __init__(self, clock: Clock, own: Followed | None = None) -> None:
        self.clock, self._own = clock, own
        self.run = Run(clock.now, 0, 0, 0)
        """The latest run, perhaps over."""
        self.followed: Followed | None = None
        """The axis it sits on; while that moves its count can be told in advance if it is `foreseen`."""
        self._ratio = Fraction(1)
        self._unwatch: Callable[[], object] = lambda: None
        self.plugged = False
        """True from the first run on: until then nothing is wired to A and B."""
        self.by_hand = ByHand(clock)
        """Reports how a person turns it: `master`, counts and seconds; or an axis that it sits on, and the ratio."""
        self.before_change: list[Callable[[], None]] = []
        """Called before its course changes, while `at` still tells the old one."""
        self.on_change: list[Callable[[], None]] = []
        """Called when its course has changed."""

    @property
    def count(self) -> int:
        """Quadrature edges (or steps) so far, those in the negative direction taken off; from 0 when it is made."""
        return self.at(self.clock.now)

    @property
    def ratio(self) -> Fraction:
        """So many edges it counts for each unit of the axis it sits on."""
        return self._ratio

    @property
    def moving(self) -> bool:
        """Whether edges are still to come."""
        return self.followed is not None or (self.run.counts != 0 and self.clock.now < self.run.end_ns)

    @property
    def foreseen(self) -> bool:
        """Whether `foretell` can tell the count of an axis that it sits on."""
        return self.followed is not None and self.followed.foreseen

    def foretell(self, first_ns: int, period_ns: int, number: int) -> list[int]:
        """The counts at `first_ns` and so often, at this period, as things are now; on an axis that is `foreseen`."""
        assert self.followed is not None, "it sits on an axis"
        times_ns = range(first_ns, first_ns + number * period_ns, period_ns)
        ratio, base = self._ratio, self.run.base
        return [base + p * ratio.numerator // ratio.denominator for p in self.followed.positions_at(times_ns)]

    def at(self, time_ns: int) -> int:
        """The count at a time from the beginning of the present run on, as things are now."""
        if self.followed is not None:
            return self.run.base + floor(self.followed.position * self._ratio)
        return self.run.at(time_ns)

    def move(self, counts: int, seconds: float) -> None:
        """From now on `counts` edges at constant speed, within `seconds`; 0: at once.

        What is left of a run before is not done any more.  Raises UsageError for a negative time.
        """
        check_counts(counts, "move")
        if not 0 <= seconds < float("inf"):
            raise UsageError(f"move({counts}, {seconds!r}): give a time of 0 seconds or more")
        duration_ns = to_ns(seconds)
        self.by_hand.tell("master", counts, seconds)
        count = self.count
        self._unwatch()
        self._unwatch = lambda: None
        self._change(Run(self.clock.now, count, counts, duration_ns), None)

    def follow(self, axis: Followed, ratio: Fraction | int = 1) -> None:
        """From now on it sits on the shaft of this axis, and counts `ratio` for each of that axis's units.

        Raises UsageError if that axis is its own motor's, or follows that one: nobody would move first; and for a ratio
        beyond a million.
        """
        if not -MOST_RATIO <= ratio <= MOST_RATIO:
            raise UsageError(f"invalid ratio {shortened(str(ratio))}: expected {-MOST_RATIO} to {MOST_RATIO}, e.g. 3/2")
        self._check_no_circle(axis)
        self.by_hand.tell("master", axis, Fraction(ratio))
        base = self.count - floor(axis.position * Fraction(ratio))
        self._unwatch()
        self._ratio = Fraction(ratio)
        axis.on_motion.append(self._moves)
        self._unwatch = lambda: axis.on_motion.remove(self._moves)
        self._change(Run(self.clock.now, base, 0, 0), axis)

    def _check_no_circle(self, axis: Followed) -> None:
        below: Followed | None = axis
        while below is not None:
            if below is self._own:
                way = "is that motor's own" if axis is self._own else "follows that motor"
                raise UsageError(f"a motor's master cannot sit on an axis that {way}: let it follow another axis")
            below = below.follows

    def stop(self) -> None:
        """It stands still, and sits on no axis."""
        self.move(0, 0)

    def _moves(self) -> None:
        """The axis it sits on begins to move: what was calculated for rest is over."""
        self._change(self.run, self.followed)

    def _change(self, run: Run, followed: Followed | None) -> None:
        for action in self.before_change:
            action()
        self.run, self.followed, self.plugged = run, followed, True
        for action in self.on_change:
            action()
