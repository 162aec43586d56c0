"""The pulses of an axis on the bench: those of a step output, or the encoder counts of a servo motor."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Protocol

from axistwin.plant import Samples, ServoAxis, StepperAxis
from axistwin.units import MS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MARK_NS = 5 * MS
"""Interval at which the position of a servo motor becomes pulses: its samples alone would be an uneven pulse train."""

Run = tuple[int, "NDArray[np.int64]"]
"""Direction and times of consecutive pulses."""


class Motor(Protocol):
    """An axis on the bench whose pulses drive a real motor."""

    @property
    def pulses(self) -> int:
        """Net pulses up to now."""

    @property
    def moving(self) -> bool:
        """True if a move is in progress."""

    def runs(self) -> Iterator[Run]:
        """Yield the pulses since the last call, in order."""

    def hold(self, made: int) -> None:
        """Hold the axis at this net number of pulses, where the real motor has stopped, until `let_go`."""

    def let_go(self) -> None:
        """Release a held axis."""


def motor(axis: StepperAxis | ServoAxis) -> Motor:
    """Return the pulses of an axis."""
    return Steps(axis) if isinstance(axis, StepperAxis) else Counts(axis)


class Steps:
    """The pulses of a step output."""

    def __init__(self, axis: StepperAxis) -> None:
        self._axis = axis
        self._collected_ns = axis.clock.now
        self.hold, self.let_go = axis.hold, axis.let_go

    @property
    def pulses(self) -> int:
        """Net pulses up to now."""
        return self._axis.pulses

    @property
    def moving(self) -> bool:
        """True if a move is in progress."""
        return self._axis.moving

    def runs(self) -> Iterator[Run]:
        """Yield the pulses since the last call, in order."""
        begin_ns, self._collected_ns = self._collected_ns, self._axis.clock.now
        return self._axis.train.pulse_runs(begin_ns, self._collected_ns)


class Counts:
    """The encoder counts of a servo motor as pulses, spread evenly between two marks."""

    def __init__(self, axis: ServoAxis) -> None:
        self._axis = axis
        self.pulses = axis.position
        """Position at the latest mark."""
        self._mark_ns = axis.clock.now // MARK_NS * MARK_NS
        self._samples: list[Samples] = []
        self._release: Callable[[], None] | None = None
        axis.subscribe(self._samples.append)

    @property
    def moving(self) -> bool:
        """True if the shaft turns or a trajectory is in progress."""
        return self._axis.moving

    def runs(self) -> Iterator[Run]:
        """Yield the pulses from the mark of the last call to the latest mark, in order."""
        import numpy as np

        self._axis.catch_up()
        marks = np.arange(self._mark_ns + MARK_NS, self._axis.clock.now + 1, MARK_NS, dtype=np.int64)
        if not len(marks):
            return
        before, self._mark_ns = self.pulses, int(marks[-1])
        steps = np.diff(self._positions(marks), prepend=before)
        for direction, some in _by_direction(steps):
            yield direction, _spread(marks[some], np.abs(steps[some]))

    def _positions(self, marks: "NDArray[np.int64]") -> "NDArray[np.int64]":
        """Return the positions at these marks, and drop the samples up to the last mark."""
        import numpy as np

        samples, last = self._samples, int(marks[-1])
        times = [each.start_ns + each.period_ns * np.arange(len(each), dtype=np.int64) for each in samples]
        known = np.concatenate([[-1], *times])
        positions = np.concatenate([[self.pulses], *(np.asarray(each.positions, np.int64) for each in samples)])
        found: NDArray[np.int64] = positions[np.searchsorted(known, marks, side="right") - 1]
        samples[:] = [each for each in samples if each.time_ns(len(each) - 1) > last]
        self.pulses = int(found[-1])
        return found

    def hold(self, made: int) -> None:
        """Block the shaft at this position, where the real motor has stopped, until `let_go`."""
        axis = self._axis
        axis.catch_up()
        if axis.position != made:
            axis.push(made - axis.position)
        if self._release is None:
            self._release = axis.seize()
        self.pulses, self._mark_ns = made, axis.clock.now
        self._samples.clear()

    def let_go(self) -> None:
        """Release a blocked shaft."""
        if self._release is not None:
            self._release()
            self._release = None


def _by_direction(steps: "NDArray[np.int64]") -> "Iterator[tuple[int, NDArray[np.intp]]]":
    """Yield direction and indices of consecutive steps in one direction; 0 belongs to any direction."""
    import numpy as np

    moved = np.flatnonzero(steps)
    if len(moved):
        turns = np.flatnonzero(np.diff(np.sign(steps[moved]))) + 1
        for some in np.split(moved, turns):
            yield int(np.sign(steps[some[0]])), some


def _spread(marks: "NDArray[np.int64]", counts: "NDArray[np.int64]") -> "NDArray[np.int64]":
    """Return the times of these counts, spread evenly over the interval before each mark."""
    import numpy as np

    first = np.cumsum(counts) - counts
    number = np.arange(1, int(counts.sum()) + 1, dtype=np.int64) - np.repeat(first, counts)
    times: NDArray[np.int64] = np.repeat(marks - MARK_NS, counts) + MARK_NS * number // np.repeat(counts, counts)
    return times
