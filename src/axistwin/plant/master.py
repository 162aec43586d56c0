"""The external encoder, or step source, whose two lines are wired to pins A and B of a servo motor."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import floor
from typing import NamedTuple, Protocol

from axistwin.core.errors import UsageError
from axistwin.core.numbers import shortened
from axistwin.core.units import to_ns
from axistwin.sim.clock import Clock
from axistwin.sim.manual_actions import ManualAct, ManualActions, check_counts
from axistwin.sim.signal import Signal

MOST_RATIO = 1_000_000  # Maximum number of counts per unit of the axis on which the encoder is mounted.


class Followed(Protocol):
    """Interface of an axis on which a master encoder can be mounted."""

    on_motion: Signal[[]]  # Event: the axis begins to move, or changes its profile.
    on_replan: Signal[[]]  # Event: positions that `positions_ahead` has returned for later times are no longer certain.

    @property
    def position(self) -> int: ...

    @property
    def resting(self) -> bool:
        """True if the axis is at rest.  The axis then moves only after the next event `on_motion`."""

    @property
    def predictable(self) -> bool:
        """True if `positions_at` can predict the axis's positions, up to the next `on_motion`."""

    @property
    def follows(self) -> "Followed | None":
        """The axis that turns the external encoder of this axis; None if no axis turns the encoder."""

    def subscribe_edges(self, edges: Sequence[int], callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` at each crossing of `edges`; edge n lies between the positions n-1 and n."""

    def positions_at(self, times_ns: Sequence[int]) -> Sequence[int]:
        """Return the predicted positions at these times, in order, without further changes."""

    def positions_ahead(self, times_ns: range) -> Sequence[int]:
        """Return the position now, and the certain ones at `times_ns`, which are valid until `on_replan`."""


class Run(NamedTuple):
    """A motion at constant speed: `counts` edges from count `base` on, in `duration_ns` from `start_ns` on."""

    start_ns: int
    base: int
    counts: int
    duration_ns: int

    @property
    def end_ns(self) -> int:
        return self.start_ns + self.duration_ns

    def at(self, time_ns: int) -> int:
        """Return the count at a time not before the start.

        The n-th edge comes `n * duration_ns / |counts|` after the start, or in the first nanosecond after that.
        """
        if time_ns >= self.end_ns:
            return self.base + self.counts
        edges = abs(self.counts) * (time_ns - self.start_ns) // self.duration_ns
        return self.base + (edges if self.counts > 0 else -edges)


class Master:
    """The device wired to pins A and B: a quadrature encoder, or a step source.

    Edges cause no events: the count is calculated on demand, and the levels of A and B follow from the count. `own`:
    the axis of the motor that the device is wired to.
    """

    def __init__(self, clock: Clock, own: Followed | None = None) -> None:
        self.clock, self._own = clock, own
        self.run = Run(clock.now, 0, 0, 0)  # The latest motion at constant speed; it may be finished.
        self.followed: Followed | None = None  # The axis that the encoder is mounted on.
        self.ratio = Fraction(1)  # Edges per unit of the axis that the encoder is mounted on.
        self._unsubscribe: Callable[[], object] = lambda: None
        self.plugged = False  # True after the first use of the encoder; pins A and B are open before.
        self.manual_actions = ManualActions(clock)
        """Reports a person's moves of the encoder: `master`, counts and seconds; or its axis, and the ratio."""
        self.before_change: Signal[[]] = Signal()  # Event: about to change; `at` returns old counts.
        self.on_change: Signal[[]] = Signal()
        self.on_replan: Signal[[]] = Signal()  # Event: later counts of `read_ahead` are no longer certain.

    @property
    def count(self) -> int:
        """Net quadrature edges (or steps) in the positive direction, from 0 when the bench was made."""
        return self.at(self.clock.now)

    @property
    def moving(self) -> bool:
        """True while the encoder turns, or is mounted on an axis, which may turn it at any time."""
        return self.followed is not None or (self.run.counts != 0 and self.clock.now < self.run.end_ns)

    @property
    def predictable(self) -> bool:
        """True if an axis turns the encoder and the axis's positions can be predicted."""
        return self.followed is not None and self.followed.predictable

    def predict(self, first_ns: int, period_ns: int, number: int) -> list[int]:
        """Predict `number` counts from `first_ns` on, one every `period_ns`; the axis must be `predictable`."""
        assert self.followed is not None, "the encoder is mounted on an axis"
        times_ns = range(first_ns, first_ns + number * period_ns, period_ns)
        ratio, base = self.ratio, self.run.base
        return [base + p * ratio.numerator // ratio.denominator for p in self.followed.positions_at(times_ns)]

    def read_ahead(self, times_ns: range, offset: int) -> list[int]:
        """Return the counts plus `offset` now and at the first of these times, as far as they are certain."""
        if self.followed is None:
            return [self.count + offset]
        numerator, denominator, base = self.ratio.numerator, self.ratio.denominator, self.run.base + offset
        return [base + p * numerator // denominator for p in self.followed.positions_ahead(times_ns)]

    def at(self, time_ns: int) -> int:
        """Return the count at `time_ns` in the present motion; the present count if an axis turns the encoder."""
        if self.followed is not None:
            return self.run.base + floor(self.followed.position * self.ratio)
        return self.run.at(time_ns)

    def move(self, counts: int, seconds: float) -> None:
        """Turn by 4000 counts in 2 seconds, in 0 seconds at once, instead of an earlier motion.  Raises UsageError."""
        check_counts(counts, "move")
        if not 0 <= seconds < float("inf"):
            raise UsageError(f"invalid time in move({counts}, {seconds!r}): expected 0 seconds or more")
        duration_ns = to_ns(seconds)
        self.manual_actions.report(ManualAct.MASTER, counts, seconds)
        count = self.count
        self._unsubscribe()
        self._unsubscribe = lambda: None
        self._change(Run(self.clock.now, count, counts, duration_ns), None)

    def follow(self, axis: Followed, ratio: Fraction | int = 1) -> None:
        """Mount the encoder on the shaft of an axis, with `ratio` edges per count or pulse.

        Raises UsageError for a ratio beyond a million, and for an axis that depends on the motor.
        """
        if not -MOST_RATIO <= ratio <= MOST_RATIO:
            raise UsageError(
                f"invalid ratio {shortened(str(ratio))} of encoder position to axis position: "
                f"expected {-MOST_RATIO} to {MOST_RATIO}, e.g. 3/2"
            )
        self._check_no_circle(axis)
        self.manual_actions.report(ManualAct.MASTER, axis, Fraction(ratio))
        base = self.count - floor(axis.position * Fraction(ratio))
        self._unsubscribe()
        self.ratio = Fraction(ratio)
        unsubscribe = axis.on_motion.subscribe(self._moves), axis.on_replan.subscribe(self.on_replan.emit)
        self._unsubscribe = lambda: [undo() for undo in unsubscribe]
        self._change(Run(self.clock.now, base, 0, 0), axis)

    def _check_no_circle(self, axis: Followed) -> None:
        below: Followed | None = axis
        while below is not None:
            if below is self._own:
                refused_axis = "the motor's own axis" if axis is self._own else "an axis that follows this motor"
                raise UsageError(
                    f"a motor's external encoder cannot be mounted on {refused_axis}: "
                    "expected an axis whose motion does not depend on this motor, e.g. axis X of an IF1"
                )
            below = below.follows

    def stop(self) -> None:
        """Stop the encoder, and detach it from its axis."""
        self.move(0, 0)

    def _moves(self) -> None:
        self._change(self.run, self.followed)

    def _change(self, run: Run, followed: Followed | None) -> None:
        self.before_change.emit()
        self.run, self.followed, self.plugged = run, followed, True
        self.on_change.emit()
