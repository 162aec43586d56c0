"""Bad clients of `axistwin ioc` by Channel Access, while good ones read, subscribe and write.

    python benchmarks/robustness/channel_access.py [--seed 1] [--clients 1500]

A bad client creates three channels, and sends up to 24 messages of known commands with random numbers, types, counts
and texts; some do not read, some stay.  After each hundred, a good client must get an update, and the answer to its
write.  At the end the command must end with 0, and its log must have some lines, but no traceback.  Prints the errors
and a verdict; the exit code is 1 if there are errors.
"""

import argparse
import json
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

SCENE = '[[controller]]\nmodel = "if1"\n[[controller]]\nmodel = "1811"\n[[controller]]\nmodel = "smartmotor"\n'
NAMES = (
    b"P:if1:X", b"P:if1:X.EGU", b"P:if1:X:FAULT", b"P:if1:X.DESC$", b"P:if1:X.SPMG", b"P:if1:output1", b"P:if1:X.STOP",
    b"P:1811:motor", b"P:1811:motor.JOGF", b"P:smartmotor:shaft.VELO", b'P:if1:X.{"dbnd":{"abs":1.5}}',
    b'P:if1:X.{"ts":{}}', b'P:if1:X.{"arr":{"s":0,"i":1,"e":-1}}', b'P:if1:X.{"sync":{"m":"while","s":"a"}}',
)  # fmt: skip
VERSION, SUBSCRIBE, CANCEL, WRITE, CREATE, WRITE_NOTIFY = 0, 1, 2, 4, 18, 19
COMMANDS = (0, 1, 1, 1, 2, 3, 4, 4, 8, 9, 10, 12, 15, 15, 15, 17, 18, 19, 19, 20, 21, 23)
TYPES = (*range(7), 6, 14, 20, 24, 28, *range(34, 40), 99)
MOST_LINES = 30


def message(command: int, data: bytes = b"", kind: int = 0, count: int = 0, first: int = 0, second: int = 0) -> bytes:
    """Return a message of Channel Access."""
    return struct.pack(">HHHHII", command, len(data), kind, count, first, second) + data


def text(value: bytes) -> bytes:
    """Return a text with its end, filled to a multiple of 8 bytes."""
    return value + bytes(8 - len(value) % 8)


def subscription(mask: int) -> bytes:
    """Return the data of a subscription."""
    return struct.pack(">fffHH", 0, 0, 0, mask, 0)


def noise(rng: random.Random) -> bytes:
    """Return a message with random contents."""
    command, kind, count = rng.choice(COMMANDS), rng.choice(TYPES), rng.choice((0, 1, 1, 1, 2, 5, 400))
    first, second, data = rng.choice((0, 0, 1, 2, 3, 9)), rng.randrange(5), b""
    match command:
        case 1:
            data = subscription(rng.choice((0, 1, 7, 15, 255)))
        case 4 | 19:
            number = struct.pack(">d", rng.choice((0.0, 1.0, 5.0, float("nan"), 1e300)))
            data = rng.choice((number, text(b"Go"), rng.randbytes(rng.choice((8, 16, 40))), b""))
        case 18:
            return message(CREATE, text(rng.choice(NAMES)), first=second, second=13)
        case 20 | 21:
            data = text(rng.choice((b"me", b"\xff\xfe", b"")))
    return message(command, data, kind, count, first, second)


class Good:
    """A client that gets what it asks for, or TimeoutError."""

    def __init__(self, address: tuple[str, int], name: bytes) -> None:
        self.socket = socket.create_connection(address, 20)
        self.socket.sendall(message(VERSION, count=13) + message(CREATE, text(name), first=1, second=13))
        self.sid = struct.unpack(">I", self.until(CREATE)[12:16])[0]

    def until(self, command: int) -> bytes:
        """Return the head of the next message of a kind."""
        while True:
            head = self.read(16)
            self.read(struct.unpack_from(">H", head, 2)[0])
            if head[1] == command:
                return head

    def read(self, count: int) -> bytes:
        """Read that many bytes."""
        data = b""
        while len(data) < count:
            more = self.socket.recv(count - len(data))
            if not more:
                raise ConnectionError("disconnected")
            data += more
        return data


def fault(address: tuple[str, int]) -> str:
    """Return what good clients do not get; "" if they get all."""
    try:
        reader, writer = Good(address, b"P:1811:motor.RBV"), Good(address, b"P:1811:motor.PROC")
        with reader.socket, writer.socket:
            reader.socket.sendall(message(SUBSCRIBE, subscription(7), 6, 1, reader.sid, 5))
            reader.until(SUBSCRIBE)
            writer.socket.sendall(message(WRITE_NOTIFY, struct.pack(">h6x", 1), 1, 1, writer.sid, 5))
            writer.until(WRITE_NOTIFY)
    except OSError as error:
        return str(error)
    return ""


def visit(address: tuple[str, int], rng: random.Random, clients: int) -> list[str]:
    """Let bad clients come; return what was wrong for good ones."""
    held: list[socket.socket] = []
    wrong: list[str] = []
    for number in range(1, clients + 1):
        try:
            client = socket.create_connection(address, 20)
        except OSError as error:
            return [*wrong, f"client {number}: {error}"]
        channels = b"".join(message(CREATE, text(rng.choice(NAMES)), first=cid, second=13) for cid in range(3))
        with suppress(OSError):
            client.sendall(
                message(VERSION, count=13) + channels + b"".join(noise(rng) for _ in range(rng.randrange(25)))
            )
            if number % 3:
                client.settimeout(0.02)
                client.recv(4096)
        held.append(client)
        if len(held) > 30:
            held.pop(rng.randrange(30)).close()
        if number % 100 == 0 or number == clients:
            wrong += [f"after {number} clients: {found}" for found in (fault(address),) if found]
    for client in held:
        client.close()
    return wrong


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--clients", type=int, default=1500)
    given = parser.parse_args(arguments)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    with tempfile.TemporaryDirectory() as folder:
        scene, log = Path(folder, "scene.toml"), Path(folder, "log")
        scene.write_text(SCENE)
        words = ("ioc", str(scene), "--prefix", "P:", "--port", port, "--speed", "max", "--json")
        quiet = {"EPICS_CAS_AUTO_BEACON_ADDR_LIST": "NO", "EPICS_CAS_BEACON_ADDR_LIST": "127.0.0.1"}
        with log.open("wb") as errors, subprocess.Popen(
            [sys.executable, "-m", "axistwin", *words], stdout=subprocess.PIPE, stderr=errors, env=os.environ | quiet
        ) as program:  # fmt: skip
            assert program.stdout is not None
            host, _, number = json.loads(program.stdout.readline())["address"].partition(":")
            wrong = visit((host, int(number)), random.Random(given.seed), given.clients)
            program.send_signal(signal.SIGTERM)
            if code := program.wait(30):
                wrong.append(f"exit code {code}")
        lines = log.read_text().splitlines()
    if len(lines) > MOST_LINES or any(line.startswith(("Traceback", "Task ")) for line in lines):
        wrong += ["log:", *lines]
    print("\n".join(wrong[:40]), end="\n" if wrong else "")
    print(f"{'FAILED' if wrong else 'passed'}: seed {given.seed}: {given.clients} clients, {len(lines)} lines")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
