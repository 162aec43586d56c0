"""Controllers on real ports of this machine, served by an event loop in a thread."""

import asyncio
import socket
import threading
from collections.abc import Callable
from typing import Any, Self

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse
from axistwin.sim.serial_port import Flow

HOST_TIMEOUT_S = 300
"""Timeout in seconds after which a test fails."""


class Served:
    """A bench on real ports, at full speed unless a speed is given; a context manager."""

    def __init__(
        self, *, speed: float | None = None, flow: Flow = Flow.DTR, reset: bool = False, share: bool = False
    ) -> None:
        self.bench = Bench()
        self.server = Server(self.bench, speed=speed, flow=flow, reset=reset, share=share)
        self.problems: list[dict[str, Any]] = []
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(lambda _, context: self.problems.append(context))
        self._thread = threading.Thread(target=self._loop.run_forever)

    def __enter__(self) -> Self:
        self._thread.start()
        self.do(self.server.start)
        return self

    def __exit__(self, *_: object) -> None:
        self.do(self.server.close)
        self.do(lambda: None)  # connections are closed in the next turn of the loop
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(HOST_TIMEOUT_S)
        self._loop.close()
        assert self.problems == []

    def do(self, action: Callable[[], Any]) -> Any:
        async def act() -> Any:
            return action()

        return asyncio.run_coroutine_threadsafe(act(), self._loop).result(HOST_TIMEOUT_S)

    def later(self, action: Callable[[], object]) -> None:
        """Call a function in the bench's thread, without waiting for its result."""
        self._loop.call_soon_threadsafe(action)

    def act(self, action: Callable[[], object]) -> None:
        def act() -> None:
            action()
            self.server.pacer.work()

        self.do(act)

    def add(self, *, line: str | None = "instant", initialised: bool = True, **options: Any) -> Controller:
        """Add an IF1 to the bench, initialised or just switched on."""

        def act() -> Controller:
            controller = self.bench.add("if1", line=line, **options)
            return initialise(self.bench, controller) if initialised else controller

        return self.do(act)

    def add_board(self, **options: Any) -> Controller:
        return self.do(lambda: self.bench.add("1811", **options))

    def open(self, controller: Controller, url: str = "tcp://127.0.0.1:0") -> PortUrl:
        return self.open_name(controller.name, url)

    def open_name(self, name: str, url: str = "tcp://127.0.0.1:0") -> PortUrl:
        opening = self.server.open(name, parse(url))
        return asyncio.run_coroutine_threadsafe(opening, self._loop).result(HOST_TIMEOUT_S)

    def until(self, condition: Callable[[], object]) -> None:
        """Wait until a condition is true; it is checked after each advance of the bench."""
        so = threading.Event()

        def look() -> None:
            if condition():
                so.set()

        unwatch = self.do(lambda: self.server.pacer.subscribe(look))
        self.do(look)
        assert so.wait(HOST_TIMEOUT_S), "it never happened"
        self.do(unwatch)


def initialise(bench: Bench, controller: Controller) -> Controller:
    bench.run(1.1)
    controller.serial.write(b"(")
    bench.run(0.1)
    controller.serial.write(b"U61\r")
    bench.run(1.2)
    assert controller.serial.read() == b"U\r"
    return controller


def dial(url: PortUrl) -> socket.socket:
    return socket.create_connection((url.host, url.port), timeout=HOST_TIMEOUT_S)


def ask(connection: socket.socket, text: bytes = b"E\r", answer: bytes = b"C\r") -> bytes:
    connection.sendall(text)
    return receive(connection, len(answer))


def receive(connection: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count and (more := connection.recv(count - len(data))):
        data += more
    return data
