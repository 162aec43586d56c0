"""Ports for the tests: served controllers, and TCP servers that give answers no controller gives."""

import socket
import threading
from contextlib import contextmanager, suppress


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

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield f"socket://127.0.0.1:{listener.getsockname()[1]}"
    finally:
        ended.set()
        listener.close()


def model_of(twin, name=None):
    """Return the first controller of a twin, or the one with this name."""
    return twin.bench[name] if name else next(iter(twin.bench.controllers.values()))


def url_of(twin):
    """Return the first port of a twin."""
    return next(iter(twin.ports.values()))
