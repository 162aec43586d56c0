"""The virtual controller that follows a real one, and takes over what only the machine knows."""

from collections.abc import Callable, Iterable

from axistwin.bench import Bench
from axistwin.bench.controller import on_a_bus
from axistwin.core.errors import UsageError
from axistwin.core.units import MS, S
from axistwin.plant.axes import Axis
from axistwin.plant.stepper import StepperAxis

STEP_NS = 10 * MS  # Interval at which the twin's state is looked at while it works.
SETTLE_S = 0.05  # Time for one private request.


class Twin:
    """A controller of a bench.  `heard` receives the twin's time and each character or message that it sends."""

    def __init__(self, bench: Bench, name: str) -> None:
        self.bench, self.controller = bench, bench[name]
        self.heard: Callable[[int, bytes], object] = lambda time_ns, data: None
        self._private: bytearray | None = None
        self.owes: Callable[[], object] = lambda: False  # True while an answer to the host is expected.
        self._latest = next(iter(self.controller.axes), ""), 1
        self._limits: dict[tuple[str, int], Callable[[], object]] = {}
        product, controller = self.controller.product, self.controller
        self._host = product.attend(controller.bus) if product.attend is not None else None
        if self._host is not None:
            self._host.subscribe_received(self._receive)
            self.detach: Callable[[], object] = self._host.close  # Leaves what the controller sends to others.
        else:
            self.detach = controller.serial.subscribe_received(lambda *_: self._receive(controller.serial.read()))
        self._trajectory = controller.registers.get("RBt")  # Of a servo: 1 while its trajectory is in progress.

    @property
    def on_bus(self) -> bool:
        return on_a_bus(self.controller)

    @property
    def now(self) -> int:
        return self.bench.now

    def run_to(self, time_ns: int) -> None:
        if time_ns > self.bench.now:
            self.bench.clock.run_to(time_ns)

    @property
    def idle(self) -> bool:
        """True if no request of the host is under way, so that a private one disturbs nothing."""
        pending = self._host.pending if self._host is not None else self.controller.serial.pending
        return not (pending or self.owes())

    def write(self, data: bytes) -> None:
        if self._host is not None:
            self._host.write(data)
        else:
            self.controller.serial.write(data)

    def _receive(self, data: bytes) -> None:
        if self._private is not None:
            self._private += data
        else:
            self.heard(self.bench.now, data)

    def private(self, *said: bytes, seconds: float = SETTLE_S) -> bytes:
        """Send requests that the machine does not get, and return the answer.  Virtual time advances by `seconds`."""
        self._private = bytearray()
        try:
            for data in said:
                self.write(data)
                self.bench.run(seconds)
            return bytes(self._private)
        finally:
            self._private = None

    def replay(self, said: Iterable[tuple[int, bytes]]) -> None:
        """Let the twin hear what the host has said before, as (time, data), and ignore its answers."""
        self._private, before_ns = bytearray(), None
        try:
            for time_ns, data in said:
                self.bench.run((time_ns - (time_ns if before_ns is None else before_ns)) / S)
                self.write(data)
                before_ns = time_ns
            self.bench.run(SETTLE_S)
        finally:
            self._private = None

    def power_cycle(self) -> None:
        self.controller.power_cycle()

    def set_line(self, line: str) -> None:
        """Set the line format that the host has chosen, e.g. 9600 8N1."""
        from axistwin.bench import line_format

        if not self.on_bus:
            port = self.controller.serial
            port.host.format = line_format(line, port.host.format)[0]

    # What the twin does

    @property
    def busy(self) -> bool:
        if self._trajectory is not None:
            return bool(self._trajectory.read())
        return self.controller.busy or any(not axis.resting for axis in self._axes)

    @property
    def speed(self) -> float:
        """The greatest speed of an axis, in pulses or counts per second."""
        return abs(self.controller.axes[self.busiest()[0]].velocity)

    @property
    def motion_ended_ns(self) -> int | None:
        """The exact end of the last motion; None if the axes do not report it."""
        ends = [axis.train.move.end_ns for axis in self._axes if isinstance(axis, StepperAxis)]
        known = [end for end in ends if end is not None]
        return max(known, default=None)

    @property
    def ends(self) -> bool:
        """True during a move of a stepper whose end is known."""
        return (self.motion_ended_ns or 0) > self.now

    def hurry(self) -> None:
        """Go on to the end of the present move."""
        self.run_to(max(self.now + STEP_NS, self.motion_ended_ns or 0))

    @property
    def left_ns(self) -> int:
        """The time for which the present motion still lasts; 0 if the axes do not report it."""
        ends = [axis.train.move.end_ns for axis in self._axes if isinstance(axis, StepperAxis) and axis.moving]
        if self._trajectory is not None:
            return S if self.busy else 0
        return max((end - self.bench.now for end in ends if end is not None), default=S if ends else 0)

    @property
    def pulses(self) -> tuple[int, int]:
        """All pulses of the present move of a stepper, and the signed number of those that remain."""
        axis = self.controller.axes[self.busiest()[0]]
        if not isinstance(axis, StepperAxis) or axis.train.move.profile.pulses is None:
            return 0, 0
        move = axis.train.move
        total = int(move.profile.pulses or 0)
        return total, move.direction * (total - move.profile.pulses_by(self.bench.now - move.start_ns))

    @property
    def _axes(self) -> list[Axis]:
        return list(self.controller.axes.values())

    # What only the machine knows

    def drive(self, pin: str, level: bool) -> None:
        self.controller.pins[pin].drive(level)

    def level(self, pin: str) -> bool:
        return self.controller.pins[pin].level

    def busiest(self) -> tuple[str, int]:
        """Return the axis that moves or has moved last, and its direction."""
        velocities = {name: axis.velocity for name, axis in self.controller.axes.items()}
        name = max(velocities, key=lambda axis: abs(velocities[axis]))
        if velocities[name]:
            self._latest = name, 1 if velocities[name] > 0 else -1
        return self._latest

    def position(self, axis: str) -> int:
        return self.controller.axes[axis].position

    def at_limit(self, axis: str, direction: int) -> bool:
        """True while the limit switch on this side is open."""
        product = self.controller.product
        pins = product.limit_pins.get(axis)
        return pins is not None and self.level(pins[direction > 0]) is not product.closed_level

    def set_limit(self, axis: str, direction: int, position: int) -> None:
        """Let the twin's limit switch open beyond this position, where the machine's has opened."""
        pins = self.controller.product.limit_pins.get(axis)
        if pins is None:
            return
        pin, closed = pins[direction > 0], self.controller.product.closed_level
        if old := self._limits.pop((axis, direction), None):
            old()
        where, ways = f"{self.controller.name}.{axis} passes", ("up", "down")
        beyond, back = ways if direction > 0 else ways[::-1]
        stops = [
            self.bench.when(f"{where} {position} {beyond}", lambda: self.drive(pin, not closed)),
            # An axis that stops at this very position closes the switch with its first pulse back.
            self.bench.when(f"{where} {position - direction} {back}", lambda: self.drive(pin, closed)),
        ]
        self._limits[axis, direction] = lambda: [stop() for stop in stops]


def endpoint(bench: Bench) -> str:
    """Return the only controller of a bench that can have a twin.  Raises UsageError for several."""
    names = list(bench.controllers)
    if len(names) != 1 or bench.lines:
        raise UsageError(
            f"a shadow needs one controller, but the scene has {', '.join((*names, *bench.lines))}: "
            "expected a scene with one, or --model, e.g. --model if1"
        )
    return names[0]
