"""The host's end of a connection to a controller: a serial port, a bus socket, or a twin in virtual time."""

import re
import socket
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, NamedTuple

import serial

from axistwin.bench import Bench, Controller
from axistwin.errors import LinkError, UsageError
from axistwin.links import parse
from axistwin.links.devices import error_text
from axistwin.sim.frames import UartFormat
from axistwin.units import MS, S

QUIET_S = 0.06
"""Time without data after which an answer is complete."""
LONGEST_S = 1.0
"""Longest time in seconds to wait for the expected bytes, in addition to their usual time."""
LATE_S = 2.0
"""Silence after which nothing late is expected any more."""
TRIES = 3
"""Number of times that a request is sent before the controller counts as silent."""
POLL_S = 0.015
"""Longest usual time between two looks at a port."""
MESSAGE = 16
COMMAND_READY, MESSAGE_TAKEN = 0x10, 0x80
MESSAGE_READY, INPUT_READY, FAILED = 0x08, 0x10, 0x20
NOBODY = 0xFF
USER_BITS = 0x07


class Answer(NamedTuple):
    """Received bytes, and the time in seconds from the request to the last byte."""

    data: bytes
    seconds: float


class End(ABC):
    """Host side of a connection to a controller."""

    grain_s = 0.02
    """Uncertainty of a measured time."""
    exact = False
    """True if a loaded computer cannot delay an answer."""
    messages = False
    """True for a board on a bus, which receives commands and sends messages."""
    has_line = True
    """True if the port has a baud rate and a frame."""

    def __init__(self) -> None:
        self.frame_s = 0.0
        """Time of one character on the line."""
        self.echo = False
        """True if the controller sends each character back; an echo is not the answer for which a request waits."""
        self.received = bytearray()
        """All data received since `begin`, including those that came after the end of an answer."""
        self.late_s = 0.0
        """Time by which this program was late with requests since `begin`."""
        self._ended: float | None = None

    def begin(self) -> None:
        """Discard received data, and begin to collect those of the next requests."""
        self.drain()
        self.received.clear()
        self.late_s, self._ended = 0.0, None

    def ask(self, data: bytes, expected: int = 0, wait_s: float = 0.0, patience_s: float = 0.0) -> Answer:
        """Send a request to the controller, and return the answer.

        The answer is complete after `expected` bytes and a silence.  If bytes are missing, the answer ends after
        `LONGEST_S`, or `patience_s` later for a controller that holds back answers.  A request without an answer
        takes `wait_s` seconds.  No `data`: the answer is the user bits of a board's status byte.
        """
        if not data:
            return Answer(bytes((self.user_bits,)), 0.0)
        self.received += self.drain()
        began = last = self.now
        self.send(data)
        self._was_late(self.now - (began if self._ended is None else self._ended))
        received = bytearray()
        sending_s = len(data) * self.frame_s
        quiet_s, wait_s = max(QUIET_S, 3 * self.frame_s), wait_s + sending_s
        echoed = len(data) if self.echo else 0
        while True:
            since = self.now - began
            silence_s = quiet_s - (self.now - last)
            if len(received) <= echoed:
                silence_s = max(silence_s, wait_s - since)
            missing_s = wait_s + sending_s + LONGEST_S + patience_s - since
            complete = len(received) >= expected or missing_s < 0
            if complete and silence_s <= 0:
                self._ended = self.now
                self._was_late(-silence_s)
                return Answer(bytes(received), last - began)
            if more := self.receive(silence_s if complete else max(silence_s, missing_s)):
                received += more
                self.received += more
                last = self.now

    def _was_late(self, seconds: float) -> None:
        if seconds > POLL_S:
            self.late_s += seconds

    def ask_again(self, data: bytes, form: bytes) -> bytes:
        """Send a request until its answer fits a regular expression, at most three times; return the last answer.

        The answer may begin with an echo of the request.
        """
        whole = re.compile(b"(?:.{%d})?%s" % (len(data), form), re.DOTALL)
        received = bytearray()
        for _ in range(TRIES):
            self.drain()
            received.clear()
            self.send(data)
            last = self.now
            while self.now - last < LATE_S:
                if more := self.receive():
                    received += more
                    last = self.now
                elif whole.fullmatch(received) and self.now - last > QUIET_S:
                    return bytes(received)
        return bytes(received)

    def settle(self) -> None:
        """Receive until nothing late is expected any more."""
        last = self.now
        while self.now - last < LATE_S:
            if more := self.receive():
                self.received += more
                last = self.now

    @property
    @abstractmethod
    def now(self) -> float:
        """Time of this end in seconds."""

    @abstractmethod
    def send(self, data: bytes) -> None:
        """Send characters to a serial controller, or one command to a board on a bus."""

    @abstractmethod
    def receive(self, silence_s: float = 0.0) -> bytes:
        """Return the received data, or no bytes if no data arrive within some milliseconds.

        `silence_s`: time without data that the caller waits for in any case; the function may use it up to 20 ms.
        """

    @abstractmethod
    def drain(self) -> bytes:
        """Return received data that belong to an earlier request."""

    def set_line(self, line: UartFormat) -> None:  # noqa: B027  # a bus has no line format
        """Change baud rate and frame, if the port has any."""

    @property
    def user_bits(self) -> int:
        """The user bits of a board's status byte."""
        return 0

    @abstractmethod
    def close(self) -> None:
        """Close the connection to the controller."""


