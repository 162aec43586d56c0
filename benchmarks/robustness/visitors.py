"""Prove that nothing is left of clients that come and go: descriptors, threads, tasks, memory.

    python benchmarks/robustness/visitors.py [--seed 1] [--clients 1000] [--only tcp,ca]

Each server is visited by clients that behave as the seed says: they ask and read, send nonsense or half a message, or
connect and do nothing; half of them close, the others reset the connection.  A tenth more clients come first and fill
caches.  When all have left, the server's process may hold no more descriptors, threads, tasks and child processes than
before, and for each client at most 512 bytes that Python has allocated, or for PV Access and the language server, whose
memory Python does not count here, 4 KiB of resident memory.
A server that keeps the session of a lost client for some time gets this time.  Exit code 1 if something is left.
"""

import argparse
import asyncio
import ctypes
import gc
import json
import logging
import os
import random
import socket
import struct
import sys
import threading
import tracemalloc
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src"))

from axistwin import Bench
from axistwin.links.server import Server
from axistwin.links.urls import parse

C = ctypes.CDLL(None)
AT_ONCE = 4
"""Clients that are connected at the same time."""
PYTHON_BYTES, RESIDENT_BYTES = 512, 4096
"""Largest memory that a client may leave."""
MANY = 100
"""Number of clients from which on memory can be judged."""
PATIENCE_S = 90.0
"""Longest time until everything of the last client is gone."""
Visit = Callable[[random.Random], Awaitable[None]]


