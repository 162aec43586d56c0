"""Round trips through `axistwin shadow`, against a bare relay in the same run: a twin that works, hangs, or has failed.

    python benchmarks/shadow_relay.py [--round-trips 1500] [--rounds 5]

The machine is a TCP server that answers each request at once.  The two relays are asked in turns.  Printed are the
median and the 99th percentile, and what the twin adds to the latter; the goal is 1 ms on quiet cores.
"""

import argparse
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from statistics import median, quantiles

SOURCE = str(Path(__file__).resolve().parents[1] / "src")
GOAL_MS = 1.0
BARE = """
import asyncio, sys
from axistwin.links.relay import Relay
from axistwin.links.server import Server
from axistwin.links.urls import parse
from axistwin.sim.frames import UartFormat
from axistwin.sim.serial_port import Flow

async def main():
    relay = Relay(sys.argv[1].replace("tcp:", "socket:"), "if1", UartFormat(9600, 8, "N", 2))
    server = Server(relay.bench, flow=Flow.NONE)
    await server.open("if1", parse("tcp://127.0.0.1:0"))
    server.start()
    relay.start(server.pacer, print)
    print(f"if1 listening on {server.ports[0][1]}", flush=True)
    await asyncio.Event().wait()

asyncio.run(main())
"""


def machine() -> str:
    """Answer requests at once, at any number of connections; return the URL."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve(connection: socket.socket) -> None:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while data := connection.recv(64):
            if data.endswith((b"\r", b"(")):
                connection.sendall(b"U\r" if data.endswith(b"(") else b"C\r")

    def accept() -> None:
        while True:
            connection, _ = server.accept()
            threading.Thread(target=serve, args=(connection,), daemon=True).start()

    threading.Thread(target=accept, daemon=True).start()
    return f"tcp://127.0.0.1:{server.getsockname()[1]}"


def started(*command: str) -> tuple[subprocess.Popen[str], socket.socket]:
    program = subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env={**os.environ, "PYTHONPATH": SOURCE},
    )  # fmt: skip
    assert program.stdout is not None
    host, _, port = program.stdout.readline().strip().rpartition("//")[2].rpartition(":")
    connection = socket.create_connection((host, int(port)), timeout=60)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return program, connection


def round_trips(connection: socket.socket, count: int) -> list[float]:
    """Return the times of round trips in ms."""
    times = []
    for _ in range(count):
        began = time.perf_counter()
        connection.sendall(b"E\r")
        data = b""
        while not data.endswith(b"\r"):
            data += connection.recv(64)
        times.append(1000 * (time.perf_counter() - began))
        time.sleep(0.001)
    return times


def twin_of(pid: int) -> int:
    """Return the process of the twin."""
    return int(Path(f"/proc/{pid}/task/{pid}/children").read_text().split()[0])


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--round-trips", type=int, default=1500)
    parser.add_argument("--rounds", type=int, default=5)
    given = parser.parse_args()
    url = machine()
    bare, bare_line = started("-c", BARE, url)
    shadow, shadow_line = started("-m", "axistwin", "shadow", url, "--model", "if1", "--port", "tcp://127.0.0.1:0")
    good = True
    try:
        time.sleep(3)
        for connection in (bare_line, shadow_line):
            connection.sendall(b"(")
            connection.recv(64)
        for state, number in (("works", None), ("hangs", signal.SIGSTOP), ("has failed", signal.SIGKILL)):
            if number is not None:
                os.kill(twin_of(shadow.pid), number)
            times: dict[str, list[float]] = {"bare": [], "shadow": []}
            for _ in range(given.rounds):
                times["bare"] += round_trips(bare_line, given.round_trips // given.rounds)
                times["shadow"] += round_trips(shadow_line, given.round_trips // given.rounds)
            p99 = {name: quantiles(found, n=100)[98] for name, found in times.items()}
            added = p99["shadow"] - p99["bare"]
            good &= added <= GOAL_MS
            print(
                f"the twin {state}: median {median(times['shadow']):.2f} ms (bare {median(times['bare']):.2f}), "
                f"p99 {p99['shadow']:.2f} ms (bare {p99['bare']:.2f}): ratio {p99['shadow'] / p99['bare']:.2f}, "
                f"added {added:+.2f} ms (goal {GOAL_MS:g})",
                flush=True,
            )
    finally:
        for program in (bare, shadow):
            program.kill()
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
