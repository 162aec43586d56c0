"""Round trips of a request over TCP, as a ratio to a bare echo server, with the same client in the same run.

The echo server is the fastest one in asyncio: a `Protocol` that returns its input.  The controllers, IF1s asked `E`
and a SmartMotor asked `RP`, run with `--line instant --speed max`, each on its own port, all in one process, like the
echo ports.  The second ratio is by processor time of server and client, for a computer with other work; it needs
Linux.
"""

import asyncio
import contextlib
import selectors
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from statistics import median

ASK = b"E\r"
ROUND_TRIPS = 1500
RUNS = 15
GOALS = (("if1", 1, ASK, ASK, 0.95), ("if1", 50, ASK, ASK, 0.95), ("smartmotor", 1, b"RP\r", b"0\r", 0.95))
"""Model, clients, request, answer, ratio."""


def main() -> None:
    """Print the ratios."""
    for model, clients, ask, answered, goal in GOALS:
        ratio, by_processor = measure(model, clients, ask, answered)
        who = f"{model}, {clients} client{'s' if clients > 1 else ''}"
        print(f"round trips of {ask.decode().strip()}, {who}: ratio {ratio:.2f} (goal >= {goal})")
        print(f"  by processor time: ratio {by_processor:.2f}")


def measure(model: str, clients: int, ask: bytes, answered: bytes) -> tuple[float, float]:
    """Return round trips per second of the twin, divided by those of the echo server, by the wall clock and by
    processor time; the medians of pairs of runs, one after the other.
    """
    with server(model, clients) as (twin, twin_pid), server("echo", clients) as (echo, echo_pid):
        for connection in twin if model == "if1" else ():
            initialise(connection)
        runs = [(*rates(twin, twin_pid, ask, answered), *rates(echo, echo_pid)) for _ in range(RUNS)]
    by_wall, by_processor = ([run[k] / run[k + 2] for run in runs] for k in range(2))
    return median(by_wall), median(by_processor)


def processor_s(pid: int) -> float:
    """Return the processor time of a process."""
    return time.clock_gettime(~pid << 3 | 2)  # the number of the process's clock in Linux


def initialise(connection: socket.socket) -> None:
    """Initialise an IF1, so that it answers status requests."""
    for text, answer in ((b"(", b"U\r"), (b"U61\r" + ASK, b"C\r")):
        connection.sendall(text)
        got = b""
        while len(got) < len(answer):
            got += connection.recv(16)
        assert got == answer, got


def rates(connections: list[socket.socket], pid: int, ask: bytes = ASK, answered: bytes = ASK) -> tuple[float, float]:
    """Return round trips per second, and per second of processor time of the client and the server `pid`.

    Each connection has one request at a time.  `answered`: the expected answer.
    """
    with selectors.EpollSelector() as selector:
        for connection in connections:
            selector.register(connection, selectors.EVENT_READ)
        began, before = time.perf_counter(), processor_s(pid) + time.process_time()
        for connection in connections:
            connection.send(ask)
        left = ROUND_TRIPS
        while left > 0:
            for key, _ in selector.select():
                answer = key.fileobj.recv(16)
                assert len(answer) == len(answered)
                key.fileobj.send(ask)
                left -= 1
        took, worked = time.perf_counter() - began, processor_s(pid) + time.process_time() - before
        for connection in connections:  # the last answers
            connection.recv(16)
        return (ROUND_TRIPS - left) / took, (ROUND_TRIPS - left) / worked


@contextlib.contextmanager
def server(kind: str, ports: int) -> Iterator[tuple[list[socket.socket], int]]:
    """Yield connections to all ports of a server process of this kind, and the number of the process."""
    with subprocess.Popen([sys.executable, __file__, kind, str(ports)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        numbers = process.stdout.readline().split()
        connections = [socket.create_connection(("127.0.0.1", int(number))) for number in numbers]
        for connection in connections:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            yield connections, process.pid
        finally:
            for connection in connections:
                connection.close()
            process.terminate()


class Echo(asyncio.Protocol):
    """Protocol that returns its input."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Store the connection of a new client."""
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        """Return the received data."""
        self.transport.write(data)


async def serve_echo(ports: int) -> None:
    """Serve this number of echo ports."""
    loop = asyncio.get_running_loop()
    servers = [await loop.create_server(Echo, "127.0.0.1", 0) for _ in range(ports)]
    print(*(server.sockets[0].getsockname()[1] for server in servers), flush=True)
    await loop.create_future()


async def serve_twin(model: str, ports: int) -> None:
    """Serve this number of controllers of a model, each on its own port."""
    from axistwin import Bench
    from axistwin.links.server import Server
    from axistwin.links.urls import parse

    bench = Bench()
    server = Server(bench, speed=None)
    for _ in range(ports):
        await server.open(bench.add(model, line="instant").name, parse("tcp://127.0.0.1:0"))
    server.start()
    print(*(url.port for _, url in server.ports), flush=True)
    await asyncio.get_running_loop().create_future()


if __name__ == "__main__":
    if len(sys.argv) == 3:
        what, ports = sys.argv[1], int(sys.argv[2])
        asyncio.run(serve_echo(ports) if what == "echo" else serve_twin(what, ports))
    else:
        main()
