"""From the start of the process to the first answer, as a ratio to a bare echo server.

`axistwin serve if1 --speed max --line instant` and the echo server (an asyncio `Protocol`) both receive `(`; a
SmartMotor receives `RP`.  All have compiled modules, like an installed program.  The SmartMotor is also measured as if
its compiled kernel were loaded first, as an independent reference.  The second ratio is by the processor time of the
server's main thread, for a computer with other work; it needs Linux.
"""

import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

RUNS = 10
GOAL = 3.0

ECHO = """
import asyncio

class Echo(asyncio.Protocol):
    def connection_made(self, transport):
        self.transport = transport

    def data_received(self, data):
        self.transport.write(data)

async def main():
    server = await asyncio.get_running_loop().create_server(Echo, "127.0.0.1", 0)
    print("echo listening on tcp://127.0.0.1:%d" % server.sockets[0].getsockname()[1], flush=True)
    await server.serve_forever()

asyncio.run(main())
"""
SERVE = "import sys; from axistwin.cli.program import main; main(sys.argv[1:])"
KERNEL_FIRST = "from axistwin.bench import product; product('smartmotor').prepare(None, 1); "
AT_ONCE = ["--speed", "max", "--line", "instant"]
IF1 = [sys.executable, "-c", SERVE, "serve", "if1", *AT_ONCE]
SMARTMOTOR = [sys.executable, "-c", SERVE, "serve", "smartmotor", *AT_ONCE]
BEFORE = [sys.executable, "-c", KERNEL_FIRST + SERVE, "serve", "smartmotor", *AT_ONCE]
ECHO_COMMAND = [sys.executable, "-c", ECHO]
SERVERS = {"echo": (ECHO_COMMAND, b"("), "if1": (IF1, b"("), "smartmotor": (SMARTMOTOR, b"RP\r"),
           "kernel first": (BEFORE, b"RP\r")}  # fmt: skip


def main() -> None:
    """Print the ratios."""
    with tempfile.TemporaryDirectory() as compiled:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        for server in SERVERS.values():
            seconds_to_answer(*server, environment)
        runs = [{name: seconds_to_answer(*server, environment) for name, server in SERVERS.items()}
                for _ in range(RUNS)]  # fmt: skip
    wall, processor = ({name: min(run[name][k] for run in runs) for name in SERVERS} for k in range(2))
    for name in ("if1", "smartmotor"):
        print(f"{name}, process start to first answer: ratio {wall[name] / wall['echo']:.2f} (goal <= {GOAL:g})")
        print(f"  by processor time: ratio {processor[name] / processor['echo']:.2f}")
    print(f"  with the compiled kernel loaded first: ratio {wall['kernel first'] / wall['echo']:.2f}")


def seconds_to_answer(command: list[str], asked: bytes, environment: dict[str, str]) -> tuple[float, float]:
    """Start a server, read its address, ask, and wait for the first answer.

    Return the time of the wall clock, and the processor time of the server's main thread.
    """
    began = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        port = int(process.stdout.readline().rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port)) as connection:
            connection.sendall(asked)
            connection.recv(16)
            took = time.perf_counter() - began
            worked = Path(f"/proc/{process.pid}/task/{process.pid}/schedstat").read_text().split()[0]
        process.terminate()
    return took, int(worked) / 1e9


if __name__ == "__main__":
    main()
