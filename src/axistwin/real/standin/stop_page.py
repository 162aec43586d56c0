"""The page of `axistwin stand-in` that shows live motors and stops them.

A thread of its own serves the page, so that the page and its stop work while the emulation is busy.  The page can stop
motors but cannot start them.
"""

import asyncio
import json
import socket
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.client import HTTPException, parse_headers
from importlib import resources
from io import BytesIO
from threading import Thread
from typing import Any

from axistwin.core.errors import LinkError, reason
from axistwin.links.urls import parse_as
from axistwin.links.web_gate import is_address, is_loopback, refusal

PAGE, JSON, TEXT = "text/html; charset=utf-8", "application/json", "text/plain; charset=utf-8"
MOST_VISITORS = 32  # Number of open connections; a further visitor takes the place of the oldest.
BACKLOG = 128  # Number of visitors that can wait for their connection.
LONGEST_S = 5.0  # Longest time in seconds of a visit.
MOST_HEAD, MOST_BODY = 8192, 8192  # Of a request; as many bytes after it are read and discarded.
Answer = tuple[HTTPStatus, str, bytes]


class StopPage:
    """Serves the page; `state` returns its values, `stop` stops all motors, both in any thread."""

    def __init__(self, address: str, state: Callable[[], Mapping[str, Any]], stop: Callable[[], None]) -> None:
        """Serve the page at an address, PORT or HOST:PORT.  Raises LinkError if the port is in use."""
        found = parse_as("tcp", address if ":" in address else f":{address}")
        self._state, self._stop = state, stop
        self._page = resources.files(__package__).joinpath("stop_page.html").read_bytes()
        try:
            family = socket.AF_INET6 if ":" in found.host else socket.AF_INET
            self._socket = socket.create_server((found.host, found.port), family=family, backlog=BACKLOG)
        except OSError as error:
            raise LinkError(
                f"cannot serve the page with the stop button at {address} ({reason(error)}): "
                "choose another port, e.g. --panel 8081"
            ) from None
        host, port = self._socket.getsockname()[:2]
        self.url = f"http://{f'[{host}]' if ':' in host else host}:{port}/"  # URL of the page.
        name = socket.gethostname().lower()
        self._names = {found.host.lower(), name, f"{name}.local"}
        self._only_here = is_loopback(host)
        self._visits: list[asyncio.StreamWriter] = []
        self._loop, self._closing = asyncio.new_event_loop(), asyncio.Event()
        self._thread = Thread(target=self._run, name="stop page", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._closing.set)
        self._thread.join()

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._serve())

    async def _serve(self) -> None:
        self._loop.set_exception_handler(_handle_exception)
        server = await asyncio.start_server(self._visit, sock=self._socket, limit=MOST_HEAD, backlog=BACKLOG)
        await self._closing.wait()
        server.close()

    async def _visit(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._visits.append(writer)
        if len(self._visits) > MOST_VISITORS:
            self._visits.pop(0).transport.abort()
        try:
            async with asyncio.timeout(LONGEST_S):
                writer.write(_http(*self._answer(await reader.readuntil(b"\r\n\r\n"))))
                await reader.read(MOST_BODY)  # Without this, closing could destroy the answer before it is read.
        except (OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            pass
        finally:
            writer.close()
            if writer in self._visits:
                self._visits.remove(writer)

    def _answer(self, head: bytes) -> Answer:
        line, _, rest = head.partition(b"\r\n")
        try:
            headers = parse_headers(BytesIO(rest))
        except HTTPException:
            return HTTPStatus.BAD_REQUEST, TEXT, b""
        if refused := refusal(headers.get, self._known, "an address of this computer, e.g. localhost"):
            return HTTPStatus.FORBIDDEN, TEXT, f"axistwin: {refused}\n".encode()
        match line.split(b" ")[:2]:
            case [b"GET", b"/"]:
                return HTTPStatus.OK, PAGE, self._page
            case [b"GET", b"/state"]:
                return HTTPStatus.OK, JSON, json.dumps(self._state()).encode()
            case [b"POST", b"/stop"]:
                self._stop()
                return HTTPStatus.SEE_OTHER, TEXT, b""
        return HTTPStatus.NOT_FOUND, TEXT, b""

    def _known(self, name: str) -> bool:
        """True for the names under which browsers reach this page, and not a web site that points here."""
        return is_loopback(name) or (not self._only_here and (is_address(name) or name in self._names))


def _handle_exception(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    if not isinstance(context.get("exception"), OSError):  # A visitor's connection concerns nobody else.
        loop.default_exception_handler(context)


def _http(status: HTTPStatus, kind: str, content: bytes) -> bytes:
    lines = [
        f"HTTP/1.1 {status.value} {status.phrase}", f"Content-Type: {kind}", f"Content-Length: {len(content)}",
        "Cache-Control: no-store", "X-Frame-Options: DENY", "Content-Security-Policy: frame-ancestors 'none'",
        "X-Content-Type-Options: nosniff", "Connection: close", *["Location: /"] * (status is HTTPStatus.SEE_OTHER),
    ]  # fmt: skip
    return "".join(f"{line}\r\n" for line in [*lines, ""]).encode() + content
