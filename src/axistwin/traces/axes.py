"""What axes have done, as changes of signals.

The pulses of a stepper are worked out from its train when they are to be written; a servo tells its samples, which wait
here.
"""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from axistwin.motion.train import Stroke, Train
from axistwin.plant.counts import Samples
from axistwin.plant.servo_axis import ServoAxis
from axistwin.traces.batch import Part, Rows
from axistwin.units import S

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

STEP_NS = 250
"""How long a step pulse is drawn: shorter than half the period of the fastest controller."""


SHAPES, LONGEST_SHAPE = 8, 1 << 14
"""So many strokes are known by the times of their pulses, if they have no more than that."""


class StepperTrace:
    """The signals of a stepper axis; `places`: which of them are traced, by name."""

    def __init__(self, train: Train, places: Mapping[str, int], now_ns: int) -> None:
        self.train, self._places = train, places
        self.direction = train.stroke.direction
        self.velocity = _rate_at(train.stroke, now_ns)
        self._falls: list[NDArray[np.int64]] = []
        self._shapes: dict[tuple[int, ...], NDArray[np.int64]] = {}
        """When the pulses of strokes that were traced lately are, from their starts on."""

    def first(self, name: str, now_ns: int) -> float:
        """What a signal is to begin with."""
        stroke = self.train.stroke
        values = {"direction": int(self.direction > 0), "pulses": stroke.position_at(now_ns), "velocity": self.velocity}
        return values.get(name, 0)

    def count(self, since_ns: int, before_ns: int) -> int:
        """How many pulses there are from `since_ns` to before `before_ns`."""
        return sum(last - first + 1 for _, first, last in self._stretches(since_ns, before_ns))

    def parts(self, since_ns: int, before_ns: int) -> list[Part]:
        """What has changed in that time."""
        stretches = list(self._stretches(since_ns, before_ns))
        found = []
        if "direction" in self._places:
            found.append(self._part("direction", list(self._directions(stretches, since_ns))))
        if "velocity" in self._places:
            found.append(self._part("velocity", list(self._velocities(stretches, since_ns, before_ns))))
        if "step" in self._places or "pulses" in self._places:
            found += self._pulses([stretch for stretch in stretches if stretch[2] >= stretch[1]], before_ns)
        return found

    def _part(self, name: str, changes: list[tuple[int, float]]) -> Part:
        import numpy as np

        times = np.array([time_ns for time_ns, _ in changes], np.int64)
        values = [value for _, value in changes]
        exact = np.array(values, float).view(np.int64) if name == "velocity" else np.array(values, np.int64)
        return Part(self._places[name], times, exact)

    def _directions(self, stretches: list[tuple[Stroke, int, int]], since_ns: int) -> Iterator[tuple[int, float]]:
        for stroke, _, _ in stretches:
            if stroke.start_ns >= since_ns and stroke.direction != self.direction:
                self.direction = stroke.direction
                yield stroke.start_ns, int(stroke.direction > 0)

    def _velocities(
        self, stretches: list[tuple[Stroke, int, int]], since_ns: int, before_ns: int
    ) -> Iterator[tuple[int, float]]:
        """The rate where a segment begins or the stroke ends; of several at once the last."""
        changes = (change for stroke, _, _ in stretches for change in _rates(stroke))
        rates = {time_ns: rate for time_ns, rate in changes if since_ns <= time_ns < before_ns}
        for time_ns, rate in rates.items():
            if rate != self.velocity:
                self.velocity = rate
                yield time_ns, rate

    def _pulses(self, stretches: list[tuple[Stroke, int, int]], before_ns: int) -> list[Part]:
        import numpy as np

        times, places = [], []
        for stroke, first, last in stretches:
            times.append(self._pulse_times(stroke, first, last))
            places.append(stroke.origin + stroke.direction * np.arange(first, last + 1, dtype=np.int64))
        rises = np.concatenate(times) if times else np.empty(0, np.int64)
        found = []
        if "pulses" in self._places and times:
            found.append(Part(self._places["pulses"], rises, np.concatenate(places)))
        if "step" in self._places:
            found.append(self._steps(rises, before_ns))
        return found

    def _pulse_times(self, stroke: Stroke, first: int, last: int) -> "NDArray[np.int64]":
        """When pulses `first` to `last` are; machines do the same again and again, so that many a shape is known."""
        import numpy as np

        profile, start_ns = stroke.profile, stroke.start_ns
        if profile.pulses is None or profile.pulses > LONGEST_SHAPE:
            at = np.empty(last - first + 1, np.int64)
            profile.fill_pulse_times(first, start_ns, at)
            return at
        key = (profile.ticks, profile.parts, profile.pulses, *profile.rates, *profile.starts, *profile.phases[:1])
        shape = self._shapes.pop(key, None)
        if shape is None:
            shape = np.empty(profile.pulses, np.int64)
            profile.fill_pulse_times(1, 0, shape)
        self._shapes[key] = shape
        if len(self._shapes) > SHAPES:
            del self._shapes[next(iter(self._shapes))]
        return shape[first - 1 : last] + start_ns

    def _steps(self, rises: "NDArray[np.int64]", before_ns: int) -> Part:
        """Up at each pulse, and down again."""
        import numpy as np

        falls = np.concatenate((*self._falls, rises + STEP_NS))
        due = int(np.searchsorted(falls, before_ns))
        self._falls, falls = [falls[due:]], falls[:due]
        times = np.concatenate((falls, rises))
        levels = np.repeat(np.array([0, 1], np.int64), (len(falls), len(rises)))
        order = np.argsort(times, kind="stable")
        return Part(self._places["step"], times[order], levels[order])

    def _stretches(self, since_ns: int, before_ns: int) -> Iterator[tuple[Stroke, int, int]]:
        """The strokes in that time, each with the first and the last of its pulses that fall in it."""
        strokes: list[Stroke] = []
        for stroke in reversed(self.train.strokes):
            if stroke.start_ns < before_ns:
                strokes.append(stroke)
            if stroke.start_ns < since_ns:  # one that begins here may follow on the last pulse of another
                break
        for stroke in reversed(strokes):
            before = stroke.profile.pulses_by(since_ns - 1 - stroke.start_ns)
            yield stroke, before + 1, stroke.profile.pulses_by(before_ns - 1 - stroke.start_ns)


