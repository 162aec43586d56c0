"""Record one run for the measures and claims of a sweep: the changes of signals, and the times of events.

All signals of a trace can be recorded (`docs/traces.md`), and these signals of an axis:

    position, lost            of a stepper motor: actual position in steps, and number of lost steps
    velocity                  of a servo: counts per second over the latest sample
    following_error           of a servo: commanded minus actual position, in counts
"""

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from types import TracebackType
from typing import Any, Self

import numpy as np

from axistwin.bench import Bench
from axistwin.core.errors import UsageError, instead
from axistwin.core.units import S
from axistwin.plant.counts import Samples
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.records.traces.batch import Part
from axistwin.records.traces.signals import REAL, STEP, TEXT, Signal, catalogue
from axistwin.records.traces.trace import Tracer
from axistwin.sim.motion.profile import Profile
from axistwin.sweeps.series import Series, Times, combined

SERVO = {"velocity": ("position",), "following_error": ("commanded", "position")}
STEPPER: dict[str, tuple[str, ...]] = {"position": ("pulses",), "lost": ()}
"""Computed signals of an axis, each with the signals of a trace that it is computed from."""


@dataclass(frozen=True)
class _LostSteps:
    """Number of lost steps from the time `since_ns`; `losing` (or None) returns the number after n more pulses."""

    since_ns: int
    lost: int
    move_ns: int
    profile: Profile
    losing: Callable[[int], int] | None

    def changes(self, until_ns: int) -> tuple[Times, list[int]]:
        """Return the times from `since_ns` up to, but not including, `until_ns`, and the lost steps at these times."""
        if self.losing is None:
            return np.array([self.since_ns], np.int64), [self.lost]
        first = self.profile.pulses_by(self.since_ns - 1 - self.move_ns) + 1
        last = self.profile.pulses_by(until_ns - 1 - self.move_ns)
        times = np.empty(max(0, last - first + 1) + 1, np.int64)
        times[0] = self.since_ns
        self.profile.fill_pulse_times(first, self.move_ns, times[1:])
        return times, [self.lost, *(self.losing(n) for n in range(first, last + 1))]


