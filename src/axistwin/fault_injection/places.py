"""The places where a fault can act, by name: lines, terminals, axes, controllers.

if1.serial  motor.rs485  chain      if1.input1      if1.X      if1

If the controller is known, its name may be left out: `serial`, `input1`, `X`.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from typing import Any, Protocol

from axistwin.controllers.product import Listing, Product
from axistwin.errors import UsageError
from axistwin.plant.axes import Axis
from axistwin.sim.alarms import Alarms
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin
from axistwin.sim.progress import Line, LineWatcher
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial_port import SerialPort


class Machine(Protocol):
    """Interface between the fault injector and a controller."""

    name: str
    product: Product
    pins: Mapping[str, Pin]
    axes: Mapping[str, Axis]

    @property
    def ports(self) -> dict[str, SerialPort]:
        """Serial ports of the controller, by name."""

    @property
    def bus(self) -> RegisterPort:
        """The bus interface of the controller, for access to its registers.  Only a controller on a bus has it."""

    @property
    def alarms(self) -> Alarms | None:
        """Fault flags of the controller; None for a controller without fault flags."""

    @property
    def programs(self) -> Mapping[str, Listing]:
        """Programs stored in the controller."""

    def subscribe_lines(self, callback: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `callback` when the execution of a program line begins.  Return an unsubscribe function.

        `only`: the only line to report.
        """

    def power(self, on: bool) -> None:
        """Switch the controller on or off."""


class World(Protocol):
    """Interface between the fault injector and a bench."""

    clock: Clock

    @property
    def controllers(self) -> Mapping[str, Any]:
        """The controllers of the bench by name; each controller is a `Machine`."""

    @property
    def lines(self) -> Mapping[str, Any]:
        """The shared serial lines of the bench, each with several motors; the keys are the names of the lines."""

    @property
    def faults(self) -> Any:
        """Object that adds faults to simulated controllers, axes, pins and serial lines."""

    def port(self, name: str) -> SerialPort:
        """Return the serial port through which a host is connected to a controller or to a shared serial line.

        `name`: e.g. `motor`, `motor.rs485` or `chain`.
        """


@dataclass(frozen=True)
class Spot:
    """An object that a fault can affect: a serial line, a pin, an axis or a controller.

    Fields that do not apply to the object are None.
    """

    name: str
    controller: Machine | None = None
    port: SerialPort | None = None
    pin: Pin | None = None
    axis: Axis | None = None

    @property
    def machine(self) -> Machine:
        """Controller whose serial line, pin or axis the fault affects."""
        assert self.controller is not None
        return self.controller


Find = Callable[[], Spot]


def lines(world: World) -> Iterator[tuple[str, Find]]:
    """Yield the name of each serial line, e.g. `if1.serial` or `chain`, and a function that returns the line.

    An RS-485 channel such as `motor.rs485` is included if the channel is in use.
    """
    for name, controller in world.controllers.items():
        for port in controller.ports:
            called = port if port != name else f"{name}.serial"
            yield called, partial(Spot, called, controller, controller.ports[port])
    for name in world.lines:
        yield name, partial(Spot, name, None, world.port(name))


def pins(world: World) -> Iterator[tuple[str, Find]]:
    """Yield the name of each pin, e.g. `if1.input1`, and a function that returns the pin."""
    for name, controller in world.controllers.items():
        for pin in controller.pins:
            yield f"{name}.{pin}", partial(Spot, f"{name}.{pin}", controller, pin=controller.pins[pin])


def axes(world: World) -> Iterator[tuple[str, Find]]:
    """Yield the name of each axis, e.g. `if1.X`, and a function that returns the axis."""
    for name, controller in world.controllers.items():
        for axis in controller.axes:
            yield f"{name}.{axis}", partial(Spot, f"{name}.{axis}", controller, axis=controller.axes[axis])


def controllers(world: World) -> Iterator[tuple[str, Find]]:
    """Yield the name of each controller, e.g. `if1`, and a function that returns the controller."""
    for name, controller in world.controllers.items():
        yield name, partial(Spot, name, controller)


def names(found: Iterable[tuple[str, Find]], here: str = "") -> dict[str, Find]:
    """Return a dict with full and short names of the objects that a fault can affect, e.g. `if1.X` and `X` for an axis.

    `found`: the full names.  The name of a pin or an axis of the controller `here` is short without the controller's
    name. The name of a controller is a short name of its serial port, or of its only pin or axis.
    """
    full = dict(found)
    every = dict(full)
    for name, spot in full.items():
        controller, _, what = name.partition(".")
        if what and controller == here:
            every.setdefault(what, spot)
        own = [other for other in full if other.partition(".")[0] == controller]
        if what == "serial" or len(own) == 1:
            every.setdefault(controller, spot)
    return every


def find(found: Mapping[str, Find], name: str, kind: str) -> Spot:
    """Return the object that has the name `name`, e.g. the axis `if1.X`.

    Raises UsageError for an unknown name.
    """
    if name in found:
        return found[name]()
    for similar in get_close_matches(name, found, n=1):
        raise UsageError(f"unknown {kind} {name!r}: did you mean {similar!r}?")
    known_names = ", ".join(found) or "(none)"
    raise UsageError(f"unknown {kind} {name!r}: expected one of {known_names}")