class VirtualEnd(End):
    """Sends data to a virtual controller, and receives the controller's answers.  All times are in virtual time."""

    grain_s = 0.0005
    exact = True
    _STEP_S, _STEP_NS, _PHASE_NS = 0.02, 20 * MS, 10 * MS
    _BUS_GRAIN_S = 0.00002

    def __init__(self, bench: Bench, controller: Controller) -> None:
        super().__init__()
        self.bench, self.controller = bench, controller
        self._messages = bytearray()
        self._host = None
        if controller.product.attend is not None:
            self._host = controller.product.attend(controller.bus)
            self._host.subscribe_received(self._messages.extend)
        else:
            controller.serial.subscribe_received(lambda byte, _: self._messages.append(byte))
        self.messages = controller.product.attend is not None
        if self.messages:
            # A board on a bus answers at once, but a SmartMotor answers at the end of a sample period.
            self.grain_s = self._BUS_GRAIN_S
        self.has_line = not self.messages
        if self.has_line:
            self.frame_s = controller.serial.host.format.frame_ns / S

    def set_line(self, line: UartFormat) -> None:
        """Set the serial format of the virtual host, e.g. 9600 baud, 8 data bits, no parity, 1 stop bit."""
        self.controller.serial.host.format = line
        self.frame_s = line.frame_ns / S

    @property
    def user_bits(self) -> int:
        """User bits (bits 0 to 2) of the board's status byte."""
        return self.controller.bus.status & USER_BITS

    @property
    def now(self) -> float:
        """Virtual time in seconds."""
        return self.bench.now / S

    def send(self, data: bytes) -> None:
        """Send characters to a serial controller, or one command to a board on a bus."""
        if self._host is not None:
            self._host.write(data)
        else:
            self.controller.serial.write(data)

    def receive(self, silence_s: float = 0.0) -> bytes:
        """Advance virtual time until the controller sends data, and return the data.

        Virtual time advances by at most 20 ms, or by the multiple of 20 ms that is 20 to 40 ms less than `silence_s`.
        """
        clock = self.bench.clock
        end_ns = clock.later(max(1, int(silence_s / self._STEP_S) - 1) * self._STEP_NS)
        # The controller sends data only during events of the simulation, so check for new data after each event.
        while not self._messages:
            due_ns = clock.next_event_ns()
            if due_ns is None or due_ns > end_ns:
                clock.run_to(end_ns)
                break
            clock.step()
        data = bytes(self._messages)
        self._messages.clear()
        return data

    def drain(self) -> bytes:
        """Return the rest of the answers to earlier requests.

        Virtual time advances to the next multiple of 10 ms.  Two controllers on two benches thus receive each request
        in the same phase of their 10 ms cycle.
        """
        self.bench.clock.run_to(-(-self.bench.now // self._PHASE_NS) * self._PHASE_NS)
        data = bytes(self._messages)
        self._messages.clear()
        return data

    def close(self) -> None:
        """Disconnect the virtual host from a board on a bus."""
        if self._host is not None:
            self._host.close()


class SerialEnd(End):
    """Host side of a connection through a serial port or a terminal server."""

    def __init__(self, url: str, name: str, line: UartFormat) -> None:
        super().__init__()
        self._name, self.frame_s = name, line.frame_ns / S
        self.has_line = not url.startswith("socket://")
        try:
            self.port = serial.serial_for_url(
                url, **_settings(line), timeout=0.01,
            )  # fmt: skip
        except (serial.SerialException, ValueError, OSError) as error:
            raise LinkError(
                f"cannot open the port {name} ({error_text(error)}): "
                "check the name, and close other programs that use the port"
            ) from None

    @property
    def now(self) -> float:
        """Real time in seconds."""
        return time.monotonic()

    def set_line(self, line: UartFormat) -> None:
        """Change the baud rate and frame of the serial port."""
        self.frame_s = line.frame_ns / S
        if self.has_line:
            self._call(lambda: self.port.apply_settings(_settings(line)))

    def send(self, data: bytes) -> None:
        """Send characters to the controller."""
        self._call(lambda: self.port.write(data))

    def receive(self, silence_s: float = 0.0) -> bytes:  # noqa: ARG002  # real time passes in steps of some ms
        """Return the characters that the controller has sent."""
        return self._call(lambda: self.port.read(max(1, self.port.in_waiting))) or b""

    def drain(self) -> bytes:
        """Return received characters that belong to an earlier request."""
        return self._call(lambda: self.port.read(self.port.in_waiting)) or b""

    def close(self) -> None:
        """Close the serial port."""
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
            raise LinkError(f"cannot open the bus socket {name} ({error_text(error)}): check its address") from None
        self._lines = self._socket.makefile("rw", encoding="ascii", newline="\n")

    @property
    def now(self) -> float:
        """Real time in seconds."""
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
        """Return the next message of the board, or no bytes if no message is ready."""
        if not self._status() & MESSAGE_READY:
            time.sleep(self._POLL_S)
            return b""
        message = bytes.fromhex(self._request(f"r 0 {MESSAGE}"))
        self._request(f"w 1 {MESSAGE_TAKEN:02x}")
        return message

    def drain(self) -> bytes:
        """Read and return all waiting messages of the board."""
        found = b""
        while more := self.receive():
            found += more
        return found

    @property
    def user_bits(self) -> int:
        """User bits (bits 0 to 2) of the board's status byte."""
        return self._status() & USER_BITS

    def close(self) -> None:
        """Close the connection to the bus socket."""
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


def _settings(line: UartFormat) -> dict[str, Any]:
    return {
        "baudrate": line.baudrate, "bytesize": line.bytesize, "parity": line.parity, "stopbits": line.stopbits,
    }  # fmt: skip


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
    address = target
    if target.startswith("tcp://"):
        address = f"socket://{parse(target).address}"
    elif target.startswith(("pty:", "serial:")):
        address = parse(target).path
    return SerialEnd(address, target, line)