@dataclass(frozen=True)
class Held:
    """What a process holds."""

    descriptors: int
    threads: int
    tasks: int
    children: int
    python: int
    resident: int

    @staticmethod
    def by(process: int | str = "self") -> "Held":
        """Return what a process holds; tasks and Python's memory are known only for this one."""
        root, own = Path(f"/proc/{process}"), process == "self"
        gc.collect()
        if own and hasattr(C, "malloc_trim"):
            C.malloc_trim(0)  # give free memory back, so that the resident memory is what is in use
        threads = [*(root / "task").iterdir()]
        return Held(
            len([*(root / "fd").iterdir()]),
            threading.active_count() if own else len(threads),
            len(asyncio.all_tasks()) if own else 0,
            sum(len((each / "children").read_text().split()) for each in threads),
            tracemalloc.get_traced_memory()[0] if own else 0,
            int((root / "statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE"),
        )


@dataclass(frozen=True)
class Place:
    """A server that can be visited; `process` is where it runs, `in_c` is true if its library is written in C."""

    visit: Visit
    process: int | str = "self"
    in_c: bool = False

    def left(self, held: Held, before: Held, clients: int) -> list[str]:
        """Return in words what is left of the clients."""
        found = []
        for name in ("descriptors", "threads", "tasks", "children"):
            more = getattr(held, name) - getattr(before, name)
            found += [f"{more} {name}"] if more > 0 else []
        python, resident = held.python - before.python, held.resident - before.resident
        if clients >= MANY and python > clients * PYTHON_BYTES + 2**16:
            found.append(f"{python // clients} bytes per client")
        if self.in_c and clients >= MANY and resident > clients * RESIDENT_BYTES + 2**21:
            found.append(f"{resident // clients} bytes of resident memory per client")
        return found


# How clients behave


def nonsense(chance: random.Random) -> bytes:
    """Return some bytes that mean nothing."""
    return chance.randbytes(chance.randrange(1, 200))


async def visit_tcp(chance: random.Random, port: int, requests: list[bytes]) -> None:
    """Connect, perhaps send something, perhaps read an answer, and leave."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    request = chance.choice(requests)
    sent = chance.choice((request, request, request[: len(request) // 2], nonsense(chance), b""))
    writer.write(sent)
    if sent == request:
        with suppress(TimeoutError, ConnectionError):
            await asyncio.wait_for(reader.read(100), 0.05)
    await leave(chance, writer)


async def leave(chance: random.Random, writer: asyncio.StreamWriter) -> None:
    """Close or reset a connection."""
    if chance.random() < 0.5:
        own = writer.get_extra_info("socket")
        own.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    writer.close()
    with suppress(ConnectionError):
        await writer.wait_closed()


# The servers


@asynccontextmanager
async def served(url: str, model: str, requests: list[bytes], **options: Any) -> AsyncIterator[Place]:
    """Serve a controller at a TCP port."""
    bench = Bench()
    bench.add(model, name="one", history=100)
    server = Server(bench, speed=None, **options)
    port = (await server.open("one", parse(url))).port
    assert port is not None
    server.start()
    try:
        yield Place(lambda chance: visit_tcp(chance, port, requests))
    finally:
        server.close()


STATUS = [b"I\r", b"K\r", b"(\r"]
TELNET = [b"\xff\xfd\x2c" + STATUS[0], b"\xff\xfa\x2c\x01\x00\x00\x25\x80\xff\xf0" + STATUS[1]]


def _tcp() -> AbstractAsyncContextManager[Place]:
    return served("tcp://127.0.0.1:0", "if1", STATUS)


def _shared() -> AbstractAsyncContextManager[Place]:
    return served("tcp://127.0.0.1:0", "if1", STATUS, share=True)


def _rfc2217() -> AbstractAsyncContextManager[Place]:
    return served("rfc2217://127.0.0.1:0", "if1", TELNET)


def _bus() -> AbstractAsyncContextManager[Place]:
    return served("bus://127.0.0.1:0", "1811", [b"r 1\n", b"s 1\n", b"init\n", b"r 0 16\n"])


@asynccontextmanager
async def _pty() -> AsyncIterator[Place]:
    bench = Bench()
    bench.add("if1", name="one", history=100)
    server, one = Server(bench, speed=None), asyncio.Lock()
    path = (await server.open("one", parse("pty:"))).path
    server.start()

    async def visit(chance: random.Random) -> None:
        async with one:  # two programs at one device are one client
            device = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                if data := chance.choice((*STATUS, nonsense(chance), b"")):
                    os.write(device, data)
                for _ in range(chance.randrange(5)):
                    await asyncio.sleep(0)
            finally:
                os.close(device)
            await asyncio.sleep(0.002)

    try:
        yield Place(visit)
    finally:
        server.close()


@asynccontextmanager
async def _panel() -> AsyncIterator[Place]:
    from axistwin.scenes.sessions.session import Session
    from axistwin.ui.panel import web
    from axistwin.ui.panel.web import Address, Panel

    web.RECONNECT_S = 0.5
    session = Session(_one_if1)
    made = Panel("visitors", session, Address("127.0.0.1", 0, None))
    port = int((await made.open()).rstrip("/").rpartition(":")[2])
    session.run()
    logging.getLogger("uvicorn.error").setLevel(logging.ERROR)  # a line for each nonsense
    page = b"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
    upgrade = (
        b"GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
        b"Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    foreign = page.replace(b"localhost", b"example.org")
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(upgrade)  # the first web socket begins a task that stays
    await reader.readuntil(b"\r\n\r\n")
    writer.close()
    try:
        yield Place(lambda chance: visit_tcp(chance, port, [page, upgrade, foreign, foreign]))
    finally:
        await made.close()


def _one_if1() -> Bench:
    bench = Bench()
    bench.add("if1", name="one", history=100)
    return bench


@asynccontextmanager
async def _ioc(*, pva: bool) -> AsyncIterator[int]:
    from axistwin.real.integrations import of_scene
    from axistwin.real.integrations.epics.ioc import Ioc

    os.environ |= {"PVXS_LOG": "*=CRIT", "EPICS_CAS_AUTO_BEACON_ADDR_LIST": "NO", "EPICS_CAS_BEACON_ADDR_LIST": ""}
    bench = Bench()
    bench.add("1811", name="one", history=100)
    port = _free_port()
    async with (
        await of_scene(bench, {}, speed=None) as machine,
        Ioc(machine, "L:").serving(port=port, pv_access=pva),
    ):
        yield port


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as made:
        return int(made.getsockname()[1]) % 40_000 + 10_000


@asynccontextmanager
async def _ca() -> AsyncIterator[Place]:
    async with _ioc(pva=False) as port:
        yield Place(lambda chance: _visit_ca(chance, port))


async def _visit_ca(chance: random.Random, port: int) -> None:
    import caproto

    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    circuit = caproto.VirtualCircuit(caproto.CLIENT, ("127.0.0.1", port), 0)
    channel = caproto.ClientChannel("L:one:motor.VAL", circuit)

    def send(*commands: Any) -> None:
        writer.write(b"".join(map(bytes, circuit.send(*commands))))

    async def until(kind: type) -> None:
        while True:
            for command in circuit.recv(await reader.read(4096))[0]:
                circuit.process_command(command)
                if isinstance(command, kind):
                    return

    does = chance.randrange(6)
    if does == 0:
        writer.write(nonsense(chance))
    else:
        send(caproto.VersionRequest(0, 13), channel.host_name("here"), channel.client_name("me"), channel.create())
        await until(caproto.CreateChanResponse)
    if does > 1:
        send(channel.subscribe())
        await until(caproto.EventAddResponse)
    if does > 3:  # it leaves while its move is in progress
        send(channel.write((float(chance.randrange(200)),), notify=True))
        send(channel.read())
        await until(caproto.ReadNotifyResponse)
    await leave(chance, writer)


@asynccontextmanager
async def _pva() -> AsyncIterator[Place]:
    def message(command: int, body: bytes) -> bytes:
        return struct.pack("<BBBBI", 0xCA, 2, 0, command, len(body)) + body

    channel = b"L:one:motor"
    valid = message(1, struct.pack("<IHH", 0x10000, 0x7FFF, 0) + b"\x09anonymous\xff")
    create = message(7, struct.pack("<HI", 1, 1) + bytes([len(channel)]) + channel)
    watch = message(13, struct.pack("<II", 1, 1) + b"\x08\x80\x00\x00")
    async with _ioc(pva=True) as port:
        requests = [valid, valid + create, valid + create + watch, valid + create + watch]
        yield Place(lambda chance: visit_tcp(chance, port + 11, requests), in_c=True)


@asynccontextmanager
async def _opcua() -> AsyncIterator[Place]:
    from axistwin.real.integrations import of_scene
    from axistwin.real.integrations.opcua import server

    bench = Bench()
    bench.add("1811", name="one", history=100)
    port = _free_port()
    async with await of_scene(bench, {}, speed=None) as machine, server.serving(machine, port=port) as url:
        yield Place(lambda chance: _visit_opcua(chance, url, port))


async def _visit_opcua(chance: random.Random, url: str, port: int) -> None:
    from asyncua import Client, ua

    if chance.random() < 0.3:
        await visit_tcp(chance, port, [b"HELF" + struct.pack("<I", 32) + bytes(24)])
        return
    client = Client(url, timeout=30)
    client.session_timeout = 5000
    await client.connect()
    axis = client.get_node("ns=2;s=one.motor")
    if chance.random() < 0.5:
        subscription = await client.create_subscription(20, _Ignoring())
        await subscription.subscribe_data_change(client.get_node("ns=2;s=one.Axes.motor.Position"))
    if chance.random() < 0.3:
        with suppress(ua.UaStatusCodeError):  # another client has replaced the motion
            await axis.call_method("2:MoveTo", float(chance.randrange(200)))
    if chance.random() < 0.5:
        await client.disconnect()
    else:
        client.uaclient.protocol.transport.abort()  # its session is left behind
        await client.disconnect()


class _Ignoring:
    def datachange_notification(self, *_: object) -> None:
        pass


@asynccontextmanager
async def _stop_page() -> AsyncIterator[Place]:
    from axistwin.real.standin.stop_page import StopPage

    page = StopPage("0", lambda: {"state": "LIVE: table.X", "live": True}, lambda: None)
    port = int(page.url.rstrip("/").rpartition(":")[2])
    head = b" HTTP/1.1\r\nHost: localhost\r\n"
    state, stop = b"GET /state" + head + b"\r\n", b"POST /stop" + head + b"Content-Length: 2\r\n\r\n"
    foreign = state.replace(b"localhost", b"example.org")
    try:
        yield Place(lambda chance: visit_tcp(chance, port, [state, stop, b"GET /" + head + b"\r\n", foreign]))
    finally:
        page.close()


@asynccontextmanager
async def _lsp() -> AsyncIterator[Place]:
    """The documents of one editor, which are the clients of a language server."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "axistwin", "lsp", stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE
    )
    assert process.stdin is not None
    assert process.stdout is not None
    number = 0

    def tell(method: str, params: Any, **more: Any) -> None:
        body = json.dumps({"jsonrpc": "2.0", "method": method, "params": params, **more}).encode()
        process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))

    async def hear() -> Any:
        head = await process.stdout.readuntil(b"\r\n\r\n")
        return json.loads(await process.stdout.readexactly(int(head.split(b"Content-Length: ")[1].split()[0])))

    async def visit(chance: random.Random) -> None:
        nonlocal number
        number += 1
        uri = f"file:///{number}.{chance.choice(('sms', 'if1', '181x', 'talk', 'toml'))}"
        text = chance.choice(("", "X100$\n", "P=100 G\n", "[[controller]]\n", nonsense(chance).decode("latin-1")))
        tell("textDocument/didOpen", {"textDocument": {"uri": uri, "languageId": "a", "version": 1, "text": text}})
        tell("textDocument/didClose", {"textDocument": {"uri": uri}})

    async def answered() -> None:
        tell("shutdown", None, id=2)
        tell("exit", None)
        while (await hear()).get("id") != 2:
            pass

    tell("initialize", {"processId": None, "rootUri": None, "capabilities": {}}, id=1)
    while (await hear()).get("id") != 1:
        pass
    listening = asyncio.ensure_future(_drain(process.stdout))
    try:
        yield Place(visit, process.pid, in_c=True)
    finally:
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)
        await asyncio.wait_for(answered(), 30)
        await asyncio.wait_for(process.wait(), 30)


