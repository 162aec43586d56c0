"""The causes that keep a controller from moving, as far as every device tells them."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, auto

from axistwin.bench import Controller
from axistwin.bench.acts import Act
from axistwin.controllers.front import Lamp
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis
from axistwin.scenes.reasons.remedies import Remedies, at_limit

MOST_DEVIATION = 20  # The reciprocal of the deviation of a baud rate that still lets characters arrive whole, 5 %.
SIDES = "minus", "plus"
EMERGENCY_STOPS = ("estop", "emergency_stop")  # Names of inputs that are low while the emergency stop is pressed.


class Cause(Enum):
    """Kind of a reason, by which the state of a machine is chosen."""

    OFF = auto()  # The power is off.
    STOP = auto()  # An emergency stop is pressed.
    AFTER_STOP = auto()  # An emergency stop has been pressed, and its effect has not been cleared.
    FAULT = auto()  # A limit or a fault stops the machine.
    INPUT = auto()  # A move or a program waits for an input.
    START = auto()  # The controller expects its first commands.
    REFUSED = auto()  # A message of the host was refused.
    COMMAND = auto()  # The next command of the host would be refused or ignored.
    ENDED = auto()  # A stored program has ended, and only a power-up starts it.


@dataclass(frozen=True)
class Reason:
    """A cause that prevents a move, with its remedy."""

    text: str
    remedy: str = ""
    cause: Cause = Cause.FAULT
    pin: str = ""  # The input that must change.
    level: str = ""  # The level that it must get, "high" or "low".
    cycle: bool = False  # True if the power must then be switched off and on.
    waits: tuple[tuple[str, str], ...] = ()  # Inputs that a stored program then waits for, with their levels.
    short: str = ""  # The text in a few words.

    def __str__(self) -> str:
        return f"{self.text}: {self.remedy}" if self.remedy else self.text


class Reasons:
    """Says why a controller does not move; this class knows what every device can tell."""

    suggestions: tuple[tuple[str, str], ...] = ()  # Lines to type when moves are possible, with their meanings.

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.remedies = Remedies()

    @property
    def moved(self) -> bool:
        """True if an axis has moved."""
        return any(map(_has_moved, self.controller.axes.values()))

    @property
    def begins(self) -> bool:
        """True while a stored sequence waits at its first step, and nothing has moved since power-up."""
        return False

    def step(self) -> tuple[str, str] | None:
        """Return the next line on the way to a first move, with its meaning; None after a move."""
        return None if self.moved else next(iter(self.suggestions), None)

    @property
    def ready(self) -> bool:
        """True while the controller accepts the host's commands."""
        return self.controller.powered and not self.controller.ignoring

    def reasons(self) -> Iterator[Reason]:
        """Yield the causes that prevent a move.  The first cause must be corrected first."""
        controller = self.controller
        if not controller.powered:
            yield self.off()
            return
        for pin in (name for name in EMERGENCY_STOPS if name in controller.pins):
            if not controller.pins[pin].level:
                yield Reason("the emergency stop is open", self.restored(pin, "high"), Cause.STOP, pin, "high")
        if controller.ignoring:
            yield Reason(f"the device ignores commands: {controller.ignoring}", cause=Cause.COMMAND)
        yield from self._limits()
        yield from self._drives()
        yield from self.awaited()
        if controller.hint and controller.awaited is None:
            text, _, remedy = controller.hint.partition(": ")
            yield Reason(text, remedy)
        yield from self.line()
        for listing in controller.programs.values():
            if listing.ended_by:
                yield Reason(f"{listing.ended_by} has ended {listing.title}")

    def initialisation(self) -> Iterator[Act]:
        """Yield the actions that make the controller ready; each must be performed before the next."""
        yield from ()

    # Reasons and remedies that are the same for all controllers

    def off(self) -> Reason:
        return Reason("the power is off", self.remedies.power("on"), Cause.OFF)

    def awaited(self) -> Iterator[Reason]:
        if (awaited := self.controller.awaited) is not None:
            work, pin, level = awaited
            yield Reason(f"{work} waits for {pin} {level}", self.given(pin, level), Cause.INPUT, pin, level)

    def _limits(self) -> Iterator[Reason]:
        product = self.controller.product
        axes: dict[tuple[str, str], list[str]] = {}  # Axes that share a limit input of a side.
        for axis, pins in product.limit_pins.items():
            for pin, side in zip(pins, SIDES, strict=True):
                axes.setdefault((pin, side), []).append(axis)
        for (pin, side), shared in axes.items():
            if self.controller.pins[pin].level is not product.closed_level:
                text, level = f"the {side} limit is active", "high" if product.closed_level else "low"
                _, _, away = self.controller.hint.partition(f"{side} limit: ")
                short = f"{spoken(shared[0])} at the {side} limit" if len(shared) == 1 else self.at(side)
                yield Reason(text, self.restored(pin, level, away=away), pin=pin, level=level, short=short)

    def _drives(self) -> Iterator[Reason]:
        for axis, pin in self.controller.product.drive_fault_pins.items():
            if not self.controller.pins[pin].level:
                yield Reason(f"the drive of {axis} reports a fault", self.restored(pin, "high"), pin=pin, level="high")

    def at(self, side: str, end: str = "") -> str:
        """Return `X at the plus limit`, or `plus limit active` if no axis stands on its switch.

        `end`: the end of the axis, if its directions are reversed.
        """
        found = at_limit(self.controller, (end or side) == "plus")
        return f"{side} limit active" if found is None else f"{found[0]} at the {side} limit"

    def given(self, name: str, level: str) -> str:
        """Return how to give an input the level for which the controller waits."""
        pin = self.controller.pins[name]
        if pin.held or (pin.wired and not pin.driven):
            return self.restored(name, level)
        return self.remedies.drive(name, level)

    def restored(self, name: str, level: str, *, then: str = "", away: str = "") -> str:
        """Return advice about an input that prevents motion, e.g. "type  :drive limit_plus high".

        `level`: the level that permits motion, "high" or "low".  `away`: a move that leaves a limit switch.  The input
        is never forced while a machine is connected to the input.
        """
        pin = self.controller.pins[name]
        if pin.held:
            return self.remedies.mend(name)
        if pin.driven and (pin.wired or pin.undriven is (level == "high")):
            return self.remedies.release(name) + then
        if away or pin.wired:
            return away or f"{name} is wired: find what sets it {'low' if level == 'high' else 'high'}"
        return self.remedies.drive(name, level) + then

    def line(self) -> Iterator[Reason]:
        """Yield the reason why no character arrives whole: another baud rate at the host, on a line of its own."""
        own, port = self.controller.line_format, self.controller.ports.get(self.controller.name)
        if own is None or port is None:
            return
        rate = port.host.format.baudrate
        if MOST_DEVIATION * abs(rate - own.baudrate) > own.baudrate:
            yield Reason(
                f"the host sends at {rate} baud, not at {own.baudrate}", f"type  :drive line {own}", Cause.COMMAND
            )

    def value(self, source: str) -> int | str:
        """Return the value of a register, or the level of a terminal as 0 or 1."""
        if source in self.controller.registers:
            return self.controller.registers[source].read()
        return int(self.controller.pins[source].level)

    def lamps(self, source: str) -> list[Lamp]:
        """Return the lamps of the front panel that represent the bits of a register."""
        lamps = (item for group in self.controller.product.front for item in group.items if isinstance(item, Lamp))
        return [lamp for lamp in lamps if lamp.source == source and lamp.bit is not None]

    def bits(self, source: str, value: int, none: str = "no bit is set") -> str:
        """Return the meaning of each bit that is 1 in a register."""
        lit = [lamp for lamp in self.lamps(source) if lamp.bit is not None and value >> lamp.bit & 1]
        return "; ".join(self._lamp(lamp, one=len(lit) == 1) for lamp in lit) or none

    @staticmethod
    def _lamp(lamp: Lamp, one: bool) -> str:
        return f"{lamp.label} {lamp.name}" + (f" ({lamp.doc.strip().rstrip('.')})" if one and lamp.doc else "")


def spoken(axis: str) -> str:
    """Return the name of an axis in a sentence: a number needs a noun."""
    return f"axis {axis}" if axis.isdigit() else axis


def _has_moved(axis: Axis) -> bool:
    return axis.position != 0 or not (isinstance(axis, ServoAxis) or axis.train.move.profile.pulses == 0)
