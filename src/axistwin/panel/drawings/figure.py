"""Common parts of all drawings of axes: readouts, and texts of faults."""

from collections.abc import Iterator
from html import escape
from typing import Protocol

from axistwin.bench import Controller
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis

SELDOM = 10
"""Interval in frames at which slow values are read."""
STATES = '<p class="states" aria-live="polite" data-part="states"></p>'


class Figure(Protocol):
    """Drawing of an axis as a machine."""

    def show(self, controller: Controller, *, smooth: bool) -> None:
        """Update the drawing; without `smooth`, parts jump to their new places."""


def unit(axis: Axis) -> str:
    """Return the unit of the axis's position."""
    return "counts" if isinstance(axis, ServoAxis) else "pulses"


def readout(part: str, label: str, of: str = "") -> str:
    """Return the row of a number with its name and unit; the row's part is named `row-…`."""
    told = f"<small>{escape(of)}</small>" if of else ""
    value = f'<dd><span data-part="{part}">\u2013</span>{told}</dd>'
    return f'<div data-part="row-{part}"><dt>{escape(label)}</dt>{value}</div>'


def readouts(*rows: str) -> str:
    """Return the rows as one list."""
    return f'<dl class="readouts">{"".join(rows)}</dl>'


def states(controller: Controller, name: str) -> str:
    """Return the fault that disturbs the axis as text; "" without a fault."""
    return " \u00b7 ".join(_states(controller, name))


def _states(controller: Controller, name: str) -> Iterator[str]:
    axis = controller.axes[name]
    if axis.jammed:
        yield "jammed"
    if not isinstance(axis, ServoAxis) and axis.stalled:
        yield "out of step"
    pin = controller.product.drive_fault_pins.get(name)
    if pin is not None and not controller.pins[pin].level:
        yield "drive fault"
    assert controller.bench is not None, "a controller is on a bench"
    for fault in controller.bench.faults:
        if fault.on and fault.spot.axis is axis:
            yield f"fault: {fault.name}"
