"""Record the messages, moves and level changes of a run, for its transcript."""

import re
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from fractions import Fraction

from axistwin.bench import Bench, endpoints
from axistwin.bench.events import Event, FaultChanged, LevelChanged, Received, Sent, VoltageChanged, observing
from axistwin.core.units import MS, S
from axistwin.plant.machine_units import MachineUnits
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.scenes.reports.servo_moves import ServoMove, ServoMoves
from axistwin.sim.frames import LineError
from axistwin.sim.motion.train import Move as TrainMove
from axistwin.sim.pins import PULLED_UP_VOLTS

LENGTH = 100_000  # Largest number of stored messages, level changes and voltages; the oldest are deleted.

_LINES = re.compile(rb"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+")

PAUSE_NS = 500 * MS  # Longest silence within a message; longer than five characters at 110 baud.


@dataclass
class Message:
    """A message between host and controller; a terminator, an answer or a pause ends it."""

    time_ns: int
    controller: str
    by_host: bool
    data: bytearray
    last_ns: int
    errors: LineError = LineError.NONE
    whole: bool = False  # True if all bytes of the message arrived at the same time, as on a bus.

    @property
    def terminated(self) -> bool:
        """True if the message ends with CR or LF, or if all its bytes arrived at the same time."""
        return self.whole or bytes(self.data[-1:]) in (b"\r", b"\n")


@dataclass(frozen=True)
class Move:
    """A move of a stepper axis: pulses in one direction without a pause."""

    controller: str
    axis: str
    train_move: TrainMove
    now_ns: int
    units: MachineUnits | None = None
    unit = "pulses"

    @property
    def start_ns(self) -> int:
        return self.train_move.start_ns

    @property
    def end_ns(self) -> int | None:
        """Virtual time in ns at the end of the move; None while the axis is moving."""
        end_ns = self.train_move.end_ns
        return end_ns if end_ns is not None and end_ns <= self.now_ns else None

    @property
    def origin(self) -> int:
        """Position before the move, in pulses."""
        return self.train_move.origin

    @property
    def target(self) -> int:
        """Position at the end of the move, in pulses; during the move, the present one."""
        return self.train_move.position_at(self.now_ns)

    @property
    def top_rate(self) -> Fraction:
        """Highest pulse rate that the move has reached so far, in pulses/s."""
        profile, start_ns = self.train_move.profile, self.start_ns
        begun = zip(profile.starts, profile.segments, strict=False)
        return max(segment.rate for start, segment in begun if start_ns + start * S // profile.ticks <= self.now_ns)


AnyMove = Move | ServoMove


@dataclass
class RunRecord:
    """Record of the messages, moves, level changes and injected faults of a run."""

    bench: Bench
    began_ns: int
    said: deque[Message] = field(default_factory=lambda: deque(maxlen=LENGTH))
    changes: deque[LevelChanged] = field(default_factory=lambda: deque(maxlen=LENGTH))
    turned: deque[VoltageChanged] = field(default_factory=lambda: deque(maxlen=LENGTH))
    """Voltages that an operator has applied to analog inputs."""
    faults: deque[FaultChanged] = field(default_factory=lambda: deque(maxlen=LENGTH))
    servos: list[ServoMoves] = field(default_factory=list)
    _open: dict[tuple[str, bool], Message] = field(default_factory=dict)

    def record(self, event: Event) -> None:
        if isinstance(event, LevelChanged):
            self.changes.append(event)
        elif isinstance(event, FaultChanged):
            self.faults.append(event)
        elif isinstance(event, VoltageChanged):
            # Record only intermediate voltages, e.g. 2 V.  Changes to 0 V or 5 V are recorded as level changes.
            if event.driven and 0 < event.volts < PULLED_UP_VOLTS:
                self.turned.append(event)
        elif isinstance(event, Received):
            message = self._add(event, event.data, by_host=False)
            message.errors |= event.errors
            if message.terminated:
                self._open.pop((event.controller, True), None)
        elif isinstance(event, Sent):
            for line in [event.data] if self._on_a_bus(event) else _LINES.findall(event.data):
                self._add(event, line, by_host=True)

    @property
    def complete(self) -> bool:
        lost = any(axis.train.forgotten for _, _, axis in self._steppers()) or any(s.forgotten for s in self.servos)
        return max(len(self.said), len(self.changes), len(self.turned), len(self.faults)) < LENGTH and not lost

    def moves(self) -> list[AnyMove]:
        found: list[AnyMove] = [
            Move(controller, name, move, self.bench.now, axis.units)
            for controller, name, axis in self._steppers()
            for move in axis.train.moves
            if move.profile.segments and (move.end_ns is None or move.end_ns > self.began_ns)
        ]
        found += [move for servo in self.servos for move in servo.moves_until(self.bench.now)]
        return sorted(found, key=lambda move: move.start_ns)

    def _steppers(self) -> Iterator[tuple[str, str, StepperAxis]]:
        for controller in self.bench.controllers.values():
            for name, axis in controller.axes.items():
                if isinstance(axis, StepperAxis):
                    yield controller.name, name, axis

    def _add(self, event: Sent | Received, data: bytes, by_host: bool) -> Message:
        key = event.controller, by_host
        message = self._open.get(key)
        ended = message is None or (message.terminated and data != b"\n")
        if message is None or ended or event.time_ns - message.last_ns > PAUSE_NS:
            message = Message(event.time_ns, event.controller, by_host, bytearray(), event.time_ns)
            message.whole = self._on_a_bus(event)
            self._open[key] = message
            self.said.append(message)
        message.data += data
        message.last_ns = event.time_ns
        return message

    def _on_a_bus(self, event: Event) -> bool:
        return endpoints.at_a_bus(self.bench, event.controller)

    def observe_servos(self, stack: ExitStack) -> None:
        """Record the moves of all servo axes.  The recording ends when the context `stack` is closed."""
        for controller in self.bench.controllers.values():
            for name, axis in controller.axes.items():
                if isinstance(axis, ServoAxis):
                    record = ServoMoves(controller.name, name, axis)
                    self.servos.append(record)
                    stack.callback(axis.subscribe(record.add_samples))
                    stack.callback(axis.catch_up)


@contextmanager
def recording_run(bench: Bench) -> Iterator[RunRecord]:
    run = RunRecord(bench, bench.now)
    with ExitStack() as stack:
        run.observe_servos(stack)
        stack.enter_context(observing(bench, run.record))
        yield run
