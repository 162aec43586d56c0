"""Run a sample program on PC-BASIC and, in the same event loop, serve a controller to it on a loopback port."""

import asyncio
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import to_ns
from axistwin.links.pacing import Pacer
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse

from .interpreter import run_basic
from .listings import runnable, source

POWER_UP_S = 1.5
"""Until a controller that has just been switched on listens."""
READING_S = 1.2
"""What a person takes to read a prompt, in virtual time; the initial ramp calculation is over by then."""
COM1 = {"tcp": "SOCKET", "rfc2217": "RFC2217", "pty": "PORT"}
KEYS = {"SPACE": " ", "PRESS CR": "\r"}


@dataclass
class Session:
    bench: Bench
    controller: Controller
    form: str
    """The data format that the program has set, such as `U62`."""
    screen: str = ""
    """What the program has printed."""
    heard: bytearray = field(default_factory=bytearray)
    """What the controller has sent to it."""
    heard_ns: list[int] = field(default_factory=list)
    """When each of these characters had come."""

    def listen(self) -> None:
        def hear(byte: int, _: object) -> None:
            self.heard.append(byte)
            self.heard_ns.append(self.bench.now)

        self.controller.serial.subscribe_received(hear)

    def ask(self, text: str) -> str:
        """Return the controller's answer to a message, without echo and terminator."""
        message = text.encode() + (b"\n" if self.form.startswith("V") else b"\r")
        self.controller.serial.read()
        self.controller.serial.write(message)
        self.bench.run(0.3)
        reply = self.controller.serial.read()
        return (reply.removeprefix(message) if self.form.endswith("2") else reply).decode().strip()

    def moves(self) -> list[dict[str, int]]:
        """Return all moves since power-up: for each, the axes that began together and their pulses."""
        by_start: dict[int, dict[str, int]] = {}
        for name, axis in self.controller.axes.items():
            for stroke in axis.train.moves:
                if stroke.profile.pulses:
                    by_start.setdefault(stroke.start_ns, {})[name] = stroke.direction * stroke.profile.pulses
        return [by_start[start_ns] for start_ns in sorted(by_start)]


def perform(
    program: int,
    form: str,
    directory: Path,
    *,
    link: str = "tcp",
    speed: float = 40,
    prepare: Callable[[Bench], object] = lambda bench: None,
    through: Callable[[PortUrl], AbstractAsyncContextManager[PortUrl]] = nullcontext,
    **added: Any,
) -> Session:
    """Run a sample program to its end, with a controller that was switched on before.

    `added` puts the controller on the bench; `prepare` is called when the controller listens; `through` returns the
    port of what is between the program and the controller.  The last characters of
    the program are transmitted before the return.
    """
    bench = Bench()
    session = Session(bench, bench.add(**{"model": "if1", **added}), form)
    bench.run(POWER_UP_S)
    session.listen()
    prepare(bench)
    session.screen = asyncio.run(_serve(bench, session.controller.name, link, speed, program, directory, through))
    assert bench.run_until(lambda: session.controller.serial.pending == 0, timeout=10)
    return session


async def _serve(bench: Bench, name: str, link: str, speed: float, program: int, directory: Path, through: Any) -> str:
    server = Server(bench, speed=speed)
    try:
        port = await server.open(name, parse("pty:" if link == "pty" else f"{link}://127.0.0.1:0"))
        server.start()
        async with through(port) as port:
            com1 = f"{COM1[link]}:{port.path if link == 'pty' else port.address}"
            # The interpreter lingers after hanging up, so when it has ended the loop has received everything.
            return await run_basic(source(runnable(program)), com1, KEYS, lambda: _read(bench, server.pacer), directory)
    finally:
        server.close()
        await asyncio.sleep(0)  # connections are closed in the next turn of the loop


async def _read(bench: Bench, pacer: Pacer) -> None:
    """Let as much time pass as a user needs to read a prompt."""
    read, seen = bench.clock.timeout(to_ns(READING_S)), asyncio.Event()
    unwatch = pacer.subscribe(lambda: seen.set() if read.processed else None)
    pacer.work()
    await seen.wait()
    unwatch()
