"""Tabs beside the machine: terminals, program, front panel, pins and faults of a controller.

A tab is built when it is first opened, and updated while it is open.
"""

from collections.abc import Callable
from functools import partial

from nicegui import ui

from axistwin.bench import endpoints
from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.turns import breathe
from axistwin.ui.panel.views.faults import faults
from axistwin.ui.panel.views.front import front
from axistwin.ui.panel.views.pins import pins
from axistwin.ui.panel.views.program import program
from axistwin.ui.panel.views.terminal import terminal

Kinds = dict[str, Callable[[], Refresh]]


def beside(context: Context) -> Refresh:
    """Build the tabs of a controller; with several controllers or lines, a choice between them above."""
    bench = context.bench
    if not bench.controllers:
        return lambda: None
    if len(bench.controllers) + len(bench.lines) == 1:
        return _of_controller(context, next(iter(bench.controllers)))
    kinds: Kinds = {name: partial(_of_controller, context, name) for name in bench.controllers}
    kinds |= {name: partial(_of_line, context, name) for name in bench.lines}
    return tabs(context, "controllers", kinds, "talk-with")


def _of_controller(context: Context, name: str) -> Refresh:
    kinds: Kinds = {}
    for title, endpoint in (("Terminal", name), ("Terminal rs485", f"{name}.rs485")):
        if endpoint in endpoints.names(context.bench):
            kinds[title] = partial(terminal, context, endpoint)
    if context.bench[name].product.programs:
        kinds["Program"] = partial(program, context, name)
    kinds["Front panel"] = partial(front, context, name)
    kinds["Pins"] = partial(pins, context, name)
    kinds["Faults"] = partial(faults, context)
    return _tabs(context, name, kinds)


def _of_line(context: Context, name: str) -> Refresh:
    return _tabs(context, name, {"Terminal": partial(terminal, context, name)})


def _tabs(context: Context, name: str, kinds: Kinds) -> Refresh:
    with ui.element("section").classes("with").props(f'role=region aria-label="conversation of {name}"'):
        return tabs(context, name, kinds)


def tabs(context: Context, name: str, kinds: Kinds, look: str = "kinds") -> Refresh:
    """Build tabs that remember the open one for the user; `look`: a CSS class."""
    made: dict[str, Refresh | None] = {}
    setting = f"tab {name}"
    wanted = str(context.person.settings.get(setting, ""))
    first = wanted if wanted in kinds else next(iter(kinds))
    with ui.tabs().props("dense no-caps align=left outside-arrows mobile-arrows").classes(f"tabs {look}") as bar:
        for kind in kinds:
            ui.tab(kind).props(f'data-test="tab {name} {kind}"')
    breathe()
    with ui.tab_panels(bar, value=first, animated=False).classes("tab-panels"):
        panels = {kind: ui.tab_panel(kind) for kind in kinds}
    breathe()

    def build(kind: str) -> None:
        with panels[kind]:
            view = made[kind] = kinds[kind]()
        if kind == str(bar.value):
            view()

    def keep(kind: str) -> None:
        context.person.settings[setting] = kind

    bar.on_value_change(lambda event: keep(event.value))
    keep(first)

    def refresh() -> None:
        kind = str(bar.value)
        if kind not in made:  # Build the contents of a tab only when the user opens the tab.
            made[kind] = None
            context.unbuilt.append(partial(build, kind))
        elif view := made[kind]:
            view()

    return refresh
