"""Raw TCP: what the client sends goes to the controller, what the controller sends goes to the client, nothing else.

The transport carries neither line format nor control lines: the format is the one given with `--line`, DTR and RTS
are on.  A character with a parity or framing error is passed on as it was received.

A client that stops reading loses what it cannot take: some 64 KiB wait for it, and the newest characters after that
are dropped, as in a host whose receive buffer overruns.  A client that floods is not read from while its characters
wait for the wire.
"""

import asyncio
import select
import socket
from abc import ABC, abstractmethod
from collections.abc import Callable
from logging import getLogger
from typing import Any, cast

from axistwin.errors import LinkError
from axistwin.links.one import OneClient
from axistwin.links.plug import CHUNK, Plug
from axistwin.links.urls import PortUrl
from axistwin.sim.frames import LineError
from axistwin.sim.serial_port import Flow

log = getLogger("axistwin.links")

RECEIVE_BUFFER = 16 * 1024
"""What the system keeps for a client that is not read from; a flooding client soon has to wait, as on a real line."""
STALLED = 64 * 1024
"""What is kept for a client that does not read."""
LAST_WORDS_S = 1.0
"""So long a client that has ended its side still gets answers, as in `printf '(' | nc -N 127.0.0.1 5001`."""
SILENT_S = 60
"""After so long without a word the system asks whether the client's machine is still there."""
HUNG_UP = getattr(select, "POLLRDHUP", 0) | select.POLLHUP | select.POLLERR


class Connection(asyncio.BufferedProtocol, ABC):
    """A client on a TCP connection; the connection and its limits are the same whatever is spoken on it."""

    last_words_s = LAST_WORDS_S

    def __init__(self, plug: OneClient[Any]) -> None:
        self.plug, self.name = plug, ""
        self.stalled = False
        self._buffer = bytearray(CHUNK)
        self._view = memoryview(self._buffer)
        self._transport: asyncio.Transport
        self._socket: socket.socket
        self._leaving = False

    # What asyncio calls

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """A client has come."""
        self._transport = cast("asyncio.Transport", transport)
        self._transport.set_write_buffer_limits(high=STALLED)
        self.name = _address(self._transport.get_extra_info("peername"))
        self._socket = self._transport.get_extra_info("socket")
        _keep_alive(self._socket)
        _acknowledge(self._socket)
        if not self.plug.connect(self):
            self._transport.close()

    def get_buffer(self, sizehint: int) -> memoryview:  # noqa: ARG002
        """Where its characters are to be put."""
        return self._view[: self.plug.chunk]

    def buffer_updated(self, nbytes: int) -> None:
        """Characters have come."""
        _acknowledge(self._socket)
        if self.plug.client is self:
            self.received(bytes(self._view[:nbytes]))

    def eof_received(self) -> bool:
        """The client has nothing more to say."""
        self._leaving = True
        if self.last_words_s:
            asyncio.get_running_loop().call_later(self.last_words_s, self._transport.close)
        return bool(self.last_words_s)  # False: asyncio closes the connection

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002
        """The client has gone."""
        self.plug.disconnect(self)

    # What the plug calls

    def hung_up(self) -> bool:
        """Whether it has gone, or floods the line so that nobody could tell."""
        if self._leaving or self.plug.full or self._transport.is_closing():
            return True
        poll = select.poll()
        poll.register(self._transport.get_extra_info("socket"), HUNG_UP)
        return bool(poll.poll(0))

    def drop(self) -> None:
        """Disconnect it."""
        self._transport.abort()

    def pause(self) -> None:
        """Take nothing from it for the moment."""
        self._transport.pause_reading()

    def resume(self) -> None:
        """Go on taking what it sends."""
        self._transport.resume_reading()

    # What transports differ in

    @abstractmethod
    def received(self, data: bytes) -> None:
        """Bytes from the client."""


class TcpClient(Connection):
    """A host on a TCP connection to a serial plug."""

    flow: Flow | None = None

    def __init__(self, plug: Plug) -> None:
        super().__init__(plug)
        self.plug: Plug = plug
        self.dropped = 0

    def pause_writing(self) -> None:
        """The client does not read what it is sent."""
        self.stalled = True

    def resume_writing(self) -> None:
        """The client reads again."""
        self.stalled = False
        if self.dropped:
            log.warning("%s: %s did not read, %d characters were lost", self.plug.name, self.name, self.dropped)
            self.dropped = 0

    def deliver(self, data: bytes, errors: LineError) -> None:  # noqa: ARG002
        """Send characters to the client."""
        self.write(data)

    def received(self, data: bytes) -> None:
        """Bytes from the client."""
        self.plug.send(data)

    def write(self, data: bytes) -> None:
        """Bytes to the client, if it takes them."""
        if self.stalled:
            self.dropped += len(data)
        elif not self._transport.is_closing():
            self._transport.write(data)


class TcpPort:
    """A listening socket."""

    def __init__(self, url: PortUrl, server: asyncio.Server) -> None:
        self.url, self._server = url, server

    def close(self) -> None:
        """Listen no more."""
        self._server.close()


async def listen(url: PortUrl, make: Callable[[], Connection]) -> TcpPort:
    """Wait for clients at the address in `url`; port 0: any free one, told in the result.  Raises LinkError."""
    loop = asyncio.get_running_loop()
    try:
        infos = await loop.getaddrinfo(url.host, url.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = infos[0]
        sock = _listening_socket(family, address)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise LinkError(f"cannot listen on {url}: {reason}: choose another address, or port 0 for any free") from None
    server = await loop.create_server(make, sock=sock)
    return TcpPort(url.at(*sock.getsockname()[:2]), server)


def _listening_socket(family: int, address: tuple[object, ...]) -> socket.socket:
    sock = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)  # without the protocol asyncio leaves Nagle on
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)  # before listening: clients inherit it
        sock.bind(address)
    except OSError:
        sock.close()
        raise
    sock.setblocking(False)
    return sock


def _keep_alive(sock: socket.socket) -> None:
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    if hasattr(socket, "TCP_KEEPIDLE"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, SILENT_S)


def _acknowledge(sock: socket.socket) -> None:
    """Acknowledge what comes next at once: a client that writes twice would have to wait for it (Nagle), 40 ms.

    The system forgets that when it has done so.
    """
    if hasattr(socket, "TCP_QUICKACK"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)


def _address(peer: tuple[object, ...] | None) -> str:
    return "a client that has gone" if peer is None else f"{peer[0]}:{peer[1]}"