class Recording:
    """A context manager that records signals and events during a run."""

    def __init__(self, bench: Bench, signals: Iterable[str], events: Iterable[str]) -> None:
        self.bench = bench
        self.end_ns = bench.now
        self._here = next(iter(bench.controllers)) if len(bench.controllers) == 1 else ""
        self._known = {signal.full: signal for signal in catalogue(bench) if signal.kind not in (STEP, TEXT)}
        self._also = {f"{s.scope}.{name}": s.full for s in self._known.values() for name in s.also}
        self._names = {name: self._full(name) for name in signals}
        self._events: dict[str, list[int]] = {sentence: [] for sentence in events}
        self._plans: dict[str, list[_LostSteps]] = {}
        self._periods: dict[str, int] = {}  # Sample period of each servo axis in ns.
        wanted = {part for name in self._names.values() for part in self._parts(name)}
        self._signals = [signal for name, signal in self._known.items() if name in wanted]
        self._stack = ExitStack()
        self._blocks: list[list[Part]] = [[] for _ in self._signals]

    def __enter__(self) -> Self:
        """Start recording signals and events.  Raises UsageError for an event that cannot occur in this scene."""
        for sentence, times in self._events.items():
            self._stack.callback(self.bench.when(sentence, partial(self._happened, times), self._here))
        for name in self._names.values():
            scope, _, which = name.rpartition(".")
            axis = self._axis(scope)
            if isinstance(axis, StepperAxis) and which in STEPPER and scope not in self._plans:
                self._plans[scope] = []
                self._note_plan(scope, axis)
                self._stack.callback(axis.on_motion.subscribe(partial(self._note_plan, scope, axis)))
            elif isinstance(axis, ServoAxis) and which == "velocity":
                self._stack.callback(axis.subscribe(partial(self._note_period, scope)))
        if self._signals:
            self._tracer = Tracer(self.bench, self._signals)
            self._tracer.consumer, self._tracer.at_moves = self._take, True
            self._first = self._tracer.first()
            self._stack.enter_context(self._tracer)
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        if kind is None:
            self.end_ns = self.bench.now
            if self._signals:
                self._tracer.finish()
        self._stack.close()

    def series(self, name: str) -> Series:
        """Return a recorded signal; call this method after the run."""
        return self._series(self._names[name])

    def times(self, sentence: str) -> Times:
        return np.array(self._events[sentence], np.int64)

    def energy(self, name: str) -> float:
        """Return the energy in J that an axis has used.  Raises UsageError without a model of its windings."""
        axes = {f"{scope}.{n}": axis for scope, each in self.bench.controllers.items() for n, axis in each.axes.items()}
        axis = axes.get(name) or axes.get(f"{self._here}.{name}")
        if axis is None:
            raise UsageError(f"the scene has no axis {name!r}: {instead(name, [*axes])}")
        if not isinstance(axis, ServoAxis) or axis.motor is None:
            raise UsageError(
                f"the energy of axis {name} is unknown: expected a servo axis with motor data in the scene file, "
                "e.g. motor = 'frame23'"
            )
        return axis.energy

    def _happened(self, times: list[int]) -> None:
        times.append(self.bench.now)

    def _note_plan(self, scope: str, axis: StepperAxis) -> None:
        move = axis.train.move
        self._plans[scope].append(_LostSteps(self.bench.now, axis.lost, move.start_ns, move.profile, axis.losing()))

    def _note_period(self, scope: str, samples: Samples) -> None:
        if samples.period_ns:
            self._periods[scope] = samples.period_ns

    def _take(self, parts: list[Part], _: list[bytes]) -> None:
        for part in parts:
            self._blocks[part.signal].append(part)

    # Names of signals

    def _full(self, name: str) -> str:
        for candidate in (name, f"{self._here}.{name}"):
            if candidate in self._known or self._parts(candidate) != (candidate,):
                return candidate
            if candidate in self._also:
                return self._also[candidate]
        raise UsageError(f"the scene has no signal {name!r}: {instead(name, [*self._known, *self._derived()])}")

    def _derived(self) -> list[str]:
        found = []
        for controller in self.bench.controllers.values():
            for axis_name, axis in controller.axes.items():
                table = SERVO if isinstance(axis, ServoAxis) else STEPPER
                found += [f"{controller.name}.{axis_name}.{name}" for name in table]
        return found

    def _parts(self, name: str) -> tuple[str, ...]:
        if name in self._known:
            return (name,)
        scope, _, which = name.rpartition(".")
        axis = self._axis(scope)
        table = {} if axis is None else SERVO if isinstance(axis, ServoAxis) else STEPPER
        return tuple(f"{scope}.{part}" for part in table[which]) if which in table else (name,)

    def _axis(self, scope: str) -> Any:
        controller, _, axis = scope.rpartition(".")
        found = self.bench.controllers.get(controller)
        return None if found is None else found.axes.get(axis)

    # Values of signals

    def _series(self, name: str) -> Series:
        if name in self._known:
            return self._traced(name)
        scope, _, which = name.rpartition(".")
        if which == "following_error":
            return combined(np.subtract, self._traced(f"{scope}.commanded"), self._traced(f"{scope}.position"))
        if which == "velocity":
            return self._velocity(scope)
        lost = self._lost_of(scope)
        return lost if which == "lost" else combined(np.subtract, self._traced(f"{scope}.pulses"), lost)

    def _traced(self, name: str) -> Series:
        number = next(n for n, signal in enumerate(self._signals) if signal.full == name)
        signal: Signal = self._signals[number]
        first = self._first[number]
        assert not isinstance(first, bytes), "texts are not measured"
        blocks = self._blocks[number]
        times = np.concatenate([np.zeros(1, np.int64), *(part.times for part in blocks)])
        given = (part.values.view(float) if signal.kind == REAL else part.values for part in blocks)
        values = np.concatenate([np.array([first], float), *(each.astype(float) for each in given)])
        return Series.of(times, values, self.end_ns)

    def _lost_of(self, scope: str) -> Series:
        plans = self._plans[scope]
        ends = [*(plan.since_ns for plan in plans[1:]), self.end_ns + 1]
        times, values = zip(*[plan.changes(end_ns) for plan, end_ns in zip(plans, ends, strict=True)], strict=True)
        return Series.of(np.concatenate(times), np.concatenate(values).astype(float), self.end_ns)

    def _velocity(self, scope: str) -> Series:
        position, period_ns = self._traced(f"{scope}.position"), self._periods.get(scope, S)
        moved, ways = position.times[1:], np.diff(position.values)
        ends = moved + period_ns
        rests = np.diff(moved, append=self.end_ns + 2 * period_ns) > period_ns
        starts = np.concatenate((np.zeros(1, np.int64), moved, ends[rests]))
        values = np.concatenate((np.zeros(1), ways * S / period_ns, np.zeros(int(rests.sum()))))
        order = np.argsort(starts, kind="stable")
        within = starts[order] <= self.end_ns
        return Series.of(starts[order][within], values[order][within], self.end_ns)


def check(bench: Bench, signals: Sequence[str], events: Sequence[str], axes: Sequence[str]) -> None:
    """Raise UsageError if a given signal, event or axis does not exist on the bench."""
    with Recording(bench, signals, events) as record:
        for name in axes:
            record.energy(name)
