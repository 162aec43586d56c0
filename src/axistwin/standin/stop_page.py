"""A page that shows that motors are live, and stops them.

A thread of its own serves the page, so that the page and its stop work while the emulation is busy.  The page can stop
motors but cannot start them.
"""

import json
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from threading import Thread
from typing import Any

from axistwin.errors import LinkError
from axistwin.links.urls import parse_as
from axistwin.storage import reason

PAGE = "text/html; charset=utf-8"
JSON = "application/json"
MOST_BODY = 1024
"""Longest body of a request that is read; the page sends none."""


class StopPage:
    """Web server for a page that shows the motors' state and has a button to stop all motors.

    `state` returns values for the page, and `stop` stops all motors; the server calls both functions in other threads.
    """

    def __init__(self, address: str, state: Callable[[], Mapping[str, Any]], stop: Callable[[], None]) -> None:
        """Serve the page at an address, PORT or HOST:PORT.  Raises LinkError if the port is in use."""
        found = parse_as("tcp", address if ":" in address else f":{address}")
        page = resources.files(__package__).joinpath("stop_page.html").read_bytes()

        class Handler(_Handler):
            content, read, act = page, staticmethod(state), staticmethod(stop)

        try:
            self._server = ThreadingHTTPServer((found.host, found.port or 0), Handler)
        except OSError as error:
            raise LinkError(
                f"cannot serve the page with the stop button at {address} ({reason(error)}): "
                "choose another port, e.g. --panel 8081"
            ) from None
        self._server.daemon_threads = True
        host, port = self._server.server_address[:2]
        self.url = f"http://{host!s}:{port}/"
        """URL of the page."""
        self._thread = Thread(target=self._server.serve_forever, name="stop page", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the web server and close its port."""
        self._server.shutdown()
        self._server.server_close()


class _Handler(BaseHTTPRequestHandler):
    """Answers HTTP requests: sends the page or the state, or stops all motors."""

    content: bytes
    read: Callable[[], Mapping[str, Any]]
    act: Callable[[], None]

    def do_GET(self) -> None:
        """Answer a GET request: send the page, or the state as JSON if the path is /state."""
        if self.path == "/":
            self._answer(HTTPStatus.OK, PAGE, self.content)
        elif self.path == "/state":
            self._answer(HTTPStatus.OK, JSON, json.dumps(type(self).read()).encode())
        else:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"")

    def do_POST(self) -> None:
        """Handle a POST request to any path: stop all motors."""
        type(self).act()
        self.rfile.read(min(int(self.headers.get("Content-Length") or 0), MOST_BODY))
        self.send_response(HTTPStatus.SEE_OTHER)
        self.send_header("Location", "/")
        self.send_header("Content-Length", "0")
        self.end_headers()

    def _answer(self, status: HTTPStatus, kind: str, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Frame-Options", "DENY")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: object) -> None:
        """Suppress the log of HTTP requests."""
