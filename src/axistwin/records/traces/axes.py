"""Traces of axes: find the changes of their signals.

The pulses of a stepper axis are calculated from its moves when a trace is written.  The samples of a servo axis are
stored until a trace is written.
"""

from collections.abc import Iterator, Mapping

from axistwin.core.lazy import NDArray, np
from axistwin.core.units import S
from axistwin.plant.counts import Samples
from axistwin.plant.servo_axis import ServoAxis
from axistwin.records.traces.batch import Part, Rows
from axistwin.sim.motion.train import Move, Train

STEP_NS = 250  # Width of a step pulse in a trace: less than half the shortest period of all controllers.

CACHED_MOVES, MOST_CACHED_PULSES = 8, 1 << 14
"""Number of moves whose pulse times are cached, and largest number of pulses of such a move."""


class StepperTrace:
    """Finds the changes in the signals of a stepper axis.  `places`: index of each traced signal, by name."""

    def __init__(self, train: Train, places: Mapping[str, int], now_ns: int) -> None:
        self.train, self._places = train, places
        self.direction = train.move.direction
        self.velocity = _rate_at(train.move, now_ns)
        self._falls: list[NDArray[np.int64]] = []
        self._cached_times: dict[tuple[int, ...], NDArray[np.int64]] = {}
        """Cached pulse times of recent moves, relative to their starts."""

    def first(self, name: str, now_ns: int) -> float:
        move = self.train.move
        values = {"direction": int(self.direction > 0), "pulses": move.position_at(now_ns), "velocity": self.velocity}
        return values.get(name, 0)

    def count(self, since_ns: int, before_ns: int) -> int:
        return sum(last - first + 1 for _, first, last in self._moves(since_ns, before_ns))

    def parts(self, since_ns: int, before_ns: int) -> list[Part]:
        moves = list(self._moves(since_ns, before_ns))
        found = []
        if "direction" in self._places:
            found.append(self._part("direction", list(self._directions(moves, since_ns))))
        if "velocity" in self._places:
            found.append(self._part("velocity", list(self._velocities(moves, since_ns, before_ns))))
        if "step" in self._places or "pulses" in self._places:
            found += self._pulses([move for move in moves if move[2] >= move[1]], before_ns)
        return found

    def _part(self, name: str, changes: list[tuple[int, float]]) -> Part:
        times = np.array([time_ns for time_ns, _ in changes], np.int64)
        values = [value for _, value in changes]
        exact = np.array(values, float).view(np.int64) if name == "velocity" else np.array(values, np.int64)
        return Part(self._places[name], times, exact)

    def _directions(self, moves: list[tuple[Move, int, int]], since_ns: int) -> Iterator[tuple[int, float]]:
        for move, _, _ in moves:
            if move.start_ns >= since_ns and move.direction != self.direction:
                self.direction = move.direction
                yield move.start_ns, int(move.direction > 0)

    def _velocities(
        self, moves: list[tuple[Move, int, int]], since_ns: int, before_ns: int
    ) -> Iterator[tuple[int, float]]:
        changes = (change for move, _, _ in moves for change in _rates(move))
        rates = {time_ns: rate for time_ns, rate in changes if since_ns <= time_ns < before_ns}
        for time_ns, rate in rates.items():
            if rate != self.velocity:
                self.velocity = rate
                yield time_ns, rate

    def _pulses(self, moves: list[tuple[Move, int, int]], before_ns: int) -> list[Part]:
        times, places = [], []
        for move, first, last in moves:
            times.append(self._pulse_times(move, first, last))
            places.append(move.origin + move.direction * np.arange(first, last + 1, dtype=np.int64))
        rises = np.concatenate(times) if times else np.empty(0, np.int64)
        found = []
        if "pulses" in self._places and times:
            found.append(Part(self._places["pulses"], rises, np.concatenate(places)))
        if "step" in self._places:
            found.append(self._steps(rises, before_ns))
        return found

    def _pulse_times(self, move: Move, first: int, last: int) -> "NDArray[np.int64]":
        """Return the times of pulses `first` to `last`.  Times are cached, because machines repeat their moves."""
        profile, start_ns = move.profile, move.start_ns
        if profile.pulses is None or profile.pulses > MOST_CACHED_PULSES:
            at = np.empty(last - first + 1, np.int64)
            profile.fill_pulse_times(first, start_ns, at)
            return at
        key = (profile.ticks, profile.parts, profile.pulses, *profile.rates, *profile.starts, *profile.phases[:1])
        cached = self._cached_times.pop(key, None)
        if cached is None:
            cached = np.empty(profile.pulses, np.int64)
            profile.fill_pulse_times(1, 0, cached)
        self._cached_times[key] = cached
        if len(self._cached_times) > CACHED_MOVES:
            del self._cached_times[next(iter(self._cached_times))]
        return cached[first - 1 : last] + start_ns

    def _steps(self, rises: "NDArray[np.int64]", before_ns: int) -> Part:
        falls = np.concatenate((*self._falls, rises + STEP_NS))
        due = int(np.searchsorted(falls, before_ns))
        self._falls, falls = [falls[due:]], falls[:due]
        times = np.concatenate((falls, rises))
        levels = np.repeat(np.array([0, 1], np.int64), (len(falls), len(rises)))
        order = np.argsort(times, kind="stable")
        return Part(self._places["step"], times[order], levels[order])

    def _moves(self, since_ns: int, before_ns: int) -> Iterator[tuple[Move, int, int]]:
        moves: list[Move] = []
        for move in reversed(self.train.moves):
            if move.start_ns < before_ns:
                moves.append(move)
            # The last pulse of a move can have the same time as the start of the next move.
            if move.start_ns < since_ns:
                break
        for move in reversed(moves):
            before = move.profile.pulses_by(since_ns - 1 - move.start_ns)
            yield move, before + 1, move.profile.pulses_by(before_ns - 1 - move.start_ns)


