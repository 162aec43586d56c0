"""The X-Y table of a controller: from above, in three dimensions, or as its axes."""

from collections.abc import Callable

from nicegui import ui

from axistwin.bench import Controller
from axistwin.ui.drawings.switches import spaced
from axistwin.ui.drawings.table import NO_TOOL, Table
from axistwin.ui.drawings.trail import Trails, table_axes
from axistwin.ui.panel.context import Context
from axistwin.ui.panel.drawings.picture import Picture
from axistwin.ui.panel.drawings.table3d import Table3D
from axistwin.ui.panel.views.parts import TOGGLE

TURN = 30.0  # Rotation of the 3-D view by one click, in degrees.
VIEWS = {"top": "Top", "solid": "3-D", "axes": "Axes"}


def table(context: Context, name: str, view: ui.element) -> Callable[[bool], None]:
    """Build the X-Y table of two limited axes, if there is one; its update takes True for smooth transitions.

    `view` gets the CSS class `top`, `solid` or `axes`.
    """
    names = table_axes(context.bench[name])
    if names is None:
        view.classes("axes-only")
        return lambda smooth: None
    trails, controller = context.common(Trails), context.bench[name]
    views = _Views(context, controller, names, view)
    with ui.element("div").classes("above"):
        flat = Table(controller, names)
        picture = Picture(flat.drawing)
    views.make_room()

    def refresh(smooth: bool) -> None:
        controller, trail = context.bench[name], trails[name]
        tool = tool_of(context, controller)
        flat.show(controller, trail, tool, smooth=smooth, beside=_beside(context, controller, names))
        picture.send()
        if views.solid is not None:
            views.solid.show(controller, trail, tool)

    return refresh


def _beside(context: Context, controller: Controller, names: tuple[str, str]) -> tuple[int, int] | None:
    """Return where the real machine's head is; None if it is not known."""
    if context.comparison is None:
        return None
    told = [context.comparison.beside(name) for name in names]
    x, y = (controller.axes[name].position if place is None else place for name, place in zip(names, told, strict=True))
    return None if told == [None, None] else (x, y)


def tool_choice(context: Context, name: str) -> None:
    """Build the choice of the output that moves the tool of a controller's X-Y table, if it has one."""
    controller = context.bench[name]
    if table_axes(controller) is None:
        return
    key, options = _tool_key(controller), {NO_TOOL: "no tool", **{each: spaced(each) for each in _outputs(controller)}}
    choice = ui.select(
        options, label="tool", value=tool_of(context, controller),
        on_change=lambda event: context.person.settings.update({key: event.value}),
    )  # fmt: skip
    choice.props('dense options-dense outlined aria-label="tool"').classes("tool-choice").mark(key)


def tool_of(context: Context, controller: Controller) -> str:
    """Return the output that moves the tool, as the user has chosen it, else the first."""
    outputs = _outputs(controller)
    wanted = context.person.settings.get(_tool_key(controller))
    return str(wanted) if wanted in (NO_TOOL, *outputs) else outputs[0] if outputs else NO_TOOL


def _tool_key(controller: Controller) -> str:
    return f"{controller.name} tool"


def _outputs(controller: Controller) -> list[str]:
    return [name for name, pin in controller.pins.items() if pin.is_output]


class _Views:
    """The choice between the drawing from above, the one in three dimensions, and the axes."""

    def __init__(self, context: Context, controller: Controller, names: tuple[str, str], view: ui.element) -> None:
        self._context, self._name, self._names, self._view = context, controller.name, names, view
        self._key = f"{controller.name} view"
        self.solid: Table3D | None = None
        kept = context.person.settings.get(self._key)
        self._choice = ui.toggle(VIEWS, value=kept if kept in VIEWS else "top", on_change=self._changed)
        self._choice.props(f'{TOGGLE} role=group aria-label="view"').classes("views").mark(self._key)

    def make_room(self) -> None:
        self._room = ui.element("div").classes("solid-box")
        self._make()

    def _changed(self) -> None:
        self._context.person.settings[self._key] = self._choice.value
        self._make()

    def _make(self) -> None:
        self._view.classes(
            str(self._choice.value), remove=" ".join(word for word in VIEWS if word != self._choice.value)
        )
        self._room.clear()
        self.solid = None
        if self._choice.value == "solid":
            with self._room:
                view = self.solid = Table3D(self._context.bench[self._name], self._names)
                with ui.element("div").classes("turns"):
                    _turn(view, "rotate_left", "turn left", -TURN)
                    _turn(view, "rotate_right", "turn right", TURN)


def _turn(view: Table3D, icon: str, words: str, degrees: float) -> None:
    button = ui.button(icon=icon, on_click=lambda: view.turn(degrees)).props(f'flat dense aria-label="{words}"')
    button.mark(words)
