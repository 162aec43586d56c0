"""Events on a bench that can be observed: characters on lines, messages on a bus, levels and voltages.

`controller` is the name of the host's endpoint (see `endpoints.py`), or of the controller that has the terminal.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from axistwin.bench import endpoints
from axistwin.bench.actions import action_value, lead_value, line_action
from axistwin.bench.bench import Bench
from axistwin.bench.controller import Controller, on_a_bus
from axistwin.bench.faults.injector import Fault
from axistwin.bench.faults.sentences import write as written
from axistwin.plant.servo_axis import ServoAxis
from axistwin.sim.frames import LineError
from axistwin.sim.manual_actions import ManualAct
from axistwin.sim.pins import Pin, UserPin
from axistwin.sim.registers import RegisterPort
from axistwin.sim.serial_port import SerialPort


@dataclass(frozen=True, slots=True)
class _Happening:
    time_ns: int
    controller: str


@dataclass(frozen=True, slots=True)
class Sent(_Happening):
    """Event: a host sends data.  On a bus, the data are one whole command."""

    data: bytes


@dataclass(frozen=True, slots=True)
class Received(_Happening):
    """Event: a host has received a character; on a bus, a message is ready for the host."""

    data: bytes
    errors: LineError = LineError.NONE


@dataclass(frozen=True, slots=True)
class LevelChanged(_Happening):
    """Event: the level of a terminal has changed.  `driven`: True if a test lead forces the level.

    The lines of a serial connection are called `dtr` and `rts` at the device, `host.dtr` and `host.rts` at the host.
    """

    pin: str
    level: bool
    driven: bool = False
    flashing: bool = False


@dataclass(frozen=True, slots=True)
class VoltageChanged(_Happening):
    """Event: the voltage of an analog terminal has changed; a change of its level is reported first."""

    pin: str
    volts: float
    driven: bool = False


@dataclass(frozen=True, slots=True)
class LineBreak(_Happening):
    """Event: a host has sent a break, which lasts `seconds`."""

    seconds: float


@dataclass(frozen=True, slots=True)
class FaultChanged(_Happening):
    """Event: a fault has begun or ended.  `act` and `words` describe the change as in a line of a conversation."""

    act: str
    words: str


@dataclass(frozen=True, slots=True)
class ManualAction(_Happening):
    """Event: a person has acted on the machine.  The line `! act value` of a conversation repeats the action."""

    act: str
    value: str


@dataclass(frozen=True, slots=True)
class SettingChanged(_Happening):
    """Event: a setting of the host's serial port has changed; `! act value` repeats it in a conversation."""

    act: str
    value: str


Event = Sent | Received | LevelChanged | VoltageChanged | LineBreak | FaultChanged | ManualAction | SettingChanged
Sink = Callable[[Event], None]


@contextmanager
def observing(bench: Bench, sink: Sink) -> Iterator[None]:
    with ExitStack() as stack:
        for name in endpoints.names(bench):
            if endpoints.at_a_bus(bench, name):
                _observe_bus(bench, name, bench[name].bus, sink, stack)
            else:
                _observe_port(bench, name, bench.port(name), sink, stack)
        for controller in bench.controllers.values():
            _observe_person(bench, controller, sink, stack)
            _observe_pins(bench, controller, sink, stack)
        stack.callback(bench.faults.subscribe(partial(_failed, bench, sink)))
        yield


def _failed(bench: Bench, sink: Sink, fault: Fault, what: str) -> None:
    where = fault.spot.name.partition(".")[0]
    if what == "begins":
        sink(FaultChanged(bench.now, where, "fault", written(fault)))
    elif fault.on:  # the end of a fault
        sink(FaultChanged(bench.now, where, "mend", fault.name))


def _observe_person(bench: Bench, controller: Controller, sink: Sink, stack: ExitStack) -> None:
    def handled(target: str, *values: float) -> None:
        sink(ManualAction(bench.now, controller.name, target, action_value(target, *values)))

    def led(name: str, pin: Pin) -> None:
        sink(ManualAction(bench.now, controller.name, name, lead_value(pin)))

    def at_axis(name: str, act: str, *values: float) -> None:
        handled(act if act == ManualAct.AMBIENT else f"{name}.{act}", *values)

    def at_master(target: str, what: Any, how: Any) -> None:
        if isinstance(how, Fraction):
            on = f"on {_name_of(bench, what)} times {how.numerator}/{how.denominator}"
            sink(ManualAction(bench.now, controller.name, target, on))
        else:
            handled(target, what, how)

    for name, pin in controller.pins.items():
        stack.callback(pin.lead_changes.subscribe(partial(led, name, pin)))
    stack.callback(controller.manual_actions.subscribe(handled))
    if controller.product.joystick is not None:
        stack.callback(controller.joystick.manual_actions.subscribe(handled))
    for name, axis in controller.axes.items():
        stack.callback(axis.manual_actions.subscribe(partial(at_axis, name)))
        if isinstance(axis, ServoAxis):
            stack.callback(axis.master.manual_actions.subscribe(at_master))


def _name_of(bench: Bench, axis: object) -> str:
    there = ((f"{it.name}.{name}", each) for it in bench.controllers.values() for name, each in it.axes.items())
    return next((name for name, each in there if each is axis), "another bench")


def terminals(controller: Controller) -> dict[str, Pin]:
    """Return all terminals whose levels can be observed: pins, and control lines of the serial port or the bus."""
    pins = {name: pin for name, pin in controller.pins.items() if not pin.restless}
    if on_a_bus(controller):
        return {**pins, "interrupt": controller.bus.interrupt_line}
    port = controller.ports.get(controller.name)
    if port is None or not port.handshake:
        return pins
    lines = {"dtr": port.dtr_line, "rts": port.rts_line, "host.dtr": port.host.dtr_line, "host.rts": port.host.rts_line}
    return {**pins, **lines}


def _observe_bus(bench: Bench, name: str, bus: RegisterPort, sink: Sink, stack: ExitStack) -> None:
    clock = bench.clock
    stack.callback(bus.subscribe_sent(lambda data: sink(Sent(clock.now, name, data))))
    stack.callback(bus.subscribe_received(lambda data: sink(Received(clock.now, name, data))))


def _observe_port(bench: Bench, name: str, port: SerialPort, sink: Sink, stack: ExitStack) -> None:
    clock = bench.clock
    stack.callback(port.subscribe_sent(lambda data: sink(Sent(clock.now, name, data))))
    stack.callback(port.settings.subscribe(lambda act: sink(SettingChanged(clock.now, name, *line_action(act)))))
    stack.callback(port.breaks.subscribe(lambda seconds: sink(LineBreak(clock.now, name, seconds))))
    stack.callback(port.subscribe_received(lambda byte, errors: sink(Received(clock.now, name, bytes([byte]), errors))))


def _observe_pins(bench: Bench, controller: Controller, sink: Sink, stack: ExitStack) -> None:
    name, clock = controller.name, bench.clock

    def changed(pin_name: str, pin: Pin) -> None:
        sink(LevelChanged(clock.now, name, pin_name, pin.level, pin.driven, pin.flashing))

    def turned(pin_name: str, pin: UserPin) -> None:
        sink(VoltageChanged(clock.now, name, pin_name, pin.volts, pin.driven))

    for pin_name, pin in terminals(controller).items():
        stack.callback(pin.subscribe(partial(changed, pin_name)))
        if isinstance(pin, UserPin):
            stack.callback(pin.volts_changes.subscribe(partial(turned, pin_name)))
