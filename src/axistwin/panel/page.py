"""The page: which views there are and where, and the frames in which they are brought up to date."""

import asyncio
from collections.abc import Callable, Iterator
from functools import partial
from importlib import resources
from time import perf_counter

from fastapi import Request
from nicegui import Client, background_tasks, ui

from axistwin.bench import endpoints
from axistwin.panel.look import Look, Refresh, careful
from axistwin.panel.memory import Memory, release
from axistwin.panel.people import Person
from axistwin.panel.turns import TURN_S, breathe, in_turns
from axistwin.panel.views.clock import clock
from axistwin.panel.views.driving import driving
from axistwin.panel.views.faults import faults, power
from axistwin.panel.views.front import front
from axistwin.panel.views.machines import machines
from axistwin.panel.views.people import people
from axistwin.panel.views.pins import pins
from axistwin.panel.views.program import program
from axistwin.panel.views.scope import scope
from axistwin.panel.views.tabs import Kinds, tabs
from axistwin.panel.views.terminal import terminal
from axistwin.sessions.session import Session

FRAME_S = 0.05
"""At most so often is a page brought up to date."""
PATIENCE_S = 30.0
"""A browser that has drawn nothing for so long is asked again."""
KEPT = 3
"""So many pages without a browser are kept whole; of more, those that have been left for longest are emptied."""
SCRIPTS = "keys.js", "scope.js"
"""Of views; a browser carries out only those that come with the page itself."""
BEGIN = 'document.documentElement.lang = "en"; document.documentElement.classList.add("building")'
BUILT = 'document.documentElement.classList.remove("building")'
"""What cannot be touched yet is not to be seen."""
DRAWN = "await new Promise(requestAnimationFrame)"


async def page(enter: Callable[[], Look]) -> None:
    """The page for one visit.  `enter`: called when a browser has connected, for who comes in.

    Before, there is but a shell: who only fetches the address is nobody, and costs next to nothing.  The views are
    built in pieces, one page at a time, and the bench has its turn between two of them.
    """
    ui.colors(primary="#2457c5", positive="#19a15f", negative="#d0342c", warning="#d98e04")
    ui.add_head_html(f"<script>{BEGIN}</script>")
    for script in SCRIPTS:
        ui.add_head_html(f"<script>{_text('views', script)}</script>")
    ui.add_css(_text("panel.css"))
    client = ui.context.client
    client.on_delete(lambda: _released(list(client.elements.values())))
    await client.connected()  # or until it is clear that it never will be
    if client.is_deleted:
        return
    look = enter()
    visits = look.common(Visits)
    visits.begin(client, look.person)
    async with visits.building:
        made = await in_turns(partial(_built, client, look))
        look.common(Memory).keep()
    client.run_javascript(BUILT)
    visits.shown(client, background_tasks.create(_keep_showing(client, look, made), name="panel"))


class Visits:
    """All pages of a session.  Those whose browsers are gone keep what they have for a while, but not too many."""

    def __init__(self, _: Session) -> None:
        self.building = asyncio.Lock()
        """Held while a page is built: one at a time."""
        self._left: dict[Client, None] = {}
        self._frames: dict[Client, asyncio.Task[None] | None] = {}
        """Who brings each page up to date; None: it is being built."""

    def begin(self, client: Client, person: Person) -> None:
        """This page is connected."""
        client.on_connect(lambda: self._back(client, person))
        client.on_disconnect(lambda: self._gone(client, person))
        client.on_delete(lambda: self._forget(client))
        self._frames[client] = None
        person.came()

    def shown(self, client: Client, frames: asyncio.Task[None]) -> None:
        """It is built, and brought up to date from now on."""
        if client in self._frames:
            self._frames[client] = frames
        else:
            frames.cancel()

    def _back(self, client: Client, person: Person) -> None:
        person.came()
        self._left.pop(client, None)
        if client not in self._frames:
            client.run_javascript("location.reload()")

    def _gone(self, client: Client, person: Person) -> None:
        person.left()
        self._left[client] = None
        if len(self._left) > KEPT:
            oldest = next(iter(self._left))
            self._forget(oldest)
            elements = list(oldest.layout.descendants())
            oldest.layout.clear()
            oldest.outbox.message_history.clear()  # it will be loaded again
            _released(elements)

    def _forget(self, client: Client) -> None:
        self._left.pop(client, None)
        frames = self._frames.pop(client, None)
        if frames is not None:
            frames.cancel()


def _released(elements: list[ui.element]) -> None:
    """Once they have been removed."""
    background_tasks.create(release(elements), name="panel")


def rehearse(look: Look, request: Request) -> None:
    """Build a page for nobody, so that what is done once, such as reading files, keeps no host waiting later."""
    client = Client(ui.page(""), request=request)
    _built(client, look)
    client.build_response(request)
    client.delete()


def _built(client: Client, look: Look) -> list[Refresh]:
    made = []
    with client:
        for view in views(look):
            made.append(careful(view))
            breathe()
    return made


def _text(*place: str) -> str:
    return resources.files(__package__).joinpath(*place).read_text()


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
    return [each for each in endpoints.names(look.bench) if each in (name, f"{name}.rs485")]


async def _keep_showing(client: Client, look: Look, made: list[Refresh]) -> None:
    """Frame by frame.  A browser that is slow gets fewer, and always the latest; a hidden one none."""
    loop = asyncio.get_running_loop()
    deafen = look.people.listen(partial(_tell, client))
    try:
        with client:
            await _drawn(client)  # what has been built: terminals have their sizes by then
        while not client.is_deleted:
            began_s = loop.time()
            with client:
                await _show(look, made)
                await _complete(look)
                await _drawn(client)
            await asyncio.sleep(max(0.0, began_s + FRAME_S - loop.time()))
    finally:
        deafen()


async def _show(look: Look, made: list[Refresh]) -> None:
    """One frame; the loop has its turn in between if it takes long."""
    began_s = perf_counter()
    for view in made:
        if perf_counter() - began_s > TURN_S:
            await asyncio.sleep(0)
            began_s = perf_counter()
        if look.session.running:
            look.session.pacer.inspect(view)
        else:
            view()


async def _complete(look: Look) -> None:
    """Build what has come into view, in pieces."""
    while look.unbuilt:
        build = careful(look.unbuilt.pop())
        async with look.common(Visits).building:
            await in_turns(build)
            look.common(Memory).keep()


def _tell(client: Client, words: str) -> None:
    with client:
        ui.notify(words)


async def _drawn(client: Client) -> None:
    """Until the browser has shown what it was sent."""
    try:
        await client.run_javascript(DRAWN, timeout=PATIENCE_S)
    except TimeoutError:
        return
