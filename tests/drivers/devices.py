"""Ports for the tests: controllers in virtual time, and ports that give answers no controller gives."""

import socket
import threading
from contextlib import contextmanager, suppress

from axistwin import Bench
from axistwin.real.integrations import InnerPort


class Ports(Bench):
    """A bench whose controllers are at ports in virtual time; the port of a controller has its name.

    `whole`: answers arrive in one piece; otherwise byte by byte.
    """

    def __init__(self, *, whole):
        super().__init__()
        self.whole, self.access_s = whole, 5e-4
        """Virtual time that a driver needs to send a request."""
        self._answers = None

    def open(self, name, core, baud):
        return Port(self, Answers(self, self._answers) if self._answers else InnerPort(self, name))

    def answering(self, answer):
        """Return a port at which `answer(data)` gives the answer to what a driver has sent."""
        self._answers = answer
        return "answers"

    def sleep(self, seconds):
        self.run(seconds)

    def monotonic(self):
        return self.seconds


class Port:
    def __init__(self, ports, port):
        self._ports, self._port, self._received = ports, port, b""

    def write(self, data):
        done(self._port.write(data))
        done(self._port.pause(self._ports.access_s))

    def read(self, timeout):
        self._received = self._received or done(self._port.read(timeout))
        size = len(self._received) if self._ports.whole else 1
        data, self._received = self._received[:size], self._received[size:]
        return data

    def close(self):
        done(self._port.close())


class Answers:
    def __init__(self, bench, answer):
        self._bench, self._answer, self._received = bench, answer, b""

    async def write(self, data):
        self._received += self._answer(data)

    async def read(self, timeout):
        data, self._received = self._received, b""
        if not data:
            self._bench.run(timeout)
        return data

    async def pause(self, seconds):
        self._bench.run(seconds)

    async def close(self):
        self._received = b""


def done(coroutine):
    """Return the result of a coroutine that waits for nothing but virtual time."""
    try:
        while True:
            coroutine.send(None)
    except StopIteration as end:
        return end.value


@contextmanager
def answering(answer):
    """Serve one TCP port; `answer(data)` returns the bytes to send, or None to disconnect."""
    listener = socket.create_server(("127.0.0.1", 0))
    ended = threading.Event()

    def serve():
        while not ended.is_set():
            try:
                client, _ = listener.accept()
            except OSError:
                return
            with client, suppress(OSError):  # the driver may disconnect first
                while data := client.recv(4096):
                    if (reply := answer(data)) is None:
                        break
                    client.sendall(reply)

    threading.Thread(target=serve, daemon=True).start()
    try:
        yield f"socket://127.0.0.1:{listener.getsockname()[1]}"
    finally:
        ended.set()
        listener.close()


def model_of(twin, name=None):
    return twin.bench[name] if name else next(iter(twin.bench.controllers.values()))


def url_of(twin):
    return next(iter(twin.ports.values()))
