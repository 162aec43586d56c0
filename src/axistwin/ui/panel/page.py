"""The panel's page: the layout of its views, and the frames in which the views are updated."""

import asyncio
import json
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from importlib import resources
from time import perf_counter

from fastapi import Request
from nicegui import Client, background_tasks, events, ui

from axistwin.scenes.sessions.session import Session
from axistwin.ui import conversation
from axistwin.ui.drawings.of_axes import asset
from axistwin.ui.panel import layout
from axistwin.ui.panel.actions import State
from axistwin.ui.panel.context import Context, Refresh, careful
from axistwin.ui.panel.memory import Memory, release
from axistwin.ui.panel.outbound import Outbound
from axistwin.ui.panel.people import Person
from axistwin.ui.panel.turns import TURN_S, breathe, in_turns
from axistwin.ui.panel.views.compared import compared, differences
from axistwin.ui.panel.views.driving import driving
from axistwin.ui.panel.views.machines import machines
from axistwin.ui.panel.views.operator import operator
from axistwin.ui.panel.views.parts import folded
from axistwin.ui.panel.views.scope import scope
from axistwin.ui.panel.views.state import next_line
from axistwin.ui.panel.views.tabs import beside

FRAME_S = 0.05  # Shortest time between two frames of a page.
PATIENCE_S = 30.0  # Longest time to wait until a browser has drawn a frame; the next frame is then sent.
KEPT_PAGES = 3  # Largest number of disconnected pages that are kept; the oldest page is emptied if there are more.
SCRIPTS = "keys.js", "scope.js", "state.js"
"""Scripts of views; they are sent with the page, because a browser ignores scripts that are added later."""
BEGIN = 'document.documentElement.lang = "en"; document.documentElement.classList.add("building")'
BUILT = 'axistwinState.attach(); document.querySelector(".q-loading-bar")?.setAttribute("aria-label", "loading")'
SHOWN = 'document.documentElement.classList.remove("building")'
"""JavaScript that shows the page after its first frame, so that nothing moves in view."""
DRAWN = "await new Promise(requestAnimationFrame); axistwinState.show({state}, {handled})"


async def build_page(enter: Callable[[], Context]) -> None:
    """Build the panel's page for one browser.

    `enter` is called when the browser has connected, and returns the `Context`.  Until then the page is empty, because
    a program that only fetches the URL needs no views.  The views are built in pieces, one page at a time; the bench
    runs between two pieces.
    """
    ui.add_head_html(f"<script>{BEGIN}</script>")
    for script in (asset("parts.js"), conversation.asset("log.js"), *(_text("views", name) for name in SCRIPTS)):
        ui.add_head_html(f"<script>{script}</script>")
    ui.add_css(asset("drawings.css") + conversation.asset("log.css") + _text("panel.css"))
    client = ui.context.client
    client.on_delete(lambda: _released(list(client.elements.values())))
    await client.connected()  # This call waits until a browser connects, or until the page is deleted.
    if client.is_deleted:
        return
    context = enter()
    visits = context.common(Visits)
    visits.begin(client, context.person)
    async with visits.building:
        with Outbound(client) as outbound:
            made = await in_turns(partial(_built, client, context))
            context.common(Memory).keep()
        await outbound.send()
    client.run_javascript(BUILT)
    visits.shown(client, background_tasks.create(_Frames(client, context, made).show(), name="panel"))
    context.session.welcome()


class Visits:
    """All open pages of a session; a disconnected page is kept for some time."""

    def __init__(self, _: Session) -> None:
        self.building = asyncio.Lock()  # Lock that prevents two pages from being built at the same time.
        self._left: dict[Client, None] = {}
        self._frames: dict[Client, asyncio.Task[None] | None] = {}  # Update tasks; None while a page is built.

    def begin(self, client: Client, person: Person) -> None:
        client.on_connect(lambda: self._back(client, person))
        client.on_disconnect(lambda: self._gone(client, person))
        client.on_delete(lambda: self._forget(client))
        self._frames[client] = None
        person.came()

    def shown(self, client: Client, frames: asyncio.Task[None]) -> None:
        """Store the update task of a page; cancel the task if the page has been removed in the meantime."""
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
        if len(self._left) > KEPT_PAGES:
            oldest = next(iter(self._left))
            self._forget(oldest)
            elements = list(oldest.layout.descendants())
            oldest.layout.clear()
            # A browser that connects again reloads the page, and needs no old messages of the server.
            oldest.outbox.message_history.clear()
            _released(elements)

    def _forget(self, client: Client) -> None:
        self._left.pop(client, None)
        frames = self._frames.pop(client, None)
        if frames is not None:
            frames.cancel()


def _released(elements: list[ui.element]) -> None:
    background_tasks.create(release(elements), name="panel")


def rehearse(context: Context, request: Request) -> None:
    """Build a page without a browser; files and modules are then loaded before a host could be delayed."""
    client = Client(ui.page(""), request=request)
    made = _built(client, context)
    with client:
        for view in made:
            view()
        while context.unbuilt:
            context.unbuilt.pop()()
    client.build_response(request)
    client.delete()


