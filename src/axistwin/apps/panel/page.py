"""The page: which views there are and where, and the frames in which they are brought up to date."""

import asyncio
from collections.abc import Iterator
from functools import partial
from importlib import resources

from nicegui import Client, background_tasks, ui

from axistwin.apps.conversations import partners
from axistwin.apps.panel.look import Look, Refresh, together
from axistwin.apps.panel.views.clock import clock
from axistwin.apps.panel.views.driving import driving
from axistwin.apps.panel.views.faults import faults, power
from axistwin.apps.panel.views.front import front
from axistwin.apps.panel.views.machines import machines
from axistwin.apps.panel.views.people import people
from axistwin.apps.panel.views.pins import pins
from axistwin.apps.panel.views.program import program
from axistwin.apps.panel.views.scope import scope
from axistwin.apps.panel.views.tabs import Kinds, tabs
from axistwin.apps.panel.views.terminal import terminal

FRAME_S = 0.05
"""At most so often is a page brought up to date."""
PATIENCE_S = 30.0
"""A browser that has drawn nothing for so long is asked again."""
DRAWN = "await new Promise(requestAnimationFrame)"


async def page(look: Look) -> None:
    """Everything there is, for one person; called for each visit.  The bench has its turn between two views."""
    ui.colors(primary="#2457c5", positive="#19a15f", negative="#d0342c", warning="#d98e04")
    ui.add_head_html('<script>document.documentElement.lang = "en"</script>')
    ui.add_css((resources.files(__package__) / "panel.css").read_text())
    made = []
    for view in views(look):
        made.append(view)
        await asyncio.sleep(0)
    client = ui.context.client
    client.on_connect(look.person.came)
    client.on_disconnect(look.person.left)
    background_tasks.create(_keep_showing(client, look, together(*made)), name="panel")


def views(look: Look) -> Iterator[Refresh]:
    """All of them, each when it is asked for."""
    yield from _header(look)
    yield from _body(look)


def _header(look: Look) -> Iterator[Refresh]:
    with ui.header():
        ui.link("to the machines", "#bench").classes("skip")
        with ui.row().classes("driving"):
            ui.label("VIRTUAL").classes("virtual").tooltip("There is no hardware here")
            yield clock(look)
            yield people(look)
        yield driving(look)


def _body(look: Look) -> Iterator[Refresh]:
    columns = max(2, len(look.bench.controllers) + len(look.bench.lines))
    with ui.element("div").classes("bench").props("id=bench tabindex=-1").style(f"--columns: {columns}"):
        for name in look.bench.controllers:
            with ui.card().classes("machine").props(f'role=region aria-label="{name}"'):
                yield from _machine(look, name)
        for name in look.bench.lines:
            with ui.card().classes("machine").props(f'role=region aria-label="{name}"'):
                ui.label(name).classes("machine-name")
                yield terminal(look, name)
        with ui.element("div").classes("beside" if len(look.bench.controllers) == 1 else "beside wide"):
            yield scope(look)
            with ui.card().classes("machine").props("role=region aria-label=faults"):
                ui.label("Faults").classes("machine-name")
                yield faults(look)


def _machine(look: Look, name: str) -> Iterator[Refresh]:
    """A controller and what hangs on it."""
    with ui.row().classes("machine-head"):
        ui.label(name).classes("machine-name")
        ui.label(look.bench[name].product.title).classes("quiet")
        yield power(look, name)
    yield front(look, name)
    yield machines(look, name)
    kinds: Kinds = {"Pins": partial(pins, look, name)}
    if look.bench[name].product.programs:
        kinds["Program"] = partial(program, look, name)
    kinds |= {_called(each, name): partial(terminal, look, each) for each in _reached(look, name)}
    yield tabs(look, name, kinds)


def _called(partner: str, name: str) -> str:
    return "Terminal" if partner == name else f"Terminal {partner.removeprefix(f'{name}.')}"


def _reached(look: Look, name: str) -> list[str]:
    """The partners at which a host talks to this controller only."""
    return [each for each in partners.names(look.bench) if each in (name, f"{name}.rs485")]


async def _keep_showing(client: Client, look: Look, show: Refresh) -> None:
    """Frame by frame.  A browser that is slow gets fewer, and always the latest; a hidden one none."""
    loop = asyncio.get_running_loop()
    await client.connected()  # or until it is clear that it never will be
    deafen = look.people.listen(partial(_tell, client))
    try:
        while not client.is_deleted:
            began_s = loop.time()
            with client:
                if look.session.running:
                    look.session.pacer.look(show)
                else:
                    show()
                await _drawn(client)
            await asyncio.sleep(max(0.0, began_s + FRAME_S - loop.time()))
    finally:
        deafen()


def _tell(client: Client, words: str) -> None:
    with client:
        ui.notify(words)


async def _drawn(client: Client) -> None:
    """Until the browser has shown what it was sent."""
    try:
        await client.run_javascript(DRAWN, timeout=PATIENCE_S)
    except TimeoutError:
        return