def _rates(move: Move) -> Iterator[tuple[int, float]]:
    """Yield start times in ns and velocities in pulses/s of a move's segments; 0 follows at its end."""
    profile, direction = move.profile, move.direction
    for start, rate in zip(profile.starts, profile.rates, strict=False):
        yield move.start_ns + start * S // profile.ticks, direction * (rate / profile.per_rate)
    if move.end_ns is not None:
        yield move.end_ns, 0.0


def _rate_at(move: Move, time_ns: int) -> float:
    past = [rate for start_ns, rate in _rates(move) if start_ns <= time_ns]
    return past[-1] if past else 0.0


class ServoTrace:
    """Collects the changes in the signals of a servo axis.  `places`: index of each traced signal, by name."""

    def __init__(self, axis: ServoAxis, places: Mapping[str, int]) -> None:
        self.axis, self._places = axis, places
        # At the start of a trace, assume that the commanded position equals the actual position.
        self._last = {"position": axis.position, "commanded": axis.position}
        self.rows = Rows(3)

    def first(self, name: str) -> int:
        return self._last[name]

    def add_samples(self, samples: Samples) -> None:
        times = samples.start_ns + samples.period_ns * np.arange(len(samples), dtype=np.int64)
        self.rows.add(times, samples.positions, samples.commanded)

    def parts(self, _since_ns: int, before_ns: int) -> list[Part]:
        """Return the collected signal changes that happened before the time `before_ns`.

        The signals are the position and the commanded position.  The samples before this time are then deleted.
        """
        times, positions, commanded = self.rows.take(before_ns)
        if not len(times):
            return []
        values = {"position": positions, "commanded": commanded}
        return [self._part(name, times, values[name]) for name in self._places]

    def present(self, now_ns: int) -> list[Part]:
        """Return the present values that differ from the last sample, because a command has changed them since."""
        values = {"position": self.axis.position, "commanded": self.axis.setpoint}
        changed = {name: value for name in self._places if (value := values[name]) != self._last[name]}
        self._last |= changed
        at = np.array([now_ns], np.int64)
        return [Part(self._places[name], at, np.array([value], np.int64)) for name, value in changed.items()]

    def _part(self, name: str, times: "NDArray[np.int64]", values: "NDArray[np.int64]") -> Part:
        changed = np.diff(values, prepend=self._last[name]) != 0
        self._last[name] = int(values[-1])
        return Part(self._places[name], times[changed], values[changed])
