"""The pulses of an axis on the bench: those of a step output, or the encoder counts of a servo motor."""

from collections.abc import Callable, Iterator
from math import floor

from axistwin.core.lazy import NDArray, np
from axistwin.core.units import MS, S
from axistwin.plant.counts import Samples
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.real.standin.step_stream import TOLERANCE_S

MARK_NS = 5 * MS  # Interval at which positions of a servo motor become pulses; its samples are uneven.
THRESHOLD = 0.75  # Part of a count that makes a pulse; above a half, lest pulses go back and forth at rest.
TOLERANCE_PARTS, MOST_TOLERANCE_S = 4, 100e-6
"""Tolerance of counts, whose times are known to a sample of 246 µs: a part of the time between two, and a limit."""

Run = tuple[int, "NDArray[np.int64]"]  # Direction and times of consecutive pulses.


class Steps:
    """Yields the pulses of a stepper axis, read from its step output."""

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
        return self._axis.moving

    def tolerance_s(self, _times: "NDArray[np.int64]") -> float:
        return TOLERANCE_S

    def runs(self) -> Iterator[Run]:
        """Yield the pulses since the last call, in order."""
        begin_ns, self._collected_ns = self._collected_ns, self._axis.clock.now
        return self._axis.train.pulse_runs(begin_ns, self._collected_ns)


class Counts:
    """Converts the encoder counts of a simulated servo axis to step pulses for a real motor.

    The encoder has whole counts and a sample every 246 µs, so the times of its counts are uneven.  A smooth position is
    the mean over `MARK_NS`, at each mark, and a line between two marks; a pulse follows when this position has passed
    three quarters of a count.
    """

    def __init__(self, axis: ServoAxis) -> None:
        self._axis = axis
        self.pulses = axis.position  # Positive pulses that the axis has made, minus the negative ones.
        self._mark_ns = axis.clock.now // MARK_NS * MARK_NS
        self._smooth = float(self.pulses)  # Smooth position at the latest mark.
        self._before = self.pulses  # Position before the first of the samples.
        self._samples: list[Samples] = []
        self._release: Callable[[], None] | None = None
        axis.subscribe(self._samples.append)

    @property
    def moving(self) -> bool:
        return self._axis.moving

    def tolerance_s(self, times: "NDArray[np.int64]") -> float:
        """Return the largest permitted time error of a pulse in seconds, a part of the shortest interval."""
        return min(MOST_TOLERANCE_S, int(np.diff(times).min(initial=S)) / S / TOLERANCE_PARTS)

    def runs(self) -> Iterator[Run]:
        self._axis.catch_up()
        marks = np.arange(self._mark_ns + MARK_NS, self._axis.clock.now - MARK_NS // 2 + 1, MARK_NS, dtype=np.int64)
        if not len(marks):
            return
        way = 0
        times: list[NDArray[np.float64]] = []
        for mark, smooth in zip(marks.tolist(), self._smooth_at(marks).tolist(), strict=True):
            direction, some = self._advance(mark, smooth)
            if direction and direction != way:
                if way:
                    yield way, np.concatenate(times).astype(np.int64)
                way, times = direction, []
            times.append(some)
        if way:
            yield way, np.concatenate(times).astype(np.int64)

    def _smooth_at(self, marks: "NDArray[np.int64]") -> "NDArray[np.float64]":
        """Return the mean position over `MARK_NS` around each mark, and discard the samples before the last one."""
        samples, half = self._samples, MARK_NS // 2
        ends = np.append(marks - half, marks[-1] + half)
        begin = int(ends[0])
        times = [each.start_ns + each.period_ns * np.arange(len(each), dtype=np.int64) for each in samples]
        last = int(max(ends[-1], times[-1][-1] if times else 0))
        at = np.concatenate([[begin], *(np.maximum(each, begin) for each in times), [last]])
        positions = np.concatenate([[self._before], *(np.asarray(each.positions, np.int64) for each in samples)])
        area = np.concatenate([[0.0], np.cumsum(np.diff(at) * (positions - self.pulses))])
        means: NDArray[np.float64] = self.pulses + np.diff(np.interp(ends, at, area)) / MARK_NS
        while samples and samples[0].time_ns(len(samples[0]) - 1) <= ends[-1]:
            self._before = int(samples.pop(0).positions[-1])
        return means

    def _advance(self, mark: int, smooth: float) -> "tuple[int, NDArray[np.float64]]":
        """Return direction and times in ns of the pulses up to `mark`, where the smooth position is `smooth`."""
        first, since = self._smooth, self._mark_ns
        self._smooth, self._mark_ns = smooth, mark
        direction = 1 if smooth > first else -1
        number = floor(direction * (smooth - self.pulses) + 1 - THRESHOLD)
        if number <= 0:
            return 0, np.empty(0)
        passed = self.pulses + direction * (np.arange(number) + THRESHOLD)
        self.pulses += direction * number
        return direction, np.asarray(since + (passed - first) / (smooth - first) * (mark - since), np.float64)

    def hold(self, made: int) -> None:
        """Hold the shaft at `made` pulses, where its real motor has stopped, until `let_go`."""
        axis = self._axis
        axis.catch_up()
        if axis.position != made:
            axis.push(made - axis.position)
        if self._release is None:
            self._release = axis.seize()
        self.pulses = self._before = made
        self._smooth, self._mark_ns = float(made), axis.clock.now
        self._samples.clear()

    def let_go(self) -> None:
        if self._release is not None:
            self._release()
            self._release = None


Motor = Steps | Counts  # An emulated axis whose pulses drive a real motor.


def motor(axis: StepperAxis | ServoAxis) -> Motor:
    return Steps(axis) if isinstance(axis, StepperAxis) else Counts(axis)
