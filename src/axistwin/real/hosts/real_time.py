"""The host's end of a serial port or of a bus socket, in real time."""

import socket
import time
from collections.abc import Callable

import serial
from serial.urlhandler import protocol_socket

from axistwin.core.errors import LinkError, UsageError, cannot_open
from axistwin.core.units import S
from axistwin.drivers.blocking import open_serial
from axistwin.links.devices import settings_of
from axistwin.links.urls import parse
from axistwin.real.hosts.end import MESSAGE, USER_BITS, End
from axistwin.sim.frames import UartFormat

COMMAND_READY, MESSAGE_TAKEN = 0x10, 0x80
MESSAGE_READY, INPUT_READY, FAILED = 0x08, 0x10, 0x20
NOBODY = 0xFF


class SerialEnd(End):
    """Host side of a connection through a serial port or a terminal server."""

    def __init__(self, name: str, line: UartFormat) -> None:
        super().__init__()
        self._name, self.frame_s = name, line.frame_ns / S
        self.port = open_port(name, line, timeout_s=0.01)
        self.has_line = not isinstance(self.port, protocol_socket.Serial)

    @property
    def now(self) -> float:
        return time.monotonic()

    def set_line(self, line: UartFormat) -> None:
        self.frame_s = line.frame_ns / S
        if self.has_line:
            self._call(lambda: self.port.apply_settings(settings_of(line)))

    def send(self, data: bytes) -> None:
        self._call(lambda: self.port.write(data))

    def receive(self, silence_s: float = 0.0) -> bytes:  # noqa: ARG002  # real time passes in steps of some ms
        return self._call(lambda: self.port.read(max(1, self.port.in_waiting))) or b""

    def drain(self) -> bytes:
        return self._call(lambda: self.port.read(self.port.in_waiting)) or b""

    def close(self) -> None:
        self.port.close()

    def _call(self, action: Callable[[], object]) -> bytes | None:
        try:
            done = action()
        except (serial.SerialException, OSError) as error:
            raise LinkError(
                f"the port {self._name} was disconnected ({error}): connect the port, then try again"
            ) from None
        return done if isinstance(done, bytes) else None


class BusEnd(End):
    """The host's end of a bus socket; commands and messages use the handshake of chapter Reading and writing."""

    messages = True
    has_line = False
    _POLL_S = 0.002
    _INPUT_S = 2.0

    def __init__(self, name: str, host: str, port: int) -> None:
        super().__init__()
        self._name = name
        try:
            self._socket = socket.create_connection((host, port), timeout=5)
        except OSError as error:
            raise LinkError(cannot_open(name, error)) from None
        self._lines = self._socket.makefile("rw", encoding="ascii", newline="\n")

    @property
    def now(self) -> float:
        return time.monotonic()

    def send(self, data: bytes) -> None:
        """Wait until the board accepts commands (SB bit 4), then send one command."""
        until = self.now + self._INPUT_S
        while not self._status() & INPUT_READY:
            if self.now > until:
                raise LinkError(
                    f"the board at {self._name} accepts no command (bit 4 of its status byte stays 0): reset the board"
                )
            time.sleep(self._POLL_S)
        self._request("w 0 " + data.hex(" "))
        self._request(f"w 1 {COMMAND_READY:02x}")

    def receive(self, silence_s: float = 0.0) -> bytes:  # noqa: ARG002  # real time passes in steps of some ms
        if not self._status() & MESSAGE_READY:
            time.sleep(self._POLL_S)
            return b""
        message = bytes.fromhex(self._request(f"r 0 {MESSAGE}"))
        self._request(f"w 1 {MESSAGE_TAKEN:02x}")
        return message

    def drain(self) -> bytes:
        found = b""
        while more := self.receive():
            found += more
        return found

    @property
    def user_bits(self) -> int:
        return self._status() & USER_BITS

    def close(self) -> None:
        self._lines.close()
        self._socket.close()

    def _status(self) -> int:
        status = int(self._request("r 1"), 16)
        if status == NOBODY:
            raise LinkError(f"no board answers on the bus {self._name}: switch the board on, and check its address")
        return status

    def _request(self, request: str) -> str:
        try:
            self._lines.write(request + "\n")
            self._lines.flush()
            answer = self._lines.readline().strip()
        except OSError as error:
            raise LinkError(
                f"the bus socket {self._name} was disconnected ({error}): "
                "check that the program with the bus socket is running, then try again"
            ) from None
        if not answer or answer.startswith("error"):
            received = repr(answer) if answer else "no answer"
            raise LinkError(
                f"the bus socket {self._name} has not executed the request {request!r}: received {received}"
            )
        return answer


def open_end(target: str, line: UartFormat | None) -> End:
    """Open a connection to a controller through a serial device, a network port or a bus socket.

    `target`: a device, `tcp://`, `rfc2217://`, `bus://` or a URL of pyserial.  `line`: baud rate and frame; None: a
    board on a bus.  Raises LinkError, UsageError.
    """
    if target.startswith("bus://"):
        if line is not None:
            raise UsageError(
                f"{target} is a register bus, not a serial port: expected a device, e.g. /dev/ttyUSB0, "
                "or a serial server, e.g. tcp://127.0.0.1:5001"
            )
        url = parse(target)
        return BusEnd(target, url.host, url.port)
    if line is None:
        raise UsageError(
            f"{target} is not a bus socket: expected a bus socket for this board, e.g. bus://127.0.0.1:1811"
        )
    return SerialEnd(target, line)


def open_port(target: str, line: UartFormat, timeout_s: float) -> serial.Serial:
    """Open a device, a URL of pyserial, or a port that `axistwin serve` prints.  Raises LinkError, UsageError."""
    if target.startswith(("pty:", "serial:")):
        target = parse(target).path
    elif target.startswith("tcp:"):
        target = str(parse(target))
    return open_serial(target, timeout=timeout_s, **settings_of(line))
