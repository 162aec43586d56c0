"""The host's end of a serial connection: data, format, control lines and flow control."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, Literal, NamedTuple

from axistwin.core.errors import UsageError
from axistwin.core.numbers import clipped
from axistwin.core.units import to_ns
from axistwin.sim.clock import Clock
from axistwin.sim.frames import LineError, Parity, UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.signal import Signal
from axistwin.sim.wirings import Wiring

X_ON, X_OFF = 0x11, 0x13


class Flow(Enum):
    """The host's flow control: none, by the device's DTR, or by X_ON and X_OFF from the device."""

    NONE = "none"
    DTR = "dtr"
    X_ON_X_OFF = "xon"


class Write(NamedTuple):
    """Action of a host: queue data for transmission."""

    data: bytes


class SendBreak(NamedTuple):
    """Action of a host: send a break."""

    seconds: float


class SetFormat(NamedTuple):
    """Action of a host: set the baud rate and the character format of the serial line."""

    format: UartFormat


class SetLine(NamedTuple):
    """Action of a host: set the level of its output DTR or RTS."""

    line: Literal["dtr", "rts"]
    on: bool


class SetFlow(NamedTuple):
    """Action of a host: set the kind of flow control."""

    flow: Flow


class Hold(NamedTuple):
    """Action of a host: stop or resume the transmission of characters."""

    on: bool


@dataclass(frozen=True, slots=True)
class DropPending:
    """Action of a host: discard the queued characters that have not been sent."""


class SetInstant(NamedTuple):
    """Action of a user: the transmission of characters takes no time (`on`), or takes time."""

    on: bool


Setting = SetFlow | Hold | DropPending | SetInstant
LineAct = Write | SendBreak | SetFormat | SetLine | Setting


def _part(name: str, doc: str) -> Any:
    def assign(end: "HostEnd", value: Any) -> None:
        end.format = replace(end.format, **{name: value})

    return property(lambda end: getattr(end.format, name), assign, doc=doc)


class HostEnd:
    """The host's end: character format, and levels of DTR and RTS.  Assign to the attributes to change them."""

    baudrate: int = _part("baudrate", "Bits per second.")
    bytesize: int = _part("bytesize", "Data bits: 5 to 8.")
    parity: Parity = _part("parity", "pyserial's letters: N, E, O, M, S.")
    stopbits: float = _part("stopbits", "Stop bits: 1, 1.5 or 2.")

    def __init__(self, clock: Clock, uart: Uart) -> None:
        self._uart = uart
        self.dtr_line, self.rts_line = Pin(clock, "host dtr", True), Pin(clock, "host rts", True)

    @property
    def format(self) -> UartFormat:
        """Format of the serial line: baud rate, data bits, parity and stop bits."""
        assert self._uart.format is not None
        return self._uart.format

    @format.setter
    def format(self, value: UartFormat) -> None:
        self._uart.format = value

    @property
    def dtr(self) -> bool:
        """Data terminal ready, wired to the device's DSR."""
        return self.dtr_line.level

    @dtr.setter
    def dtr(self, on: bool) -> None:
        self.dtr_line.set(bool(on))

    @property
    def rts(self) -> bool:
        """Request to send, wired to the device's CTS."""
        return self.rts_line.level

    @rts.setter
    def rts(self, on: bool) -> None:
        self.rts_line.set(bool(on))


