"""The places where a fault can act, by name: lines, terminals, axes, controllers.

if1.serial  motor.rs485  chain      if1.input1      if1.X      if1

If the controller is known, its name may be left out: `serial`, `input1`, `X`.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from axistwin.controllers.product import Listing, Product
from axistwin.core.errors import UsageError, instead
from axistwin.plant.axes import Axis
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin
from axistwin.sim.progress import Line, LineWatcher
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial_port import SerialPort
from axistwin.sim.signal import Alarms


class Machine(Protocol):
    """Interface between the fault injector and a controller."""

    name: str
    product: Product
    pins: Mapping[str, Pin]
    axes: Mapping[str, Axis]

    @property
    def ports(self) -> dict[str, SerialPort]: ...

    @property
    def bus(self) -> RegisterPort: ...

    @property
    def alarms(self) -> Alarms | None:
        """Fault flags of the controller; None for a controller without fault flags."""

    @property
    def programs(self) -> Mapping[str, Listing]: ...

    def subscribe_lines(self, callback: LineWatcher, only: Line | None = None) -> Callable[[], None]:
        """Call `callback` when a program line begins, or only the line `only`; return an unsubscribe function."""

    def power(self, on: bool) -> None: ...


class World(Protocol):
    """Interface between the fault injector and a bench."""

    clock: Clock

    @property
    def controllers(self) -> Mapping[str, Any]:
        """The controllers of the bench by name; each controller is a `Machine`."""

    @property
    def lines(self) -> Mapping[str, Any]: ...

    @property
    def faults(self) -> Any: ...

    def port(self, name: str) -> SerialPort: ...


@dataclass(frozen=True)
class Spot:
    """A line, pin, axis or controller that a fault can affect; fields that do not apply are None."""

    name: str
    controller: Machine | None = None
    port: SerialPort | None = None
    pin: Pin | None = None
    axis: Axis | None = None

    @property
    def machine(self) -> Machine:
        assert self.controller is not None
        return self.controller


Find = Callable[[], Spot]


def lines(world: World) -> Iterator[tuple[str, Find]]:
    """Yield the serial lines of a bench by name: `if1.serial`, `chain`, and `motor.rs485` if it is in use."""
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
    """Return the parts of a bench by all of their names, also short ones: those of `here` without its name.

    A controller's name is a short name of its serial port, or of its only part of this type.
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
    """Return the object that has the name `name`, e.g. the axis `if1.X`.  Raises UsageError for an unknown name."""
    if name in found:
        return found[name]()
    raise UsageError(f"unknown {kind} {name!r}: {instead(name, found) if found else 'expected one of (none)'}")
