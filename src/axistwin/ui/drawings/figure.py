"""Common parts of all drawings of axes: readouts and fault messages."""

from collections.abc import Iterator
from html import escape
from typing import Protocol

from axistwin.bench import Controller
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis
from axistwin.plant.stepper import StepperAxis
from axistwin.ui.drawings.drawing import Drawing
from axistwin.ui.drawings.scale import grouped, minus, signed

SELDOM = 10  # Number of frames between two updates of slow values such as a temperature.
STATES = '<p class="states" aria-live="polite" data-part="states"></p>'


class Figure(Protocol):
    """The drawing of one axis: a linear slide or a rotating shaft."""

    drawing: Drawing

    def show(self, controller: Controller, *, smooth: bool, beside: int | None = None) -> None:
        """Update the drawing of the axis; if `smooth` is True, the parts move in a smooth transition.

        `beside`: position of a second machine, which is drawn as a pale copy.
        """


def readout(part: str, label: str, of: str = "", kind: str = "") -> str:
    """Return the HTML of a row with a value: `part` is its name, `of` its unit, `kind` more CSS classes."""
    told = f" <small>{escape(of)}</small>" if of else ""
    value = f'<dd><span data-part="{part}">\u2013</span>{told}</dd>'
    return f'<div class="of-{part} {kind}" data-part="row-{part}"><dt>{escape(label)}</dt>{value}</div>'


def readouts(*rows: str) -> str:
    return f'<dl class="readouts">{"".join(rows)}</dl>'


def error_rows(axis: Axis) -> list[str]:
    """Return rows for following error and temperature of a servo, or for lost steps and encoder of a stepper."""
    of = axis.unit
    if isinstance(axis, ServoAxis):
        return [readout("behind", "Following error", of), readout("temperature", "Motor", "°C")]
    encoder = [readout("encoder", "Encoder", "counts")] if axis.encoder_count is not None else []
    return [*encoder, readout("behind", "Lost", of, "unused")]  # Last, because a slide keeps its place while it is 0.


def motion_rows(axis: Axis) -> list[str]:
    """Return rows for position, velocity, target and limits in the axis's unit; in pulses the position alone, last."""
    of = axis.unit if axis.units is None else axis.units.of
    parts = ("position", "velocity") if axis.units is None else ("place", "speed")
    rows = [readout(parts[0], "Position", of), readout(parts[1], "Velocity", f"{of}/s")]
    if not isinstance(axis, ServoAxis):
        rows.append(readout("target", "Target", of, "none"))
    if axis.limits is not None:
        rows.append(readout("limits", "Limits"))
    return rows if axis.units is None else [*rows, readout("position", axis.unit.capitalize())]


def show_motion(drawing: Drawing, controller: Controller, name: str) -> int:
    """Update an axis's faults, position, velocity, target, limits, error and encoder; return the commanded position."""
    axis = controller.axes[name]
    position, wanted = axis.position, axis.setpoint if isinstance(axis, ServoAxis) else axis.pulses
    drawing.flag("machine", "jammed", axis.jammed)
    drawing.write("states", " \u00b7 ".join(_states(controller, name)))
    drawing.write("position", grouped(position))
    if axis.units is None:
        drawing.write("velocity", signed(round(axis.velocity)))
    else:
        drawing.write("place", minus(axis.units.shown(position)))
        drawing.write("speed", minus(axis.units.shown(axis.velocity)))
    drawing.write("behind", signed(wanted - position))
    if axis.limits is not None:
        first, last = axis.limits
        drawing.write("limits", "minus" if position < first else "plus" if position > last else "clear")
        drawing.flag("row-limits", "wrong", not first <= position <= last)
    if not isinstance(axis, ServoAxis):
        _show_stepper(drawing, axis, lost=wanted - position)
    return wanted


def target(axis: Axis) -> int | None:
    """Return the position at the end of the present move; None at rest, for an endless move, or for a servo."""
    if isinstance(axis, ServoAxis) or not axis.moving:
        return None
    move = axis.train.move
    return None if move.end_ns is None else move.position_at(move.end_ns) - axis.lost


def in_unit(axis: Axis, position: int) -> str:
    """Format a position in the axis's unit, without the unit's name."""
    return grouped(position) if axis.units is None else minus(axis.units.shown(position))


def _show_stepper(drawing: Drawing, axis: StepperAxis, lost: int) -> None:
    there = target(axis)
    drawing.write("target", "\u2013" if there is None else in_unit(axis, there))
    drawing.flag("row-target", "none", there is None)
    drawing.flag("row-behind", "wrong", lost != 0)
    drawing.flag("row-behind", "unused", lost == 0)
    if axis.encoder_count is not None:
        drawing.write("encoder", grouped(axis.encoder_count))


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
