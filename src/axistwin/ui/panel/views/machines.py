"""The machine of a controller: an X-Y table, its axes with their readings, and its switches and lamps."""

from functools import partial

from nicegui import ui

from axistwin.bench import Controller
from axistwin.scenes.tables import OperatorTable
from axistwin.ui.drawings.figure import Figure
from axistwin.ui.drawings.of_axes import figure, used_axes
from axistwin.ui.drawings.scale import Flow
from axistwin.ui.drawings.switches import Press, Switches
from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.drawings.picture import Picture
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.operator import inscriptions
from axistwin.ui.panel.views.state import wanted
from axistwin.ui.panel.views.table import table


def machines(context: Context, name: str) -> Refresh:
    """Build the drawings of a controller's axes, switches and lamps.

    If some axes are configured, the others appear when they first move.  No drawing disappears: a drawing that moved
    under the pointer would let the user press the wrong switch.
    """
    flow, controller = Flow(), context.bench[name]

    def press(pin: str, level: str) -> None:
        context.touch(partial(context.session.do, name, pin, level))

    with ui.element("div").classes("view") as view:
        top_view = table(context, name, view)
        with ui.element("div").classes("axes"):
            level = 2 if len(context.bench.controllers) == 1 else 3
            frames = {axis: _frame(controller, axis, press, level) for axis in controller.axes}
    switches = Switches(controller, press, named(context.session.operator, name))
    board = Picture(switches.drawing)
    board.props(f'role=group aria-label="switches and lamps of {name}"')

    def refresh() -> None:
        smooth, controller = flow.is_smooth(context.bench), context.bench[name]
        top_view(smooth)
        used = used_axes(controller)
        for axis, (box, shown, picture) in frames.items():
            box.visible = box.visible or axis in used
            if box.visible:
                beside = None if context.comparison is None else context.comparison.beside(axis)
                shown.show(controller, smooth=smooth, beside=beside)
                picture.send()
        switches.show(controller, wanted(context).removeprefix(f"{name}."))
        board.send()

    return refresh


def named(operator: OperatorTable, name: str) -> dict[str, str]:
    """Return the names that the operator panel gives to a controller's terminals."""
    own = f"{name}."
    return {pin.removeprefix(own): word for pin, word in inscriptions(operator).items() if pin.startswith(own)}


def _frame(controller: Controller, axis: str, press: Press, level: int) -> tuple[ui.element, Figure, Picture]:
    breathe()
    with ui.element("section").classes("axis") as box:
        box.visible = axis in used_axes(controller)
        ui.label(axis).classes("axis-name").props(f"role=heading aria-level={level}")
        shown = figure(controller, axis, press)
        picture = Picture(shown.drawing)
    return box, shown, picture
