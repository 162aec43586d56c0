"""Drawings of all axes of a controller: slides for limited travel, shafts for other axes, and an X-Y table."""

from nicegui import ui

from axistwin.bench import Controller
from axistwin.panel.context import Context, Refresh
from axistwin.panel.drawings.figure import Figure
from axistwin.panel.drawings.scale import Flow
from axistwin.panel.drawings.shaft import Shaft
from axistwin.panel.drawings.slide import Slide
from axistwin.panel.views.table import table


def machines(context: Context, name: str) -> Refresh:
    """Draw all axes of a controller that have been used; if none has been used, draw all axes."""
    flow, controller = Flow(), context.bench[name]
    with ui.element("div").classes("axes"):
        top_view = table(context, name)
        frames = {axis: _frame(controller, axis) for axis in controller.axes}

    def refresh() -> None:
        smooth, controller = flow.is_smooth(context.bench), context.bench[name]
        top_view(smooth)
        used = [axis for axis in controller.axes if _used(controller, axis)] or list(controller.axes)
        for axis, (box, figure) in frames.items():
            box.visible = axis in used
            if box.visible:
                figure.show(controller, smooth=smooth)

    return refresh


def _frame(controller: Controller, axis: str) -> tuple[ui.element, Figure]:
    with ui.element("section").classes("axis") as box:
        ui.label(axis).classes("axis-name").props("role=heading aria-level=3")
        figure = Slide(controller, axis) if controller.axes[axis].limits is not None else Shaft(controller, axis)
    return box, figure


def _used(controller: Controller, name: str) -> bool:
    """Return True if the axis is configured, is moving, or is not at position 0."""
    axis = controller.axes[name]
    return bool(controller.given.get(name)) or axis.position != 0 or axis.moving