def _built(client: Client, context: Context) -> list[Refresh]:
    made = []
    with client:
        for view in build_views(context):
            made.append(careful(view))
            breathe()
    return made


def _text(*place: str) -> str:
    return resources.files(__package__).joinpath(*place).read_text(encoding="utf-8")


def build_views(context: Context) -> Iterator[Refresh]:
    yield from _header(context)
    yield from _body(context)


def _header(context: Context) -> Iterator[Refresh]:
    with ui.header(add_scroll_padding=False).classes("top"):
        ui.link("to the machine", "#bench").classes("skip")
        yield driving(context) if context.comparison is None else compared(context, context.comparison)


def _body(context: Context) -> Iterator[Refresh]:
    controllers = context.bench.controllers
    looked_at = "" if context.comparison is None else "looked-at"
    with ui.element("div").classes(f"bench {looked_at}").props("id=bench tabindex=-1"):
        with _card("machine", "machine"):
            yield next_line(context) if context.comparison is None else differences(context.comparison)
            if context.session.operator.items:
                with ui.element("section").classes("desk").props('role=region aria-label="operator panel"'):
                    yield operator(context)
            with ui.element("div").classes("bodies" if len(controllers) == 1 else "bodies several"):
                for name in controllers:
                    with ui.element("section").classes("body").props(f'role=region aria-label="{name}"'):
                        with ui.element("div").classes("body-head"):
                            ui.label(name).classes("body-name").props("role=heading aria-level=2")
                            ui.label(controllers[name].product.title).classes("quiet")
                        yield machines(context, name)
        with _card("talk", "conversation"):
            yield beside(context)
        with _card("scope-card", "oscilloscope"), folded(context, "scope", "Oscilloscope"):
            yield scope(context)


def _card(kind: str, name: str) -> ui.element:
    return ui.element("section").classes(f"card {kind}").props(f'role=region aria-label="{name}"')


class _Frames:
    """Sends updates to one browser; each waits until the browser has drawn the previous one."""

    def __init__(self, client: Client, context: Context, made: list[Refresh]) -> None:
        self._client, self._context, self._made = client, context, made
        self._handled = 0  # Number of messages from the browser that have been handled.
        self._news = asyncio.Event()  # Event that ends the wait before the next frame.
        self._layout = layout.written(context.person)
        with client:
            ui.on("sent", self._on_sent)

    async def show(self) -> None:
        loop, client = asyncio.get_running_loop(), self._client
        ends = self._context.people.subscribe(partial(_notify, client)), self._context.actions.subscribe(self._news.set)
        try:
            with client:
                # The sizes of page elements are known only after the browser has drawn the page.
                await self._drawn(State.BUSY)
                await self._refresh()
                await self._complete()
                await self._refresh()
                client.run_javascript(SHOWN)
            while not client.is_deleted:
                began_s = loop.time()
                with client:
                    await self._frame()
                await self._rest(began_s + FRAME_S - loop.time())
        finally:
            for end in ends:
                end()

    async def _frame(self) -> None:
        self._news.clear()
        before = self._handled, self._context.actions.state
        await self._refresh()
        if self._context.unbuilt:
            self._news.set()
            await self._complete()
        self._keep_layout()
        now = self._handled, self._context.actions.state
        await self._drawn(State.BUSY if self._news.is_set() or before != now else now[1])

    async def _refresh(self) -> None:
        left = deque(self._made)
        while left:
            self._context.session.inspect(partial(_refresh_some, left))
            if left:
                await asyncio.sleep(0)

    def _keep_layout(self) -> None:
        text = layout.written(self._context.person)
        if text != self._layout:
            self._layout = text
            self._client.run_javascript(layout.KEEP.format(text=json.dumps(text)))

    async def _complete(self) -> None:
        context = self._context
        while context.unbuilt:
            build = careful(context.unbuilt.pop())
            async with context.common(Visits).building:
                await in_turns(build)
                context.common(Memory).keep()

    async def _drawn(self, state: State) -> None:
        try:
            code = DRAWN.format(state=json.dumps(state), handled=self._handled)
            await self._client.run_javascript(code, timeout=PATIENCE_S)
        except TimeoutError:
            return

    async def _rest(self, seconds: float) -> None:
        """Wait for the next update, at most `seconds`; while time is stopped, a browser's message ends it."""
        if self._context.session.running:
            await asyncio.sleep(max(0.0, seconds))
            return
        with suppress(TimeoutError):
            async with asyncio.timeout(max(0.0, seconds)):
                await self._news.wait()

    def _on_sent(self, event: events.GenericEventArguments) -> None:
        sent = event.args.get("sent") if isinstance(event.args, dict) else None
        if type(sent) is int:
            self._handled = sent
            self._news.set()


def _refresh_some(left: deque[Refresh]) -> None:
    """Update views at the same virtual time for `TURN_S`, and remove them from `left`."""
    until_s = perf_counter() + TURN_S
    while left and perf_counter() < until_s:
        left.popleft()()


def _notify(client: Client, words: str) -> None:
    with client:
        ui.notify(words)
