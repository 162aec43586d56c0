"""Drawings of a controller's machine: slides for limited travel, shafts for other axes, an X-Y table, and switches."""

from functools import partial

from nicegui import ui

from axistwin.bench import Controller
from axistwin.panel.context import Context, Refresh
from axistwin.panel.drawings.figure import Figure
from axistwin.panel.drawings.scale import Flow
from axistwin.panel.drawings.shaft import Shaft
from axistwin.panel.drawings.slide import Slide
from axistwin.panel.drawings.switches import Press, Switches
from axistwin.panel.views.table import table


def machines(context: Context, name: str) -> Refresh:
    """Draw all axes of a controller that have been used, or else all axes, and the controller's switches and lamps."""
    flow, controller = Flow(), context.bench[name]

    def press(pin: str, level: str) -> None:
        context.touch(partial(context.session.do, name, pin, level))

    with ui.element("div").classes("picture"):
        with ui.element("div").classes("axes"):
            top_view = table(context, name)
            frames = {axis: _frame(controller, axis, press) for axis in controller.axes}
        with ui.element("section").classes("axis switches-box").props(f'aria-label="switches and lamps of {name}"'):
            switches = Switches(controller, press)

    def refresh() -> None:
        smooth, controller = flow.is_smooth(context.bench), context.bench[name]
        top_view(smooth)
        used = [axis for axis in controller.axes if _used(controller, axis)] or list(controller.axes)
        for axis, (box, figure) in frames.items():
            box.visible = axis in used
            if box.visible:
                figure.show(controller, smooth=smooth)
        switches.show(controller)

    return refresh


def _frame(controller: Controller, axis: str, press: Press) -> tuple[ui.element, Figure]:
    with ui.element("section").classes("axis") as box:
        ui.label(axis).classes("axis-name").props("role=heading aria-level=3")
        slides = controller.axes[axis].limits is not None
        figure = Slide(controller, axis, press) if slides else Shaft(controller, axis)
    return box, figure


def _used(controller: Controller, name: str) -> bool:
    """Return True if the axis is configured, is moving, or is not at position 0."""
    axis = controller.axes[name]
    return bool(controller.given.get(name)) or axis.position != 0 or axis.moving
