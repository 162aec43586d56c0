"""The step commands of a motion board: planned from the times of pulses, and sent before they are due."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush

from axistwin.core.lazy import NDArray, np
from axistwin.real.standin.connection import Connection
from axistwin.real.standin.wiring import AxisPins
from axistwin.sim.motion.step_queue import Steps, plan

TOLERANCE_S = 0.5e-6  # Largest difference in seconds between planned and requested time of a step output's pulse.
LEAD_S = 0.01  # Shortest time in seconds from sending a step command to its first pulse.


@dataclass
class Motor:
    """An axis of a motion board, with its unsent step commands."""

    pins: AxisPins
    oid: int
    last: int | None = None  # Tick of the last planned pulse; None before the first pulse.
    direction: int = 0
    position: int = 0  # Net number of planned pulses.
    origin: int | None = None  # The board's step count at position 0.
    waiting: deque[tuple[int | None, int, int, Steps]] = field(default_factory=deque)
    """Unsent commands: base tick (None: the last pulse), tick of the first pulse, direction, steps."""

    @property
    def due(self) -> int:
        """Tick of the first pulse that has not been sent."""
        return self.waiting[0][1]

    def refusal(self, direction: int, wanted: "NDArray[np.float64]", hz: float) -> str:
        """Return an error message if pulses at these ticks would exceed a limit of the axis, else ""."""
        gaps = np.diff(wanted, prepend=self.last if self.last is not None else -np.inf)
        return self.pins.refusal(hz / max(float(gaps.min()), 1e-9), self.position + direction * len(wanted))


class StepStream:
    """Plans and sends the step commands for the axes of a board.  `journal` receives one line for each command."""

    def __init__(self, connection: Connection, journal: Callable[[str], None]) -> None:
        self._connection, self._note = connection, journal
        self.motors: dict[str, Motor] = {}
        self.room = 0  # Number of step commands that the board's queue can hold.
        self._in_queue: list[float] = []

    def of(self, controllers: Sequence[str]) -> Iterator[Motor]:
        return (motor for motor in self.motors.values() if motor.pins.controller in controllers)

    def forget_queue(self) -> None:
        self._in_queue.clear()

    def add(self, motor: Motor, direction: int, wanted: "NDArray[np.float64]", tolerance_s: float) -> None:
        """Plan pulses at the given ticks of the board's clock.  Raises ValueError if an interval is out of range."""
        connection = self._connection
        base, now = motor.last, connection.clock.ticks(connection.now_s)
        if base is None or (not motor.waiting and base < now - connection.ticks(2 * LEAD_S)):
            base = int(wanted[0]) - connection.ticks(LEAD_S / 2)
            motor.last = None
        start, last = base if motor.last is None else None, base
        for steps in plan(wanted, base, tolerance_s * connection.clock.hz):
            motor.waiting.append((start, last + steps.interval, direction, steps))
            start, last = None, last + steps.ticks
        motor.last = last
        motor.position += direction * len(wanted)

    def send_due(self) -> float:
        """Send what fits into the board's queue; return the seconds by which the next command is late, 0 if in time."""
        clock = self._connection.clock
        now = clock.ticks(self._connection.now_s)
        while self._in_queue and self._in_queue[0] < now:
            heappop(self._in_queue)
        waiting = [motor for motor in self.motors.values() if motor.waiting]
        while waiting:
            first = min(waiting, key=lambda motor: motor.due)
            late_s = (now - first.due) / clock.hz + LEAD_S
            if late_s > 0:
                return late_s
            if len(self._in_queue) >= self.room:
                break
            self._send(first, *first.waiting.popleft())
            waiting = [motor for motor in waiting if motor.waiting]
        return 0.0

    def _send(self, motor: Motor, base: int | None, first: int, direction: int, steps: Steps) -> None:
        if base is not None:
            self._connection.send("reset_step_clock", oid=motor.oid, clock=base & 0xFFFF_FFFF)
        if direction != motor.direction:
            positive = int((direction > 0) is not motor.pins.direction.inverted)
            self._connection.send("set_next_step_dir", oid=motor.oid, dir=positive)
            motor.direction = direction
        self._connection.send("queue_step", oid=motor.oid, interval=steps.interval, count=steps.count, add=steps.add)
        heappush(self._in_queue, first)
        self._note(f"pulses {motor.pins.axis} {direction:+d} {first} {steps.interval} {steps.count} {steps.add}")
