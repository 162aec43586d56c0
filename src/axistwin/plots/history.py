"""History of a run on a bench: messages, moves, levels and faults, for transcripts and plots."""

import re
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from fractions import Fraction

from axistwin.bench import Bench, endpoints
from axistwin.bench.events import Changed, Event, Heard, Said, Turned, observing, terminals
from axistwin.motion.train import Move as TrainMove
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.plots.servo_record import ServoMove, ServoRecord, moves_of
from axistwin.sim.frames import LineError
from axistwin.sim.pins import PULLED_UP_VOLTS
from axistwin.units import MS, S

LENGTH = 100_000
"""Largest number of messages and of level changes kept; `complete` reports if older ones were dropped."""

_LINES = re.compile(rb"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+")

PAUSE_NS = 500 * MS
"""A longer silence divides a message; five characters at 110 baud take less."""


@dataclass
class Utterance:
    """A message: up to a terminator, an answer of the other end, or a silence."""

    time_ns: int
    controller: str
    by_host: bool
    data: bytearray
    last_ns: int
    errors: LineError = LineError.NONE
    whole: bool = False
    """True for a message that arrives at once, as on a bus."""

    @property
    def terminated(self) -> bool:
        """True if the message has its terminator."""
        return self.whole or bytes(self.data[-1:]) in (b"\r", b"\n")

    def is_new_message(self, time_ns: int, data: bytes) -> bool:
        """Return True if new data begins a new message."""
        return (self.terminated and data != b"\n") or time_ns - self.last_ns > PAUSE_NS


@dataclass(frozen=True)
class Move:
    """A move of an axis: pulses in one direction without a rest.  `end_ns` None: still moving."""

    controller: str
    axis: str
    stroke: TrainMove
    now_ns: int
    unit = "pulses"

    @property
    def start_ns(self) -> int:
        """Start of the move."""
        return self.stroke.start_ns

    @property
    def end_ns(self) -> int | None:
        """End of the move; None: still moving."""
        end_ns = self.stroke.end_ns
        return end_ns if end_ns is not None and end_ns <= self.now_ns else None

    @property
    def origin(self) -> int:
        """Net pulses before the move."""
        return self.stroke.origin

    @property
    def target(self) -> int:
        """Net pulses after the move, or so far."""
        return self.stroke.position_at(self.now_ns)

    @property
    def top_rate(self) -> Fraction:
        """Highest rate in pulses/s, so far."""
        return max(rate for _, rate in self.segments())

    def segments(self) -> Iterator[tuple[int, Fraction]]:
        """Yield the start of each segment of constant rate, and its rate in pulses/s."""
        profile = self.stroke.profile
        for start, segment in zip(profile.starts, profile.segments, strict=False):
            start_ns = self.start_ns + start * S // profile.ticks
            if start_ns > self.now_ns:
                break
            yield start_ns, segment.rate


@dataclass(frozen=True)
class Fault:
    """A fault with its begin and end; `end_ns` None: still active."""

    name: str
    begin_ns: int
    end_ns: int | None = None


AnyMove = Move | ServoMove


