"""The example motor of lewis in four frameworks: lines of the device, round trips over TCP, and how long a move takes.

    python -m venv others && others/bin/pip install lewis sinstruments tickit
    python benchmarks/device_frameworks.py --python others/bin/python

The devices are in `frameworks`, that of lewis in its package.  A framework that the Python does not have is skipped.
One client asks the servers one after the other, in several rounds: `P?` for a second, then `P?` until a move of 0.4 mm
at 2 mm/s is over, which takes 0.2 s (here, with ramps of 0.2 s, 0.4 s).  The table has the median rates, the
second by processor time of client and server, for a computer with other work, and the shortest and the longest move;
lewis with its usual and its shortest cycle, axistwin in real time and without pauses.
"""

import argparse
import ast
import contextlib
import io
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import NamedTuple

HERE = Path(__file__).parent / "frameworks"
MOVE_MM, PATIENCE_S = 0.4, 20.0
WHERE_LEWIS = "import lewis.examples.example_motor as it; print(it.__file__)"


class Framework(NamedTuple):
    """A framework and how its server begins: words after `python`, with {port} and {directory}."""

    name: str
    module: str  # "" for axistwin.
    start: tuple[str, ...]
    config: str = ""  # Text of the file `config.yml` in {directory}.


FRAMEWORKS = (
    *(
        Framework(
            f"axistwin, speed {speed}", "",
            ("-m", "axistwin", "--device", "motor_axistwin.py", "serve", "motor", "--tcp", "127.0.0.1:{port}",
             "--line", "instant", "--speed", speed),  # in the others, too, characters take no time
        )
        for speed in ("1", "max")
    ),
    Framework(
        "sinstruments", "sinstruments", ("-m", "sinstruments", "-c", "{directory}/config.yml"),
        "devices: [{{class: Motor, package: motor_sinstruments, name: motor, "
        'transports: [{{type: tcp, url: "127.0.0.1:{port}"}}]}}]',
    ),
    Framework(
        "tickit", "tickit", ("-m", "tickit", "--log-level", "WARNING", "all", "{directory}/config.yml"),
        "[{{type: motor_tickit.Motor, name: motor, inputs: {{}}, port: {port}}}]",
    ),
    *(
        Framework(
            f"lewis, cycle {cycle} s", "lewis",
            ("-m", "lewis", "-k", "lewis.examples", "example_motor", "-o", "none", "-c", cycle,
             "-p", "stream: {{bind_address: 127.0.0.1, port: {port}}}"),
        )
        for cycle in ("0.1", "0")
    ),
)  # fmt: skip


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--python", default=sys.executable, help="Python with lewis, sinstruments and tickit")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=1.0, help="of round trips, in each round")
    given = parser.parse_args()
    with contextlib.ExitStack() as stack:
        found = [(one, client_of(stack, one, given.python)) for one in FRAMEWORKS if is_there(one, given.python)]
        rounds = [
            [(*round_trips(client, given.seconds), move_s(client)) for _, client in found] for _ in range(given.rounds)
        ]
    print(f"{'framework':20} {'lines':>5} {'round trips/s':>13} {'of processor':>13} {'a move, s':>16}")
    for (one, _), *figures in zip(found, *rounds, strict=True):
        rates, by_processor, moves = zip(*figures, strict=True)
        rate, other, lines = median(rates), median(by_processor), lines_of(one, given.python)
        print(f"{one.name:20} {lines:5} {rate:13,.0f} {other:13,.0f} {min(moves):8.3f} … {max(moves):.3f}")


def is_there(one: Framework, python: str) -> bool:
    """Return True if a Python has the framework; say how to install it otherwise."""
    missing = one.module and subprocess.run([python, "-c", f"import {one.module}"], capture_output=True).returncode
    if missing:
        print(f"{one.name} is skipped; to install it: {python} -m pip install {one.module}")
    return not missing


def lines_of(one: Framework, python: str) -> int:
    """Return the lines of code of the device, without blank ones, comments and docstrings."""
    if one.module == "lewis":
        found = subprocess.run([python, "-c", WHERE_LEWIS], capture_output=True, text=True, check=True)
        file = Path(found.stdout.strip())
    else:
        file = HERE / f"motor_{one.module or 'axistwin'}.py"
    text = file.read_text(encoding="utf-8").partition("\nsetups = ")[0]  # lewis' other states to begin from
    said = [
        range(node.lineno, (node.end_lineno or 0) + 1)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    ]
    return sum(
        bool(line.strip()) and not line.lstrip().startswith("#") and not any(number in span for span in said)
        for number, line in enumerate(text.splitlines(), 1)
    )


class Client(NamedTuple):
    """A connection to a server."""

    connection: socket.socket
    file: io.BufferedReader
    pid: int

    def ask(self, text: bytes) -> bytes:
        """Return the answer to a line."""
        self.connection.sendall(text + b"\r\n")
        return self.file.readline().strip()


def client_of(stack: contextlib.ExitStack, one: Framework, python: str) -> Client:
    """Start a server in a process of its own, and connect to it."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    directory = stack.enter_context(tempfile.TemporaryDirectory())
    Path(directory, "config.yml").write_text(one.config.format(port=port), encoding="utf-8")
    words = [word.format(port=port, directory=directory) for word in one.start]
    process = subprocess.Popen(
        [python if one.module else sys.executable, *words],
        cwd=HERE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    stack.enter_context(process)
    stack.callback(process.terminate)
    until = time.monotonic() + PATIENCE_S
    while True:
        try:
            connection = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
            break
        except OSError:
            if process.poll() is not None or time.monotonic() > until:
                raise SystemExit(f"the server of {one.name} does not listen: try {' '.join(words)}") from None
            time.sleep(0.05)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    client = Client(stack.enter_context(connection), connection.makefile("rb"), process.pid)
    client.ask(b"P?")
    return client


def round_trips(client: Client, seconds: float) -> tuple[float, float]:
    """Return the round trips of `P?` per second, and per second of processor time of client and server (Linux)."""
    began, before, count = time.perf_counter(), processor_s(client.pid), 0
    while (took := time.perf_counter() - began) < seconds:
        client.ask(b"P?")
        count += 1
    return count / took, count / ((processor_s(client.pid) - before) or took)


def processor_s(pid: int) -> float:
    """Return the processor time of this process and another."""
    return time.process_time() + (time.clock_gettime(~pid << 3 | 2) if sys.platform == "linux" else 0.0)


def move_s(client: Client) -> float:
    """Return the seconds from the request for a move to the first answer that it is over."""
    target = 0.0 if float(client.ask(b"P?")) else MOVE_MM
    began = time.perf_counter()
    answer = client.ask(b"T=%r" % target)
    while float(client.ask(b"P?")) != target:
        if time.perf_counter() > began + PATIENCE_S:
            raise SystemExit(f"a move to {target} mm does not end: {answer.decode()}")
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
