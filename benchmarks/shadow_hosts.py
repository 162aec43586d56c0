"""Hosts that do not know of the shadow between them and their machine, in real time: `shadow.py hosts`.

The eleven BASIC programs of the IF1's manual on PC-BASIC, a host with pyserial, a driver of axistwin and the EPICS
motor record of `axistwin ioc` talk to a bench through `axistwin shadow`.  On either side of the shadow each byte is
recorded: both records must be equal, and the shadow must find nothing.
"""

import asyncio
import os
import sys
import tempfile
import time
from asyncio.subprocess import DEVNULL, PIPE
from collections.abc import AsyncIterator, Awaitable, Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import asynccontextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import serial
from tests.basic.hosting import perform
from tests.basic.listings import MANUAL

from axistwin.bench import Bench
from axistwin.drivers import connect
from axistwin.links.server import Server
from axistwin.links.urls import PortUrl, parse

ROOT = Path(__file__).resolve().parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
LATE_S = 10.0
TOLERANCE_MS = "100"  # The machine is a program, too, which is late itself on a computer with other work.
BASIC = {
    1: ("U62", "9600 8N2"), 2: ("V61", "2400 8N2"), 3: ("V61", "1200 8N2"), 4: ("U61", "2400 8N2"),
    5: ("U62", "4800 8N2"), 6: ("V61", "2400 8N2"), 7: ("U61", "2400 8N2"), 8: ("U62", "9600 8N2"),
    9: ("U61", "2400 8N2"), 10: ("V62", "9600 8N2"), 11: ("V61", "2400 8N2"),
}  # fmt: skip
"""The format that each program sets, and its line; the sixth is for an IF2."""


class Tap:
    """Passes one TCP connection on, and keeps both ways."""

    def __init__(self) -> None:
        self.to_machine, self.to_host = bytearray(), bytearray()

    async def open(self, target: PortUrl) -> PortUrl:
        self._target = target
        self._server = await asyncio.start_server(self._serve, "127.0.0.1", 0)
        return PortUrl("tcp", "127.0.0.1", self._server.sockets[0].getsockname()[1])

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, back = await asyncio.open_connection(self._target.host, self._target.port)
        await asyncio.gather(
            self._pass(reader, back, self.to_machine), self._pass(there, writer, self.to_host), return_exceptions=True
        )

    async def _pass(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, kept: bytearray) -> None:
        with suppress(OSError):
            while data := await reader.read(4096):
                kept += data
                writer.write(data)
                await writer.drain()
        writer.close()

    def close(self) -> None:
        self._server.close()


class Verdict(NamedTuple):
    """What came of a host: bytes from and to it, whether they are the machine's, and the shadow's findings."""

    sent: int
    received: int
    same: bool
    found: list[str]


class Between:
    """A shadow between two taps; `through` is given the machine's port, and yields the host's."""

    def __init__(self, model: str, line: str) -> None:
        self._words = "--model", model, "--line", line, "--tolerance", TOLERANCE_MS
        self.near, self.far = Tap(), Tap()
        self.found: list[str] = []

    @asynccontextmanager
    async def through(self, machine: PortUrl) -> AsyncIterator[PortUrl]:
        real = await self.far.open(machine)
        program = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "axistwin", "shadow", str(real), *self._words, "--port", "tcp://127.0.0.1:0",
            stdout=PIPE, stderr=DEVNULL, env=ENVIRONMENT,
        )  # fmt: skip
        assert program.stdout is not None
        try:
            yield await self.near.open(parse((await program.stdout.readline()).decode().split()[-1]))
            await self._settle()
        finally:
            program.terminate()
            out, _ = await program.communicate()
            self.found = [line for line in out.decode().splitlines() if line[25:].split(":")[0].isalpha()]
            self.near.close()
            self.far.close()

    async def _settle(self) -> None:
        """Wait until everything that the host has sent is at the machine."""
        until = time.monotonic() + LATE_S
        while len(self.far.to_machine) < len(self.near.to_machine) and time.monotonic() < until:
            await asyncio.sleep(0.05)
        await asyncio.sleep(0.2)

    @property
    def verdict(self) -> Verdict:
        same = self.near.to_machine == self.far.to_machine
        same &= self.far.to_host.startswith(self.near.to_host)  # A host may have hung up before the last answer.
        return Verdict(len(self.near.to_machine), len(self.near.to_host), same, self.found)


