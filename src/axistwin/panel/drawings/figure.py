"""What all drawings of axes have: readouts, and words for what is wrong."""

from collections.abc import Iterator
from html import escape
from typing import Protocol

from axistwin.bench import Controller
from axistwin.plant.axes import Axis
from axistwin.plant.servo_axis import ServoAxis

SELDOM = 10
"""What changes slowly and costs something is looked at once in so many frames."""
STATES = '<p class="states" aria-live="polite" data-part="states"></p>'


class Figure(Protocol):
    """An axis drawn as the machine it is."""

    def show(self, controller: Controller, *, smooth: bool) -> None:
        """Bring it up to date; not `smooth`: this does not follow on what it showed before."""


def unit(axis: Axis) -> str:
    """What its position is counted in."""
    return "counts" if isinstance(axis, ServoAxis) else "pulses"


def readout(part: str, label: str, of: str = "") -> str:
    """A number with its name and unit; its part is called as the number, its row `row-…`."""
    told = f"<small>{escape(of)}</small>" if of else ""
    value = f'<dd><span data-part="{part}">\u2013</span>{told}</dd>'
    return f'<div data-part="row-{part}"><dt>{escape(label)}</dt>{value}</div>'


def readouts(*rows: str) -> str:
    """Several of them."""
    return f'<dl class="readouts">{"".join(rows)}</dl>'


def states(controller: Controller, name: str) -> str:
    """In words, what keeps this axis from going as it should; mostly nothing."""
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
    assert controller.bench is not None, "it stands on one"
    for fault in controller.bench.faults:
        if fault.on and fault.spot.axis is axis:
            yield f"fault: {fault.name}"
