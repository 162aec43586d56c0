"""Parts that a bench connects to a controller: serial plugs and position switches."""

from collections.abc import Mapping
from typing import NamedTuple

from axistwin.controllers.product import Abilities, Device, Product
from axistwin.core.errors import UsageError
from axistwin.plant.axes import Axis
from axistwin.plant.stepper import StepperAxis
from axistwin.plant.switches import PositionSwitch, in_series
from axistwin.sim.clock import Clock
from axistwin.sim.frames import UartFormat
from axistwin.sim.line_format import line_format
from axistwin.sim.pins import connect
from axistwin.sim.serial_port import SerialPort
from axistwin.sim.wirings import direct, shared_pair


class Plug(NamedTuple):
    """The serial connection of a controller, with its initial settings."""

    port: SerialPort
    format: UartFormat
    instant: bool


def fit_plug(
    clock: Clock, abilities: Abilities, line: str | UartFormat | None, usual: UartFormat | None
) -> Plug | None:
    """Connect a host to a device's serial port, with DTR to DSR and RTS to CTS if they exist; None without a port."""
    if abilities.uart is None:
        return None
    assert usual is not None, "a product with a serial port names its usual format"
    fmt, instant = line_format(line, usual)
    wiring = direct(abilities.uart, instant=instant)
    if abilities.handshake is None:
        return Plug(SerialPort(clock, wiring, line=fmt), fmt, instant)
    lines = abilities.handshake.plug
    port = SerialPort(clock, wiring, lines.dtr, lines.rts, line=fmt)
    connect(port.host.dtr_line, lines.dsr)
    connect(port.host.rts_line, lines.cts)
    return Plug(port, fmt, instant)


def fit_second_port(abilities: Abilities, plug: Plug | None) -> SerialPort | None:
    """Connect a host to the RS-485 channel, and return the host's port; None if the device has no such channel."""
    if abilities.rs485 is None:
        return None
    assert plug is not None, "a device with a second channel has a plug"
    return SerialPort(plug.port.clock, shared_pair([abilities.rs485], instant=plug.instant), line=plug.format)


def fit_switches(made: Product, device: Device, axes: Mapping[str, Axis]) -> None:
    """Connect position switches: limit switches open beyond `limits`; the home input is high within `home`."""
    inputs: dict[str, list[PositionSwitch]] = {}
    for name, axis in axes.items():
        if axis.limits is not None and name in made.limit_pins:
            (first, last), (minus, plus) = axis.limits, made.limit_pins[name]
            inputs.setdefault(minus, []).append(PositionSwitch(axis, first, None))
            inputs.setdefault(plus, []).append(PositionSwitch(axis, None, last))
        if isinstance(axis, StepperAxis) and axis.home is not None:
            if name not in made.home_pins:
                raise UsageError(f"{made.model} has no home input: leave out the option `home` of axis {name}")
            in_series([PositionSwitch(axis, *axis.home)], device.pins[made.home_pins[name]])
    for pin, switches in inputs.items():
        in_series(switches, device.pins[pin], closed=made.closed_level)
