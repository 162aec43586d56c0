"""From the start of the process to the first answer, as a ratio to a bare echo server.

`axistwin serve if1 --speed max --line instant` and the echo server (an asyncio `Protocol`) both receive `(`.
Both have compiled modules, like an installed program.
"""

import os
import socket
import subprocess
import sys
import tempfile
import time

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
SERVE = "import sys; from axistwin.cli.main import main; main(sys.argv[1:])"
TWIN_COMMAND = [sys.executable, "-c", SERVE, "serve", "if1", "--speed", "max", "--line", "instant"]
ECHO_COMMAND = [sys.executable, "-c", ECHO]


def main() -> None:
    """Print the ratio."""
    with tempfile.TemporaryDirectory() as compiled:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        seconds_to_answer(TWIN_COMMAND, environment)
        seconds_to_answer(ECHO_COMMAND, environment)
        times = [(seconds_to_answer(TWIN_COMMAND, environment), seconds_to_answer(ECHO_COMMAND, environment))
                 for _ in range(RUNS)]  # fmt: skip
    ratio = min(twin for twin, _ in times) / min(echo for _, echo in times)
    print(f"process start to first answer: ratio {ratio:.2f} (goal <= {GOAL:g})")


def seconds_to_answer(command: list[str], environment: dict[str, str]) -> float:
    """Start a server, read its address, ask, and wait for the first answer."""
    began = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        port = int(process.stdout.readline().rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port)) as connection:
            connection.sendall(b"(")
            connection.recv(16)
            took = time.perf_counter() - began
        process.terminate()
    return took


if __name__ == "__main__":
    main()