def basic(program: int, speed: float = 1.0) -> Verdict:
    """Run one of the eleven programs; its moves must be the same as without a shadow."""
    (form, line), model = BASIC[program], "if2" if program == 6 else "if1"
    between, moves = Between(model, line), []
    for through in ({}, {"through": between.through, "speed": speed}):
        with tempfile.TemporaryDirectory() as folder:
            session = perform(program, form, Path(folder), model=model, line=line, **through)
            session.bench.run(2.0)
            moves.append(session.moves())
    verdict = between.verdict
    return verdict if moves[0] == moves[1] else verdict._replace(same=False, found=[f"other moves: {moves}"])


async def _talked(model: str, line: str, host: Callable[[PortUrl], Awaitable[None]]) -> Verdict:
    bench, between = Bench(), Between(model, line)
    bench.add(model)
    bench.run(2.0)
    server = Server(bench)
    try:
        port = await server.open(model, parse("tcp://127.0.0.1:0"))
        server.start()
        async with between.through(port) as seen:
            await host(seen)
    finally:
        server.close()
        await asyncio.sleep(0)
    return between.verdict


async def pyserial_host(port: PortUrl) -> None:
    def talk() -> None:
        with serial.serial_for_url(f"socket://{port.address}", timeout=5) as line:
            line.write(b"(")
            assert line.read_until(b"\r") == b"U\r"
            line.write(b"U61\r")
            time.sleep(1.3)
            for text in (b"X3000@4000$\r", b"X-3000$\r"):
                line.write(text)
                answer = b""
                while answer != b"C\r":
                    time.sleep(0.05)
                    line.write(b"E\r")
                    answer = line.read_until(b"\r")

    await asyncio.to_thread(talk)


async def driver_host(port: PortUrl, model: str = "if1", axis: str = "X") -> None:
    def move() -> None:
        with connect(str(port), model) as controller:
            for target in (4000, -1000, 0):
                controller.axes[axis].move_to(target)
                assert controller.axes[axis].wait(timeout=30).position == target

    await asyncio.to_thread(move)


async def epics_host(port: PortUrl) -> None:
    """Move the motor record of an IOC at the port by Channel Access."""
    number = str(os.getpid() % 20_000 + 20_000)
    ioc = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "axistwin", "ioc", str(port), "--model", "if1", "--prefix", "P:", "--port", number,
        "--json", stdout=PIPE, stderr=DEVNULL, env=ENVIRONMENT,
    )  # fmt: skip
    assert ioc.stdout is not None
    try:
        await ioc.stdout.readline()
        names = {"EPICS_CA_ADDR_LIST": "127.0.0.1", "EPICS_CA_AUTO_ADDR_LIST": "NO", "EPICS_CA_SERVER_PORT": number}
        for target in ("2000", "0"):
            put = await asyncio.create_subprocess_exec(
                sys.executable, "-m", "caproto.commandline.put", "--notify", "--timeout", "30", "P:if1:X", target,
                stdout=DEVNULL, stderr=DEVNULL, env={**ENVIRONMENT, **names},
            )  # fmt: skip
            assert await put.wait() == 0
    finally:
        ioc.terminate()
        await ioc.wait()


def talked(model: str, line: str, host: Callable[[PortUrl], Awaitable[None]]) -> Verdict:
    return asyncio.run(_talked(model, line, host))


HOSTS: dict[str, Callable[[], Verdict]] = {
    **({f"BASIC sample {number}": partial(basic, number) for number in BASIC} if MANUAL.exists() else {}),
    "pyserial": partial(talked, "if1", "9600 8N2", pyserial_host),
    "driver, if1": partial(talked, "if1", "9600 8N2", driver_host),
    "driver, smartmotor": partial(
        talked, "smartmotor", "9600 8N1", partial(driver_host, model="smartmotor", axis="shaft")
    ),
    "EPICS motor record": partial(talked, "if1", "9600 8N2", epics_host),
}


def run(name: str) -> Any:
    try:
        return HOSTS[name]()
    except Exception as error:  # noqa: BLE001  # printed as the verdict
        return error


def hosts(only: str = "", at_once: int = 4) -> bool:
    chosen, good, began = [name for name in HOSTS if only in name], 0, time.monotonic()
    with ProcessPoolExecutor(at_once) as pool:
        for name, verdict in zip(chosen, pool.map(run, chosen), strict=True):
            if not isinstance(verdict, Verdict):
                print(f"{name:20} {verdict!r}", flush=True)
                continue
            good += verdict.same and not verdict.found
            words = "the same bytes" if verdict.same else "OTHER BYTES"
            print(
                f"{name:20} {verdict.sent:5} bytes sent, {verdict.received:5} received: {words}, "
                f"{len(verdict.found)} findings {verdict.found or ''}",
                flush=True,
            )
    print(f"{good} of {len(chosen)} hosts unchanged, without a finding ({time.monotonic() - began:.0f} s)")
    return good == len(chosen)
