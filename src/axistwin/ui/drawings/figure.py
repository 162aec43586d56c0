"""Common parts of all drawings of axes: readouts and fault messages."""

from collections.abc import Iterator
from html import escape
from typing import Protocol

from axistwin.bench import Controller
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis
from axistwin.ui.drawings.drawing import Drawing
from axistwin.ui.drawings.scale import grouped, minus, signed

SELDOM = 10  # Number of frames between two updates of slow values such as a temperature.
STATES = '<p class="states" aria-live="polite" data-part="states"></p>'


class Figure(Protocol):
    """The drawing of one axis: a linear slide or a rotating shaft."""

    drawing: Drawing

    def show(self, controller: Controller, *, smooth: bool) -> None:
        """Update the drawing of the axis; if `smooth` is True, the parts move in a smooth transition."""


def readout(part: str, label: str, of: str = "") -> str:
    """Return the HTML of a row with a number: `part` is its name, `of` its unit."""
    told = f"<small>{escape(of)}</small>" if of else ""
    value = f'<dd><span data-part="{part}">\u2013</span>{told}</dd>'
    return f'<div data-part="row-{part}"><dt>{escape(label)}</dt>{value}</div>'


def readouts(*rows: str) -> str:
    return f'<dl class="readouts">{"".join(rows)}</dl>'


def error_rows(axis: Axis) -> list[str]:
    """Return rows for following error and temperature of a servo, or for lost steps and encoder of a stepper."""
    of = axis.unit
    if isinstance(axis, ServoAxis):
        return [readout("behind", "following error", of), readout("temperature", "motor", "°C")]
    encoder = [readout("encoder", "encoder", "counts")] if axis.encoder_count is not None else []
    return [readout("behind", "lost", of), *encoder]


def motion_rows(axis: Axis) -> list[str]:
    """Return rows for position and velocity in pulses or counts and, if defined, in the machine unit."""
    of = axis.unit
    rows = [readout("position", "position", of), readout("velocity", "velocity", f"{of}/s")]
    if axis.units is None:
        return rows
    return [readout("place", "position", axis.units.of), readout("speed", "velocity", f"{axis.units.of}/s"), *rows]


def show_motion(drawing: Drawing, controller: Controller, name: str) -> int:
    """Update an axis's faults, position, velocity, error and encoder; return its commanded position."""
    axis = controller.axes[name]
    position, wanted = axis.position, axis.setpoint if isinstance(axis, ServoAxis) else axis.pulses
    drawing.flag("machine", "jammed", axis.jammed)
    drawing.write("states", " \u00b7 ".join(_states(controller, name)))
    drawing.write("position", grouped(position))
    drawing.write("velocity", signed(round(axis.velocity)))
    if axis.units is not None:
        drawing.write("place", minus(axis.units.shown(position)))
        drawing.write("speed", minus(axis.units.shown(axis.velocity)))
    drawing.write("behind", signed(wanted - position))
    drawing.flag("row-behind", "wrong", not isinstance(axis, ServoAxis) and wanted != position)
    if not isinstance(axis, ServoAxis) and axis.encoder_count is not None:
        drawing.write("encoder", grouped(axis.encoder_count))
    return wanted


def _states(controller: Controller, name: str) -> Iterator[str]:
    axis = controller.axes[name]
    if axis.jammed:
        yield "jammed"
    if not isinstance(axis, ServoAxis) and axis.stalled:
        yield "out of step"
    pin = controller.product.drive_fault_pins.get(name)
    if pin is not None and not controller.pins[pin].level:
        yield "drive fault"
    assert controller.bench is not None, "the controller is part of a bench"
    for fault in controller.bench.faults:
        if fault.on and fault.spot.axis is axis:
            yield f"fault: {fault.name}"
