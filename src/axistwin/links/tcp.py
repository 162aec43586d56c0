"""Raw TCP: characters between client and controller, without line format and control lines.

The line format is that of `--line`; DTR and RTS are on.  A character with a parity or framing error is sent as it was
received.

Up to 64 KiB are buffered for a client that does not read.  Then the newest characters are lost, as in a host whose
receive buffer overruns.  Nothing is read from a client while too many of its characters wait for the wire.
"""

import asyncio
import select
import socket
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from logging import getLogger
from typing import Any, Protocol, cast

from axistwin.core.errors import LinkError, reason
from axistwin.links.plug import CHUNK
from axistwin.links.urls import PortUrl
from axistwin.sim.frames import LineError
from axistwin.sim.serial_port import Flow

log = getLogger("axistwin.links")

RECEIVE_BUFFER = 16 * 1024  # The system's receive buffer: a client that sends too fast is blocked, as on a real line.
STALLED = 64 * 1024  # Largest number of bytes that are buffered for a client that does not read.
WEB_REQUESTS = tuple(method + b" /" for method in (b"GET", b"POST", b"HEAD", b"PUT", b"PATCH", b"DELETE", b"OPTIONS"))
"""First characters of an HTTP request, which any web page can make a browser send; no host begins with them."""
NUL_LINE = b"\r\0"  # End of a line that a telnet client sends.
LINGER_S = 1.0  # Seconds for which answers are still sent to a client that has closed its side, such as `nc -N`.
IDLE_S = 60  # Seconds of silence after which the system checks the connection (TCP keep-alive).


class Connector(Protocol):
    """Software interface through which a TCP client connects to a controller."""

    client: Any

    @property
    def name(self) -> str: ...

    @property
    def full(self) -> bool: ...

    @property
    def chunk(self) -> int: ...

    def connect(self, client: Any) -> bool:
        """Connect a client; return False if the client is refused."""

    def disconnect(self, client: Any) -> None: ...


class SerialConnector(Connector, Protocol):
    """Software interface through which a TCP client sends characters to a controller."""

    def send(self, data: bytes) -> None: ...


class Connection(asyncio.BufferedProtocol, ABC):
    """Base class for the TCP connection of a client.  The derived classes add a protocol, e.g. raw TCP."""

    linger_s = LINGER_S
    answers = False  # True if requests are answered: nothing is read while the client does not read the answers.

    def __init__(self, plug: Connector) -> None:
        self.plug, self.name, self.stalled = plug, "", False
        self._buffer = bytearray(CHUNK)
        self._view = memoryview(self._buffer)
        self._transport: asyncio.Transport
        self._socket: socket.socket
        self._leaving = self._has_sent = False
        self._begun: bytes | None = b""  # First characters from the client, while they can be those of an HTTP request.

    # Functions that asyncio calls

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.Transport", transport)
        self._transport.set_write_buffer_limits(high=STALLED)
        peer = self._transport.get_extra_info("peername")
        self.name = "a closed client" if peer is None else f"{peer[0]}:{peer[1]}"
        self._socket = self._transport.get_extra_info("socket")
        _keep_alive(self._socket)
        _acknowledge(self._socket)
        if not self.plug.connect(self):
            self._transport.close()

    def get_buffer(self, sizehint: int) -> memoryview:  # noqa: ARG002
        return self._view[: self.plug.chunk]

    def buffer_updated(self, nbytes: int) -> None:
        self._has_sent = False
        data = bytes(self._view[:nbytes])
        if self._begun is not None and self._is_web_request(data):
            log.warning("%s: closed %s, which sent an HTTP request, as a web page does", self.plug.name, self.name)
            self.drop()
            return
        if self.plug.client is self:
            self.received(data)
        if not self._has_sent:
            # No reply has acknowledged the received data, so send a separate TCP acknowledgement at once.
            _acknowledge(self._socket)

    def _is_web_request(self, data: bytes) -> bool:
        self._begun = ((self._begun or b"") + data)[: len(max(WEB_REQUESTS, key=len))]
        if self._begun.startswith(WEB_REQUESTS):
            return True
        if not any(request.startswith(self._begun) for request in WEB_REQUESTS):
            self._begun = None
        return False

    def eof_received(self) -> bool:
        """Keep the connection for late answers after the client has closed its side."""
        self._leaving = True
        if self.linger_s:
            asyncio.get_running_loop().call_later(self.linger_s, self._transport.close)
        return bool(self.linger_s)  # asyncio closes the connection if `eof_received` returns False.

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002
        self.plug.disconnect(self)

    def pause_writing(self) -> None:
        self.stalled = True
        if self.answers:
            self.pause()

    def resume_writing(self) -> None:
        self.stalled = False
        if self.answers and not self.plug.full:
            self.resume()

    # Methods that report or change the state of the client's connection

    def hung_up(self) -> bool:
        """True if the client has disconnected, or may have, unnoticed because it is not being read from."""
        if self._leaving or self.plug.full or self._transport.is_closing():
            return True
        return _hung_up(self._socket)

    def drop(self) -> None:
        self._transport.abort()

    def pause(self) -> None:
        self._transport.pause_reading()

    def resume(self) -> None:
        """Continue reading from the client.  Reading stays paused while the client does not read the replies."""
        if not (self.answers and self.stalled):
            self._transport.resume_reading()

    def transmit(self, data: bytes) -> None:
        self._has_sent = True
        self._transport.write(data)

    @abstractmethod
    def received(self, data: bytes) -> None: ...


