"""Round trips of a register read over the bus socket, as a ratio to a bare echo server in the same run.

Client, echo server and measurement are those of `round_trip.py`; the board is an 1811 at `--speed max`.
"""

import asyncio
import contextlib
import socket
import subprocess
import sys
from collections.abc import Iterator

from round_trip import RUNS, rate, serve_echo

GOAL = 0.3
READ, ANSWER = b"r 1\n", b"50\n"
ECHO = b"r1\n"


def main() -> None:
    """Print the ratio."""
    with server("board") as board, server("echo") as echo:
        while board.send(READ) and board.recv(16) != ANSWER:
            pass  # initialisation of the board
        rates = [(rate([board], READ, ANSWER), rate([echo], ECHO, ECHO)) for _ in range(RUNS)]
    ratio = max(board_rate for board_rate, _ in rates) / max(echo_rate for _, echo_rate in rates)
    print(f"register round trips over the bus socket: ratio {ratio:.2f} of a bare echo (goal >= {GOAL})")


@contextlib.contextmanager
def server(kind: str) -> Iterator[socket.socket]:
    """Yield a connection to a server process of this kind."""
    with subprocess.Popen([sys.executable, __file__, kind], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        connection = socket.create_connection(("127.0.0.1", int(process.stdout.readline())))
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            yield connection
        finally:
            connection.close()
            process.terminate()


async def serve_board() -> None:
    """Serve an 1811 on a port."""
    from axistwin import Bench
    from axistwin.links.server import Server
    from axistwin.links.urls import parse

    server = Server(Bench(), speed=None)
    url = await server.open(server.bench.add("1811").name, parse("bus://127.0.0.1:0"))
    server.start()
    print(url.port, flush=True)
    await asyncio.get_running_loop().create_future()


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["board"]:
            asyncio.run(serve_board())
        case ["echo"]:
            asyncio.run(serve_echo(1))
        case _:
            main()
