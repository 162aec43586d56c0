"""The panel on its own port, in the event loop that paces the bench."""

import asyncio
import secrets
import socket
from contextlib import AbstractContextManager, nullcontext

import uvicorn
from fastapi import FastAPI, Request
from nicegui import ui

from axistwin.apps.panel.look import Look
from axistwin.apps.panel.page import page
from axistwin.apps.panel.people import People
from axistwin.apps.sessions.session import Session
from axistwin.errors import LinkError

RECONNECT_S = 30.0
"""So long a page that has lost its connection finds everything as it was."""


class Web:
    """A web server for one session."""

    def __init__(self, session: Session, title: str) -> None:
        self.session, self.people = session, People()
        self._server = _Server(uvicorn.Config(_application(self, title), log_level="warning", access_log=False))
        self._task: asyncio.Task[None] | None = None

    async def open(self, host: str, port: int) -> str:
        """Serve there; port 0: any free one.  Returns the address.  Raises LinkError."""
        sock = _listening(host, port)
        self._task = asyncio.create_task(self._server.serve(sockets=[sock]))
        while not self._server.started and not self._task.done():
            await asyncio.sleep(0.01)
        found = sock.getsockname()
        return f"http://{found[0]}:{found[1]}/"

    async def close(self) -> None:
        """Say goodbye to every browser."""
        self._server.should_exit = self._server.force_exit = True
        if self._task is not None:
            await self._task


class _Server(uvicorn.Server):
    """One that leaves signals to the application."""

    def capture_signals(self) -> AbstractContextManager[None]:  # type: ignore[override]
        return nullcontext()


def _application(web: Web, title: str) -> FastAPI:
    application = FastAPI(openapi_url=None)

    @ui.page("/")
    def visit(request: Request) -> None:
        key = request.cookies.get("axistwin") or secrets.token_urlsafe(16)
        page(Look(web.session, web.people, web.people[key]))

    ui.run_with(application, title=title, show_welcome_message=False, reconnect_timeout=RECONNECT_S)
    return application


def _listening(host: str, port: int) -> socket.socket:
    try:
        return socket.create_server((host, port))
    except OSError as error:
        raise LinkError(f"cannot show a panel on {host}:{port}: {(error.strerror or str(error)).lower()}") from None