def _rates(stroke: Stroke) -> Iterator[tuple[int, float]]:
    """When a stroke takes another rate, and which, in pulses per second; 0 at its end."""
    profile, direction = stroke.profile, stroke.direction
    for start, rate in zip(profile.starts, profile.rates, strict=False):
        yield stroke.start_ns + start * S // profile.ticks, direction * (rate / profile.per_rate)
    if stroke.end_ns is not None:
        yield stroke.end_ns, 0.0


def _rate_at(stroke: Stroke, time_ns: int) -> float:
    past = [rate for start_ns, rate in _rates(stroke) if start_ns <= time_ns]
    return past[-1] if past else 0.0


class ServoTrace:
    """The signals of a servo axis; `places`: which of them are traced, by name."""

    def __init__(self, axis: ServoAxis, places: Mapping[str, int]) -> None:
        self.axis, self._places = axis, places
        self._last = {"position": axis.position, "commanded": axis.position}  # at rest it is where it should be
        self.rows = Rows(3)

    def first(self, name: str) -> int:
        """What a signal is to begin with."""
        return self._last[name]

    def take(self, samples: Samples) -> None:
        """What has been."""
        import numpy as np

        times = samples.start_ns + samples.period_ns * np.arange(len(samples), dtype=np.int64)
        self.rows.add(times, samples.positions, samples.commanded)

    def parts(self, _since_ns: int, before_ns: int) -> list[Part]:
        """What has changed before a time."""
        times, positions, commanded = self.rows.take(before_ns)
        if not len(times):
            return []
        values = {"position": positions, "commanded": commanded}
        return [self._part(name, times, values[name]) for name in self._places]

    def _part(self, name: str, times: "NDArray[np.int64]", values: "NDArray[np.int64]") -> Part:
        """The samples that bring a change."""
        import numpy as np

        changed = np.diff(values, prepend=self._last[name]) != 0
        self._last[name] = int(values[-1])
        return Part(self._places[name], times[changed], values[changed])