@dataclass
class History:
    """All events since `began_ns`, or the latest of them."""

    bench: Bench
    began_ns: int
    levels: dict[tuple[str, str], bool]
    """Level of every terminal at the beginning, by controller and name."""
    said: deque[Utterance] = field(default_factory=lambda: deque(maxlen=LENGTH))
    changes: deque[Changed] = field(default_factory=lambda: deque(maxlen=LENGTH))
    turned: deque[Turned] = field(default_factory=lambda: deque(maxlen=LENGTH))
    """Voltages driven on terminals."""
    servos: list[ServoRecord] = field(default_factory=list)
    """Records of the servo axes."""
    faults: list[Fault] = field(default_factory=list)
    """Faults that were active at the beginning or have begun since."""
    _open: dict[tuple[str, bool], Utterance] = field(default_factory=dict)

    def record(self, event: Event) -> None:
        """Record an event."""
        if isinstance(event, Changed):
            self.changes.append(event)
        elif isinstance(event, Turned):
            if event.driven and 0 < event.volts < PULLED_UP_VOLTS:  # otherwise the level shows it
                self.turned.append(event)
        elif isinstance(event, Heard):
            utterance = self._add(event, event.data, by_host=False)
            utterance.errors |= event.errors
            if utterance.terminated:
                self._open.pop((event.controller, True), None)
        elif isinstance(event, Said):
            for line in [event.data] if self._on_a_bus(event) else _LINES.findall(event.data):
                self._add(event, line, by_host=True)

    def failed(self, name: str, what: str) -> None:
        """Record that a fault "begins" or "ends"."""
        if what == "begins":
            self.faults.append(Fault(name, self.bench.now))
            return
        place = next((n for n, fault in enumerate(self.faults) if fault.name == name and fault.end_ns is None), None)
        if place is not None:
            self.faults[place] = replace(self.faults[place], end_ns=self.bench.now)

    @property
    def complete(self) -> bool:
        """True if no events were dropped."""
        lost = any(axis.train.forgotten for _, _, axis in self._steppers()) or any(s.forgotten for s in self.servos)
        return max(len(self.said), len(self.changes), len(self.turned)) < LENGTH and not lost

    def moves(self) -> list[AnyMove]:
        """Return all moves in order of time."""
        found: list[AnyMove] = [*self.strokes(), *moves_of(self.servos, self.bench.now)]
        return sorted(found, key=lambda move: move.start_ns)

    def strokes(self) -> list[Move]:
        """Return the moves of steppers in order of time."""
        found = [
            Move(controller, name, stroke, self.bench.now)
            for controller, name, axis in self._steppers()
            for stroke in axis.train.moves
            if stroke.profile.segments and (stroke.end_ns is None or stroke.end_ns > self.began_ns)
        ]
        return sorted(found, key=lambda move: move.start_ns)

    def _steppers(self) -> Iterator[tuple[str, str, StepperAxis]]:
        for controller in self.bench.controllers.values():
            for name, axis in controller.axes.items():
                if isinstance(axis, StepperAxis):
                    yield controller.name, name, axis

    def _add(self, event: Said | Heard, data: bytes, by_host: bool) -> Utterance:
        key = event.controller, by_host
        utterance = self._open.get(key)
        if utterance is None or utterance.is_new_message(event.time_ns, data):
            utterance = Utterance(event.time_ns, event.controller, by_host, bytearray(), event.time_ns)
            utterance.whole = self._on_a_bus(event)
            self._open[key] = utterance
            self.said.append(utterance)
        utterance.data += data
        utterance.last_ns = event.time_ns
        return utterance

    def _on_a_bus(self, event: Event) -> bool:
        return endpoints.at_a_bus(self.bench, event.controller)

    def observe_servos(self, stack: ExitStack) -> None:
        """Observe the servo axes until the stack is closed."""
        for controller in self.bench.controllers.values():
            for name, axis in controller.axes.items():
                if isinstance(axis, ServoAxis):
                    record = ServoRecord(controller.name, name, axis)
                    self.servos.append(record)
                    stack.callback(axis.subscribe(record.add_samples))
                    stack.callback(axis.catch_up)


@contextmanager
def watching(bench: Bench) -> Iterator[History]:
    """Record the events on a bench within this context."""
    levels = {
        (controller.name, name): pin.level
        for controller in bench.controllers.values()
        for name, pin in terminals(controller).items()
    }
    history = History(bench, bench.now, levels)
    history.faults += [
        Fault(fault.name, fault.began_ns) for fault in bench.faults if fault.began_ns is not None and fault.on
    ]
    with ExitStack() as stack:
        history.observe_servos(stack)
        stack.callback(bench.faults.subscribe(lambda fault, what: history.failed(fault.name, what)))
        stack.enter_context(observing(bench, history.record))
        yield history