async def _drain(stream: asyncio.StreamReader) -> None:
    while await stream.read(65536):
        pass


SERVERS: dict[str, Callable[[], AbstractAsyncContextManager[Place]]] = {
    "tcp": _tcp, "shared": _shared, "rfc2217": _rfc2217, "pty": _pty, "bus": _bus, "panel": _panel, "ca": _ca,
    "pva": _pva, "opcua": _opcua, "stop_page": _stop_page, "lsp": _lsp,
}  # fmt: skip


async def visits(name: str, clients: int, seed: int) -> list[str]:
    """Visit a server; return in words what is left of the clients."""
    chance = random.Random(f"{seed} {name}")
    logging.getLogger("axistwin.links").setLevel(logging.ERROR)  # refusals of second clients
    async with SERVERS[name]() as place:
        if clients >= MANY:
            tracemalloc.start()
        await wave(place, max(clients // 10, 2 * AT_ONCE), chance)
        before = await at_rest(place, None, clients)
        await wave(place, clients, chance)
        after = await at_rest(place, before, clients)
        found = place.left(after, before, clients)
    tracemalloc.stop()
    return found


async def wave(place: Place, clients: int, chance: random.Random) -> None:
    """Let clients come and go, some at the same time."""
    seeds = [chance.random() for _ in range(clients)]

    async def some() -> None:
        while seeds:
            await place.visit(random.Random(seeds.pop()))

    await asyncio.gather(*(some() for _ in range(AT_ONCE)))


async def at_rest(place: Place, before: Held | None, clients: int) -> Held:
    """Return what the process holds when nothing more goes away."""
    loop = asyncio.get_running_loop()
    end, held = loop.time() + PATIENCE_S, Held.by(place.process)
    while loop.time() < end and (before is None or place.left(held, before, clients)):
        await asyncio.sleep(0.1 if before else 0.4)
        last, held = held, Held.by(place.process)
        if before is None and (last.descriptors, last.tasks) == (held.descriptors, held.tasks):
            break
    return held


def main(seed: int, clients: int, only: list[str]) -> bool:
    """Print a line for each server; return True if nothing is left."""
    good = True
    for name in only or SERVERS:
        found = asyncio.run(visits(name, clients, seed))
        print(f"{name}: {clients} clients, {'left: ' + ', '.join(found) if found else 'nothing is left'}", flush=True)
        good = good and not found
    print("held" if good else "BROKEN", f"(seed {seed})")
    return good


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--clients", type=int, default=1000)
    parser.add_argument("--only", default="", help=f"of {','.join(SERVERS)}")
    given = parser.parse_args()
    sys.exit(0 if main(given.seed, given.clients, given.only.split(",") if given.only else []) else 1)
