"""The external encoder, or step source, whose two lines are wired to pins A and B of a servo motor."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import floor
from typing import NamedTuple, Protocol

from axistwin.errors import UsageError
from axistwin.numbers import shortened
from axistwin.sim.clock import Clock
from axistwin.sim.manual_actions import ManualAct, ManualActions, check_counts
from axistwin.sim.signal import Signal
from axistwin.units import to_ns

MOST_RATIO = 1_000_000
"""Maximum number of counts per unit of the axis on which the encoder is mounted."""


class Followed(Protocol):
    """Interface of an axis on which a master encoder can be mounted."""

    on_motion: Signal[[]]
    """Event: the axis begins to move, or changes its profile."""
    on_replan: Signal[[]]
    """Event: positions that `positions_ahead` has returned for later times are no longer certain."""

    @property
    def position(self) -> int:
        """Position of the axis in pulses or counts."""

    @property
    def resting(self) -> bool:
        """True if the axis is at rest.

        The axis then moves only after the next event `on_motion`.
        """

    @property
    def predictable(self) -> bool:
        """True if `positions_at` can predict the positions of the axis.

        The prediction is valid until the next `on_motion`.
        """

    @property
    def follows(self) -> "Followed | None":
        """The axis that turns the external encoder of this axis; None if no axis turns the encoder."""

    def subscribe_edges(self, edges: Sequence[int], callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` each time the axis crosses a position in `edges`, in either direction.

        Edge n lies between the positions n-1 and n.
        """

    def positions_at(self, times_ns: Sequence[int]) -> Sequence[int]:
        """Predict the positions of the axis at the times `times_ns`, which must be in ascending order.

        The prediction is for a motion that does not change.
        """

    def positions_ahead(self, times_ns: range) -> Sequence[int]:
        """Return the present position of the axis, followed by its predicted positions at the times `times_ns`.

        Only certain positions are predicted.  The predictions are valid until `on_replan`.
        """


class Run(NamedTuple):
    """A motion at constant speed, with evenly spaced encoder edges.

    The `counts` edges begin at count `base`, and take `duration_ns` from `start_ns` on.
    """

    start_ns: int
    base: int
    counts: int
    duration_ns: int

    @property
    def end_ns(self) -> int:
        """Time of the end of the motion, in ns.  The last encoder edge is at this time."""
        return self.start_ns + self.duration_ns

    def at(self, time_ns: int) -> int:
        """Calculate the encoder count at the time `time_ns`, for an encoder that turns at constant speed.

        After the end of the motion, the count stays the same.

        The n-th edge occurs `n * duration_ns / |counts|` after the start, rounded up to a whole nanosecond.  The
        count is therefore rounded towards `base`, in either direction.
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
        self.run = Run(clock.now, 0, 0, 0)
        """The latest motion at constant speed; it may be finished."""
        self.followed: Followed | None = None
        """The axis that the encoder is mounted on; its positions can be predicted if it is `predictable`."""
        self._ratio = Fraction(1)
        self._unsubscribe: Callable[[], object] = lambda: None
        self.plugged = False
        """True after the first use of the encoder; pins A and B are open before."""
        self.manual_actions = ManualActions(clock)
        """Reports a person's moves of the encoder: `master`, counts and seconds; or its axis, and the ratio."""
        self.before_change: Signal[[]] = Signal()
        """Event: the motion is about to change; `at` still returns counts of the old motion."""
        self.on_change: Signal[[]] = Signal()
        self.on_replan: Signal[[]] = Signal()
        """Event: counts that `read_ahead` has returned for later times are no longer certain."""

    @property
    def count(self) -> int:
        """Encoder count after quadrature decoding, initially 0.

        For a step source instead of an encoder: the number of steps; a negative step counts as -1.
        """
        return self.at(self.clock.now)

    @property
    def ratio(self) -> Fraction:
        """Gear ratio: encoder edges per pulse of a stepper axis, or per count of a servo axis.

        The encoder is mounted on this axis.  Without such an axis, the ratio has no effect.
        """
        return self._ratio

    @property
    def moving(self) -> bool:
        """True while the encoder turns.

        Also True while the encoder is mounted on an axis that stands still: the axis can turn the encoder at any time.
        """
        return self.followed is not None or (self.run.counts != 0 and self.clock.now < self.run.end_ns)

    @property
    def predictable(self) -> bool:
        """True if the positions of the axis that turns the encoder can be predicted.

        False if no axis turns the encoder.
        """
        return self.followed is not None and self.followed.predictable

    def predict(self, first_ns: int, period_ns: int, number: int) -> list[int]:
        """Predict encoder counts at equal intervals of time.

        Returns `number` counts: the first at `first_ns`, then one every `period_ns`.

        The encoder must be mounted on an axis that is `predictable`.
        """
        assert self.followed is not None, "the encoder is mounted on an axis"
        times_ns = range(first_ns, first_ns + number * period_ns, period_ns)
        ratio, base = self._ratio, self.run.base
        return [base + p * ratio.numerator // ratio.denominator for p in self.followed.positions_at(times_ns)]

    def read_ahead(self, times_ns: range, offset: int) -> list[int]:
        """Return a list: the present encoder count, followed by the predicted encoder counts.

        The predictions are for `times_ns`, as long as they are certain.  Each count is increased by `offset`.
        """
        if self.followed is None:
            return [self.count + offset]
        numerator, denominator, base = self._ratio.numerator, self._ratio.denominator, self.run.base + offset
        return [base + p * numerator // denominator for p in self.followed.positions_ahead(times_ns)]

    def at(self, time_ns: int) -> int:
        """Return the encoder count at `time_ns`, calculated from the present motion.

        If an axis turns the encoder, return the present count.
        """
        if self.followed is not None:
            return self.run.base + floor(self.followed.position * self._ratio)
        return self.run.at(time_ns)

    def move(self, counts: int, seconds: float) -> None:
        """Turn the encoder at constant speed, e.g. by 4000 counts in 2 seconds.

        With 0 seconds, all counts occur at once.

        Cancels an earlier motion.  Raises UsageError for a negative time.
        """
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
        """Mount the encoder on the shaft of an axis, so that the axis turns the encoder.

        The encoder outputs `ratio` edges per count or pulse of the axis.

        Raises UsageError for a ratio beyond a million, and for an axis that is the motor's own or follows the motor,
        because the two would depend on each other.
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
        self._ratio = Fraction(ratio)
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
        """Stop the rotation of the external encoder.

        An encoder that is mounted on an axis is detached from the axis.
        """
        self.move(0, 0)

    def _moves(self) -> None:
        """Emit the events `before_change` and `on_change` of the encoder.

        Called when the axis that turns the encoder changes its motion.
        """
        self._change(self.run, self.followed)

    def _change(self, run: Run, followed: Followed | None) -> None:
        self.before_change.emit()
        self.run, self.followed, self.plugged = run, followed, True
        self.on_change.emit()