class TcpClient(Connection):
    """A host that is connected to a serial endpoint over raw TCP."""

    flow: Flow | None = None

    def __init__(self, plug: SerialConnector) -> None:
        super().__init__(plug)
        self.plug: SerialConnector = plug
        self.dropped, self._last, self._has_told = 0, b"", False

    def resume_writing(self) -> None:
        if self.dropped:
            log.warning("%s: %s reads too slowly, %d characters were lost", self.plug.name, self.name, self.dropped)
            self.dropped = 0
        super().resume_writing()

    def deliver(self, data: bytes, errors: LineError) -> None:  # noqa: ARG002
        self.write(data)

    def received(self, data: bytes) -> None:
        came = self._last + data
        if not self._has_told and NUL_LINE in came and b"\0" not in came.replace(NUL_LINE, b""):  # Datagrams have more.
            self._tell_nul()
        self._last = data[-1:]
        self.plug.send(data)

    def _tell_nul(self) -> None:
        self._has_told = True
        host, port, *_ = self._socket.getsockname()
        log.warning(
            "%s: %s sends NUL after CR, as a telnet client does, and the controller receives both: "
            "use axistwin term socket://%s:%d", self.plug.name, self.name, host, port,
        )  # fmt: skip

    def write(self, data: bytes) -> None:
        """Send bytes to the client; discard the bytes if the client does not read."""
        if self.stalled:
            self.dropped += len(data)
        elif not self._transport.is_closing():
            self.transmit(data)


class TcpPort:
    """A TCP port that listens for clients."""

    def __init__(self, url: PortUrl, server: asyncio.Server) -> None:
        self.url, self._server = url, server

    def close(self) -> None:
        self._server.close()


async def listen(url: PortUrl, make: Callable[[], Connection]) -> TcpPort:
    """Listen at the address of `url`, and return the open port; port 0: any free port.  Raises LinkError."""
    loop = asyncio.get_running_loop()
    try:
        sock = _listening_socket(*await resolved(url))
    except OSError as error:
        raise LinkError(
            f"cannot listen on {url}: {reason(error)}; choose another address, or port 0 for any free port"
        ) from None
    server = await loop.create_server(make, sock=sock)
    host, port, *_ = sock.getsockname()
    return TcpPort(replace(url, host=host, port=port), server)


async def connected(make: Callable[[], Connection]) -> socket.socket:
    """Connect a client in this process; return its socket.  Nobody else can connect: no port stays open."""
    with _listening_socket(socket.AF_INET, ("127.0.0.1", 0)) as listening:
        listening.listen()
        client = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        client.connect(listening.getsockname())
        served, address = listening.accept()
        while address != client.getsockname():
            served.close()
            served, address = listening.accept()
    await asyncio.get_running_loop().connect_accepted_socket(make, served)
    return client


async def resolved(url: PortUrl) -> tuple[int, tuple[object, ...]]:
    """Return address family and socket address; an IPv4 address is not looked up, which takes a thread."""
    try:
        socket.inet_pton(socket.AF_INET, url.host)
    except OSError:
        loop = asyncio.get_running_loop()
        infos = await loop.getaddrinfo(url.host, url.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = infos[0]
        return family, address
    return socket.AF_INET, (url.host, url.port)


def _listening_socket(family: int, address: tuple[object, ...]) -> socket.socket:
    # The argument IPPROTO_TCP makes asyncio send short messages without delay (TCP_NODELAY).
    sock = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        # On Windows, the option SO_REUSEADDR would let a second server use the same address.
        sock.setsockopt(socket.SOL_SOCKET, getattr(socket, "SO_EXCLUSIVEADDRUSE", socket.SO_REUSEADDR), 1)
        # Set the size of the receive buffer for all TCP connections that this socket accepts.
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        sock.bind(address)
    except OSError:
        sock.close()
        raise
    sock.setblocking(False)
    return sock


def _hung_up(sock: socket.socket) -> bool:
    """True if the other end is closed; False on Windows, without `poll`: there the event loop notices."""
    if not hasattr(select, "poll"):
        return False
    poll = select.poll()
    poll.register(sock, getattr(select, "POLLRDHUP", 0) | select.POLLHUP | select.POLLERR)
    return bool(poll.poll(0))


def _keep_alive(sock: socket.socket) -> None:
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    if hasattr(socket, "TCP_KEEPIDLE"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, IDLE_S)


def _acknowledge(sock: socket.socket) -> None:
    """Make the operating system acknowledge the next TCP packet without delay.

    With Nagle's algorithm, a client that writes twice would otherwise be delayed by 40 ms.  The system clears this
    option after each acknowledgement.
    """
    if hasattr(socket, "TCP_QUICKACK"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
