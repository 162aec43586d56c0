"""The serial connector of one controller: one client at a time, over any transport.

A new client finds empty buffers, the default line format, and DTR and RTS on.  Characters of the last client are still
transmitted until the next client connects.
"""

from collections.abc import Callable
from typing import Protocol

from axistwin.links.pacing import BLOCK_S, Pacer
from axistwin.links.single_client import Client, Gate, SingleClient
from axistwin.sim.frames import SOUND, LineError, UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Line
from axistwin.sim.serial_port import X_OFF, X_ON, Flow
from axistwin.units import to_seconds

FULL = 512
"""Limit of queued characters: above this number nothing is read from the client until half of them are sent."""
CHUNK = 512
"""Largest number of characters read from a client at once."""
INSTANT_CHUNK = 32
"""Largest number of characters read at once for an instant line, where a chunk is processed while other clients wait.
"""
FEW = 64
"""Limit of queued characters while the bench is behind the wall clock; above this number nothing is read."""


class HostEnd(Protocol):
    """Settings of the host's end of a line that a client can change."""

    format: UartFormat
    dtr: bool
    rts: bool


class HostPort(Protocol):
    """A serial port as a client uses it: a `SerialPort`, or a wrapper of a `SerialPort`."""

    flow: Flow
    held: bool

    @property
    def host(self) -> HostEnd:
        """The host's end of the line."""

    @property
    def dtr_line(self) -> Pin:
        """The device's data terminal ready."""

    @property
    def rts_line(self) -> Pin:
        """The device's request to send."""

    @property
    def pending(self) -> int:
        """Number of queued characters that have not been sent."""

    @property
    def to_device(self) -> Line:
        """The line to the device."""

    def write(self, data: bytes) -> None:
        """Queue data for transmission."""

    def read(self) -> bytes:
        """Return and remove all received bytes."""

    def send_break(self, seconds: float) -> None:
        """Send a break."""

    def drop_pending(self) -> None:
        """Discard the queued characters that have not been sent."""

    def subscribe_received(self, callback: Callable[[int, LineError], None]) -> Callable[[], None]:
        """Call `callback(byte, errors)` for each received character.  Return an unsubscribe function."""


class SerialClient(Client, Protocol):
    """The client of a serial port, at the other end of a transport."""

    flow: Flow | None
    """Flow control chosen by the client; None: the flow control of the plug."""

    def deliver(self, data: bytes, errors: LineError) -> None:
        """Send characters from the controller to the client; `errors`: the line errors of these characters."""


class Plug(SingleClient[SerialClient]):
    """Connects a serial port with one client.

    `title`: the model of the controller.  `reset` is called for each new client.
    """

    def __init__(
        self,
        name: str,
        serial: HostPort,
        pacer: Pacer,
        *,
        title: str = "",
        flow: Flow = Flow.DTR,
        reset: Callable[[], object] = lambda: None,
        gate: Gate | None = None,
    ) -> None:
        super().__init__(name, pacer, gate)
        self.serial, self.title = serial, title or name
        self.flow, self.reset = flow, reset
        self.default_format = self.serial.host.format
        self._flush_requested = False
        self._errors = SOUND
        self._break_from_ns: int | None = None
        self._stop_observing: Callable[[], None] | None = None
        self.serial.subscribe_received(self._received)
        self.apply_flow()

    # Connecting and disconnecting

    def begin(self) -> None:
        """Prepare the port for a new client."""
        self.serial.drop_pending()
        self.serial.read()
        self._errors = SOUND
        self.serial.host.format = self.default_format
        self.serial.flow = self._flow
        self.reset()

    def end(self) -> None:
        """Restore the line after the client has disconnected."""
        self.set_break(False)
        self.serial.host.dtr = self.serial.host.rts = True
        self.apply_flow()
        self._end_pause()

    # Data and settings from the client

    @property
    def full(self) -> bool:
        """True while nothing is read from the client."""
        return self.gate.closed or self._stop_observing is not None

    @property
    def chunk(self) -> int:
        """Largest number of characters read from the client at once."""
        return INSTANT_CHUNK if self.serial.to_device.instant else CHUNK

    @property
    def _behind(self) -> bool:
        """True while the bench is behind the wall clock and many characters are queued."""
        return self.pacer.behind_s > BLOCK_S and self.serial.pending > FEW

    def send(self, data: bytes) -> None:
        """Transmit characters from the client."""
        self.pacer.sync()
        self.serial.write(data)
        self.pacer.work()
        pending = self.serial.pending
        if pending > FEW and (pending > FULL or self._behind) and not self.full and self.client is not None:
            self.client.pause()
            self._stop_observing = self.pacer.subscribe(self._resume_when_emptier)

    def change(self, change: Callable[[], object]) -> None:
        """Apply a setting of the client: a line format or a control line."""
        self.pacer.sync()
        change()
        self.pacer.work()

    def set_break(self, on: bool) -> None:
        """Begin or end a break.

        The length of a break is known at its end only.  The line therefore goes to space at the end, for the same
        length, but at least for two characters.  Between begin and end nothing is transmitted.
        """
        now_ns, began_ns = self.pacer.clock.now, self._break_from_ns
        if on and began_ns is None:
            self._break_from_ns = now_ns
            self.serial.held = True
        elif not on and began_ns is not None:
            self._break_from_ns = None
            least_ns = 2 * self.serial.host.format.frame_ns
            self.serial.send_break(to_seconds(max(now_ns - began_ns, least_ns)))
            self.serial.held = False

    def _resume_when_emptier(self) -> None:
        if self.serial.pending <= FULL // 2 and not self._behind:
            self._end_pause()
            if self.client is not None and not self.gate.closed:
                self.client.resume()

    def _end_pause(self) -> None:
        if self._stop_observing is not None:
            self._stop_observing()
            self._stop_observing = None

    # Data from the controller

    def request_flush(self) -> None:
        """Request a flush after the bench has been advanced."""
        if not self._flush_requested:
            self._flush_requested = True
            self.pacer.request_flush(self)

    def flush(self) -> None:
        """Send received characters to the client.  Without a client they are lost, as on an open cable."""
        self._flush_requested = False
        data, errors, self._errors = self.serial.read(), self._errors, SOUND
        if self.client is None:
            return
        if self.serial.flow is Flow.X_ON_X_OFF:
            data = data.translate(None, bytes((X_ON, X_OFF)))
        self.client.deliver(data, errors)

    def _received(self, _: int, errors: LineError) -> None:
        if not self._flush_requested:
            self.request_flush()
        if errors is not SOUND:
            self._errors |= errors

    def flush_pending(self) -> None:
        """Flush pending output to the client."""
        if self._flush_requested:
            self.flush()

    # Flow control

    @property
    def _flow(self) -> Flow:
        wanted = None if self.client is None else self.client.flow
        return self.flow if wanted is None else wanted

    def apply_flow(self) -> None:
        """Set the flow control of the host's end to the client's choice."""
        if self.serial.flow is not self._flow:
            self.serial.flow = self._flow
