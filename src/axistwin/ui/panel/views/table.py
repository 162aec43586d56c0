"""The X-Y table of a controller: from above and, if the user switches it on, in three dimensions."""

from collections.abc import Callable

from nicegui import ui

from axistwin.bench import Controller
from axistwin.ui.drawings.table import NO_TOOL, Table
from axistwin.ui.drawings.trail import Trail, Trails, table_axes
from axistwin.ui.panel.context import Context
from axistwin.ui.panel.drawings.picture import Picture
from axistwin.ui.panel.drawings.table3d import Table3D

TURN = 30.0  # Rotation of the 3-D view by one click, in degrees.


def table(context: Context, name: str) -> Callable[[bool], None]:
    """Build the X-Y table of two limited axes, if there is one; its update takes True for smooth transitions."""
    names = table_axes(context.bench[name])
    if names is None:
        return lambda smooth: None
    trails, controller = context.common(Trails), context.bench[name]
    with ui.element("section").classes("axis table-box"):
        with ui.element("div").classes("table-head"):
            ui.label(" \u2013 ".join(names)).classes("axis-name").props("role=heading aria-level=3")
            tool = _tool(context, controller)
            solid = _Solid(context, controller, names)
        flat = Table(controller, names)
        picture = Picture(flat.drawing)
        solid.make_room()

    def refresh(smooth: bool) -> None:
        controller, trail = context.bench[name], trails[name]
        flat.show(controller, trail, tool(), smooth=smooth)
        picture.send()
        solid.show(controller, trail, tool())

    return refresh


def _tool(context: Context, controller: Controller) -> Callable[[], str]:
    outputs = [name for name, pin in controller.pins.items() if pin.is_output]
    key = f"{controller.name} tool"
    options = {NO_TOOL: "no tool", **{name: name for name in outputs}}
    wanted, first = context.person.settings.get(key), outputs[0] if outputs else NO_TOOL
    choice = ui.select(
        options, label="tool", value=wanted if wanted in options else first,
        on_change=lambda event: context.person.settings.update({key: event.value}),
    )  # fmt: skip
    choice.props("dense options-dense outlined").classes("tool-choice").mark(key)
    return lambda: str(choice.value)


class _Solid:
    def __init__(self, context: Context, controller: Controller, names: tuple[str, str]) -> None:
        self._context, self._name, self._names = context, controller.name, names
        self._key = f"{controller.name} 3-D"
        self._view: Table3D | None = None
        on = bool(context.person.settings.get(self._key))
        self._switch = ui.switch("3-D", value=on, on_change=self._changed).mark(self._key)

    def make_room(self) -> None:
        self._room = ui.element("div").classes("solid")
        self._make()

    def show(self, controller: Controller, trail: Trail, tool: str) -> None:
        if self._view is not None:
            self._view.show(controller, trail, tool)

    def _changed(self) -> None:
        self._context.person.settings[self._key] = self._switch.value
        self._make()

    def _make(self) -> None:
        self._room.clear()
        self._view = None
        if self._switch.value:
            with self._room:
                view = self._view = Table3D(self._context.bench[self._name], self._names)
                with ui.element("div").classes("turns"):
                    _turn(view, "rotate_left", "turn left", -TURN)
                    _turn(view, "rotate_right", "turn right", TURN)


def _turn(view: Table3D, icon: str, words: str, degrees: float) -> None:
    button = ui.button(icon=icon, on_click=lambda: view.turn(degrees)).props(f'flat round dense aria-label="{words}"')
    button.mark(words)
