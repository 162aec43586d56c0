"""The panel's web server, which runs in the event loop that paces the bench."""

import asyncio
from contextlib import AbstractContextManager, nullcontext
from importlib import resources

import uvicorn
from fastapi import FastAPI, Request
from fastapi.middleware.gzip import GZipMiddleware
from nicegui import app, ui
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from axistwin.links.web_gate import is_loopback
from axistwin.scenes.sessions.session import Session
from axistwin.ui.conversation.conversation import Conversation
from axistwin.ui.panel import layout
from axistwin.ui.panel.address import Address, listening_socket
from axistwin.ui.panel.comparison import Comparison
from axistwin.ui.panel.context import Common, Context
from axistwin.ui.panel.gate import Gate
from axistwin.ui.panel.memory import Memory
from axistwin.ui.panel.page import build_page, rehearse
from axistwin.ui.panel.people import People, Person

RECONNECT_S = 30.0  # Seconds after which a disconnected page is deleted.
GOODBYE_S = 1
IDLE_S = 5  # Seconds for which a connection without a whole request stays open.
MOST_HEAD = 64 * 1024  # Longest head of a request in bytes.
MOST_CONNECTIONS = 200  # Connections of all browsers, some seven each: hosts in the same process need descriptors, too.
POLL_S = 0.01
NOWHERE = {"type": "http", "method": "GET", "path": "/", "query_string": b"", "headers": [], "server": ("", 0)}


class Panel:
    """Web server of the panel, which shows a session in browsers.  With a `comparison` it can only be looked at."""

    def __init__(self, title: str, session: Session, address: Address, comparison: Comparison | None = None) -> None:
        self.session, self.people, self.address = session, People(), address
        self.common = Common(session, comparison)
        self.common(Conversation)  # Messages are recorded even before a user opens the first page.
        self._title = title
        self._server: _Server | None = None
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> str:
        """Start the web server, and return the panel's URL.  The URL contains the token, if any.  Raises LinkError."""
        # If the port is in use, `listening_socket` raises LinkError.
        sock = listening_socket(self.address)
        server = self._server = _Server(
            uvicorn.Config(
                Gate(_application(self, self._title), self.address.token),
                http=_Connection,
                backlog=MOST_CONNECTIONS,
                log_level="warning",
                access_log=False,
                timeout_keep_alive=IDLE_S,
                timeout_graceful_shutdown=GOODBYE_S,
                ws_per_message_deflate=False,  # WebSocket messages are not compressed, because compression is slow.
            )
        )
        self._task = asyncio.create_task(server.serve(sockets=[sock]))
        while not server.started and not self._task.done():
            await asyncio.sleep(POLL_S)
        host, port = sock.getsockname()[:2]
        rehearse(Context(self.common, People(), Person("", "nobody")), Request(NOWHERE))
        self.common(Memory).keep()
        token = "" if self.address.token is None else f"?token={self.address.token}"
        return f"http://{f'[{host}]' if ':' in host else host}:{port}/{token}"

    async def close(self) -> None:
        if self._server is not None and self._task is not None:
            self._server.should_exit = True
            await self._task


class _Connection(AutoHTTPProtocol):  # type: ignore[misc, valid-type]
    """The connection of a browser; it is closed if there are too many, or if no whole request comes soon."""

    head = 0  # Number of bytes of a request whose head is not complete.

    def connection_made(self, transport: asyncio.Transport) -> None:
        super().connection_made(transport)
        if len(self.connections) > MOST_CONNECTIONS:
            transport.abort()
        else:
            self.timeout_keep_alive_task = self.loop.call_later(IDLE_S, self.timeout_keep_alive_handler)

    def data_received(self, data: bytes) -> None:
        waiting, before = self.timeout_keep_alive_task, self.cycle
        super().data_received(data)  # The first byte ends the waiting.
        if waiting is None or self.cycle is not before or self.transport.get_protocol() is not self:
            self.head = 0
            return
        self.timeout_keep_alive_task = self.loop.call_at(waiting.when(), self.timeout_keep_alive_handler)
        self.head += len(data)
        if self.head > MOST_HEAD:
            self.transport.abort()


class _Server(uvicorn.Server):
    """A web server that does not install signal handlers."""

    def capture_signals(self) -> AbstractContextManager[None]:  # type: ignore[override]
        return nullcontext()


def _application(panel: Panel, title: str) -> FastAPI:
    application = FastAPI(openapi_url=None)
    app.user_middleware.clear()  # Remove the middleware of an earlier panel in the same process.
    app.middleware_stack = None
    icon = (resources.files(__package__) / "panel.svg").read_text(encoding="utf-8")

    @ui.page("/")
    async def visit(request: Request) -> None:
        def enter() -> Context:
            person = panel.people[request.scope["person"]]
            layout.restore(person, request.cookies.get(layout.COOKIE))
            return Context(panel.common, panel.people, person)

        await build_page(enter)

    app.config.quasar_config["loadingBar"]["skipHijack"] = True  # Without a name, it is a finding of axe.
    ui.run_with(
        application,
        title=f"{'VIRTUAL' if panel.common.comparison is None else 'SHADOW'}: {title}",
        favicon=icon,
        show_welcome_message=False,
        reconnect_timeout=RECONNECT_S,
        tailwind=False,
        # Data for a browser on the same computer are not compressed, to save time.
        gzip_middleware_factory=None if is_loopback(panel.address.host) else GZipMiddleware,
    )
    return application
