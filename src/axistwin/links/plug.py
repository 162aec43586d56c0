"""The serial connector of one controller: one client at a time, over any transport.

A new client finds empty buffers, the default line format, and DTR and RTS on.  Queued characters of the previous client
are transmitted until the next client connects.
"""

from collections.abc import Callable
from typing import Protocol

from axistwin.core.units import to_seconds
from axistwin.links.pacing import BLOCK_S, Pacer
from axistwin.links.single_client import Client, Gate, SingleClient
from axistwin.sim.frames import SOUND, LineError, UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Line
from axistwin.sim.serial_port import X_OFF, X_ON, Flow
from axistwin.sim.signal import Signal

FULL = 512  # Limit of queued characters: above this number nothing is read from the client until half of them are sent.
CHUNK = 512  # Largest number of characters read from a client at once.
INSTANT_CHUNK = 32  # Like `CHUNK`, for an instant line, which is processed while other clients wait.
FEW = 64  # Limit of queued characters while the bench is behind the wall clock; above this number nothing is read.


class HostEnd(Protocol):
    """The host's end of a serial line.  A client can set the line format, DTR and RTS."""

    format: UartFormat
    dtr: bool
    rts: bool


class HostPort(Protocol):
    """A client's use of a controller's serial port, as `SerialPort` offers it."""

    flow: Flow
    held: bool

    @property
    def host(self) -> HostEnd: ...

    @property
    def dtr_line(self) -> Pin: ...

    @property
    def rts_line(self) -> Pin: ...

    @property
    def hung_up(self) -> Pin: ...

    @property
    def pending(self) -> int: ...

    @property
    def to_device(self) -> Line: ...

    def write(self, data: bytes) -> None: ...

    def read(self) -> bytes: ...

    def send_break(self, seconds: float) -> None: ...

    def drop_pending(self) -> None: ...

    def subscribe_received(self, callback: Callable[[int, LineError], None]) -> Callable[[], None]:
        """Call `callback(byte, errors)` for each character from the controller; return an unsubscribe function."""


class SerialClient(Client, Protocol):
    """Interface of a client that is connected to a serial port."""

    flow: Flow | None  # Flow control chosen by the client; None: the flow control of the plug.

    def deliver(self, data: bytes, errors: LineError) -> None:
        """Forward characters to the client; `errors`: their line errors, e.g. a parity error."""


class Plug(SingleClient[SerialClient]):
    """Gives one client at a time access to a serial port of a controller.

    `title`: the model of the controller.  `reset` is called for each new client.
    """

    def __init__(
        self, name: str, serial: HostPort, pacer: Pacer, *, title: str = "", flow: Flow = Flow.DTR,
        reset: Callable[[], object] = lambda: None, gate: Gate | None = None,
    ) -> None:  # fmt: skip
        super().__init__(name, pacer, gate)
        self.serial, self.title = serial, title or name
        self.flow, self.reset = flow, reset
        self.default_format = self.serial.host.format
        self._flush_requested, self._errors = False, SOUND
        self._break_from_ns: int | None = None
        self._stop_observing: Callable[[], None] | None = None
        self.hang_ups: Signal[bool] = Signal()  # Event: the port is gone (True) or has come back.
        self._has_hung_up = False
        self.serial.subscribe_received(self._received)
        self.serial.hung_up.subscribe(lambda _: self.request_flush())
        self.apply_flow()

    # Functions that connect and disconnect a client

    def begin(self) -> None:
        self.serial.drop_pending()
        self.serial.read()
        self._errors = SOUND
        self.serial.host.format = self.default_format
        self.serial.flow = self._flow
        self.reset()

    def end(self) -> None:
        self.set_break(False)
        self.serial.host.dtr = self.serial.host.rts = True
        self.apply_flow()
        self._end_pause()

    @property
    def refuses_because(self) -> str:
        """Reason why no client can connect; "" if a client can."""
        return super().refuses_because or ("the port is hung up" if self.serial.hung_up.level else "")

    def _follow_hang_up(self) -> None:
        gone = self.serial.hung_up.level
        if gone is self._has_hung_up:
            return
        self._has_hung_up, self._has_refused = gone, False
        if gone and self.client is not None:
            self.client.drop()
        self.hang_ups.emit(gone)

    # Functions that process data and settings from the client

    @property
    def full(self) -> bool:
        return self.gate.closed or self._stop_observing is not None

    @property
    def chunk(self) -> int:
        return INSTANT_CHUNK if self.serial.to_device.instant else CHUNK

    @property
    def _behind(self) -> bool:
        return self.pacer.behind_s > BLOCK_S and self.serial.pending > FEW

    def send(self, data: bytes) -> None:
        self.pacer.sync()
        self.heard_ns = self.pacer.clock.now
        self.serial.write(data)
        self.pacer.work()
        pending = self.serial.pending
        if pending > FEW and (pending > FULL or self._behind) and not self.full and self.client is not None:
            self.client.pause()
            self._stop_observing = self.pacer.subscribe(self._resume_when_emptier)

    def change(self, change: Callable[[], object]) -> None:
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

    # Functions that send data from the controller to the client

    def request_flush(self) -> None:
        if not self._flush_requested:
            self._flush_requested = True
            self.pacer.request_flush(self)

    def flush(self) -> None:
        """Send characters from the controller to the client.  Without a client, the characters are discarded."""
        self._flush_requested = False
        data, errors, self._errors = self.serial.read(), self._errors, SOUND
        if self.client is not None:
            if self.serial.flow is Flow.X_ON_X_OFF:
                data = data.translate(None, bytes((X_ON, X_OFF)))
            self.client.deliver(data, errors)
        self._follow_hang_up()

    def _received(self, _: int, errors: LineError) -> None:
        if not self._flush_requested:
            self.request_flush()
        if errors is not SOUND:
            self._errors |= errors

    def flush_pending(self) -> None:
        if self._flush_requested:
            self.flush()

    # Flow control

    @property
    def _flow(self) -> Flow:
        wanted = None if self.client is None else self.client.flow
        return self.flow if wanted is None else wanted

    def apply_flow(self) -> None:
        if self.serial.flow is not self._flow:
            self.serial.flow = self._flow
