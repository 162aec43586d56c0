"""What stands beside the machine: terminals, program, front panel, pins and faults of a controller."""

from functools import partial

from nicegui import ui

from axistwin.bench import endpoints
from axistwin.ui.panel.context import Context, Refresh
from axistwin.ui.panel.views.faults import faults
from axistwin.ui.panel.views.front import front
from axistwin.ui.panel.views.pins import pins
from axistwin.ui.panel.views.program import program
from axistwin.ui.panel.views.tabs import Kinds, tabs
from axistwin.ui.panel.views.terminal import terminal


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