class SerialPort:
    """The host's side of a serial connection: data, format, control lines and flow control.

    A DTR or RTS line that the device does not have counts as on.
    """

    def __init__(
        self, clock: Clock, wiring: Wiring, dtr: Pin | None = None, rts: Pin | None = None, *, line: UartFormat
    ) -> None:
        self.clock = clock
        self._uart = Uart(clock, line, on_receive=self._received)
        self.host = HostEnd(clock, self._uart)
        self.handshake = dtr is not None
        self.dtr_line, self.rts_line = dtr or Pin(clock, "dtr", True), rts or Pin(clock, "rts", True)
        self.hung_up = Pin(clock, "hung up")  # High while the clients' port is gone, by the fault `hang_up`.
        self._received_bytes = bytearray()
        self._receives: Signal[int, LineError] = Signal()
        self.breaks: Signal[float] = Signal()  # Event: the host sends a break, of this duration in seconds.
        self._writes: Signal[bytes] = Signal()
        self.settings: Signal[Setting] = Signal()  # Event: a setting is about to change, and not by the bench itself.
        self._flow = Flow.NONE
        self._held = self._stopped = False
        self.to_device, self.from_device = wiring(self._uart)
        self.dtr_line.subscribe(lambda _: self._update_flow())

    def write(self, data: bytes) -> None:
        """Queue data for transmission; flow control may delay the data.  Raises UsageError for a text."""
        if isinstance(data, str):  # type: ignore[unreachable]  # what users try
            raise UsageError(f"write({clipped(data)!r}): expected bytes, e.g. write(b'...') or write(text.encode())")
        self._writes.emit(data)
        self._uart.send(data)

    def read(self) -> bytes:
        """Return the bytes that the host has received, and empty the receive buffer."""
        data = bytes(self._received_bytes)
        self._received_bytes.clear()
        return data

    def send_break(self, seconds: float = 0.25) -> None:
        """Hold the host's transmit line at space for `seconds`.  Raises UsageError for less than 1 ns."""
        check_break(seconds)
        self._uart.send_break(seconds)
        self.breaks.emit(seconds)

    @property
    def control_lines(self) -> dict[str, Pin]:
        """The device's outputs `dtr` and `rts`, and its inputs `dsr` and `cts`, as the host's outputs set them."""
        own, host = {"dtr": self.dtr_line, "rts": self.rts_line}, self.host
        return {**own, "dsr": host.dtr_line, "cts": host.rts_line} if self.handshake else {}

    @property
    def flow(self) -> Flow:
        """The kind of flow control that the host uses.  An assignment cancels the effect of an earlier X_OFF."""
        return self._flow

    @flow.setter
    def flow(self, flow: Flow) -> None:
        if flow is not self._flow or self._stopped:
            self._report(SetFlow(flow))
        self._flow, self._stopped = flow, False
        self._update_flow()

    @property
    def held(self) -> bool:
        """True if the host's transmission is stopped, in any flow control; a character on the wire is completed."""
        return self._held

    @held.setter
    def held(self, on: bool) -> None:
        if on is not self._held:
            self._report(Hold(on))
        self._held = on
        self._update_flow()

    def drop_pending(self) -> None:
        """Discard all queued characters that have not been sent."""
        if self._uart.queue:
            self._report(DropPending())
        self._uart.queue.clear()

    @property
    def pending(self) -> int:
        """Number of characters in the transmit queue, which `write` fills."""
        return len(self._uart.queue)

    @property
    def sending(self) -> bool:
        """True while a character is on the wire, or waits in the transmit queue."""
        return self._uart.sending or bool(self._uart.queue)

    @property
    def instant(self) -> bool:
        """True if the connection transmits each character without delay."""
        return self.to_device.instant

    @instant.setter
    def instant(self, on: bool) -> None:
        if on is not self.instant:
            self._report(SetInstant(on))
        self.to_device.instant = self.from_device.instant = on

    @property
    def dtr(self) -> bool:
        """State of the device's output DTR (data terminal ready)."""
        return self.dtr_line.level

    @property
    def rts(self) -> bool:
        """State of the device's output RTS (request to send)."""
        return self.rts_line.level

    def subscribe_received(self, callback: Callable[[int, LineError], None]) -> Callable[[], None]:
        """Call `callback(byte, errors)` for each character that the host receives.  Return an unsubscribe function."""
        return self._receives.subscribe(callback)

    def subscribe_sent(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback(data)` whenever the host queues data.  Return an unsubscribe function."""
        return self._writes.subscribe(callback)

    def _report(self, setting: Setting) -> None:
        if not self.clock.by_itself:
            self.settings.emit(setting)

    def _received(self, byte: int, errors: LineError) -> None:
        self._received_bytes.append(byte)
        self._receives.emit(byte, errors)
        if byte in (X_ON, X_OFF) and self._flow is Flow.X_ON_X_OFF:
            self._stopped = byte == X_OFF
            self._update_flow()

    def _update_flow(self) -> None:
        by_dtr = self._flow is Flow.DTR and not self.dtr
        held = self._held or self._stopped or by_dtr
        if held is not self._uart.held:
            self._uart.held = held
            self._uart.pump()


def check_break(seconds: float) -> None:
    """Raise UsageError if a break signal is shorter than 1 ns."""
    if to_ns(seconds) < 1:
        raise UsageError(f"invalid duration of a break signal, {seconds:g} s: expected 1 ns or more, e.g. 0.25 s")
