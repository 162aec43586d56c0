"""The front panel of a controller, as its product describes it, and a list of all registers."""

from collections.abc import Callable, Iterable

from nicegui import ui

from axistwin.bench import Controller
from axistwin.controllers.front import Group, Item, Lamp, Reading, Tone, Word
from axistwin.ui.panel.context import Context, Refresh, seldom, together
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.parts import Light, Readout, called, drawer

Show = Callable[[int | str | None], None]  # Shows a value on the page; None: the controller has no power.
SELDOM = 5  # Number of frames between two updates of the list of registers.


def front(context: Context, name: str) -> Refresh:
    controller = context.bench[name]
    groups = controller.product.front or generic(controller)
    with ui.element("section").classes("front") as section:
        section.props["aria-label"] = f"front of {name}"
        shown = [_group(context, name, group) for group in groups]
    if controller.product.front:
        _meaning(context, name, groups)
        shown.append(_registers(context, name))
    return together(*shown)


def generic(controller: Controller) -> tuple[Group, ...]:
    """Return a front panel with all terminals and registers, for a model that describes none."""
    outputs = tuple(Lamp(name, name, name) for name, pin in controller.terminals.items() if pin.is_output)
    inputs = tuple(Lamp(name, name, name) for name, pin in controller.terminals.items() if not pin.is_output)
    registers = tuple(Word(name, name, name) for name in controller.registers)
    groups = (
        Group("Outputs", "", outputs, row=True),
        Group("Inputs", "", inputs, row=True),
        Group("Registers", "", registers),
    )
    return tuple(group for group in groups if group.items)


NOTHING = object()  # Marks a value that has not been read yet; it differs from all values of terminals and registers.


class _Source:
    def __init__(self, name: str) -> None:
        self._name = name
        self._known: int | str | object | None = NOTHING
        self.shows: list[Show] = []

    def refresh(self, controller: Controller) -> None:
        value = controller.read(self._name)
        if value != self._known:
            self._known = value
            for show in self.shows:
                show(value)


def _group(context: Context, name: str, group: Group) -> Refresh:
    sources = {source: _Source(source) for source in group.sources}
    with ui.element("div").classes("group") as box:
        box.props.update({"role": "group", "aria-label": group.title})
        with ui.label(group.title).classes("group-title") as title:
            title.props["title"] = group.chapter
        with ui.element("div").classes("row-of-lamps" if group.row else "told-list"):
            for item in group.items:
                sources[item.source].shows.append(_item(name, item, group))

    def refresh() -> None:
        controller = context.bench.controllers[name]
        for source in sources.values():
            source.refresh(controller)

    return refresh


def _item(who: str, item: Item, group: Group) -> Show:
    tip = f"{item.name.capitalize()}.  {item.doc}  [{group.chapter}]".replace("  []", "")
    mark = f"{who} {item.label or item.name} {group.title}".replace(" ", "-")
    if isinstance(item, Lamp):
        light = called(Light(item.label, item.name, item.tone, tip), mark)
        return lambda value: light.show(item.shows(_number(value)))
    readout = called(Readout(item.label, item.name, item.unit if isinstance(item, Reading) else "", tip), mark)
    if isinstance(item, Word):
        return lambda value: readout.show(item.shows(value), item.tones.get(value, Tone.PLAIN))
    return lambda value: readout.show(item.shows(_number(value)))


def _number(value: int | str | None) -> int | None:
    return None if value is None else int(value)


def _meaning(context: Context, name: str, groups: Iterable[Group]) -> None:
    """Build a text that explains the lamps and displays, for users who cannot see tooltips."""
    with drawer(context, f"{name} meaning", "What it means"):
        for group in groups:
            ui.label(f"{group.title}: {group.chapter}").classes("group-title")
            with ui.element("dl").classes("meaning"):
                for item in group.items:
                    _plain("dt", item.label or item.name)
                    words = (item.name if item.label else "", item.doc)
                    _plain("dd", ".  ".join(filter(None, words)))


def _plain(tag: str, text: str) -> None:
    breathe()
    with ui.element(tag):
        ui.label(text)


def _plainly(readout: Readout) -> Show:
    return lambda value: readout.show("" if value is None else str(value))


def _registers(context: Context, name: str) -> Refresh:
    found = drawer(context, f"{name} registers", "All registers")
    sources: list[_Source] = []

    def build() -> None:
        with found, ui.element("div").classes("registers"):
            for register in context.bench[name].registers:
                source = _Source(register)
                source.shows.append(_plainly(called(Readout(register, register), f"{name}-register-{register}")))
                sources.append(source)

    def refresh() -> None:
        if not found.value:
            return
        if not sources:
            build()
        controller = context.bench[name]
        for source in sources:
            source.refresh(controller)

    return seldom(context, SELDOM, refresh)
