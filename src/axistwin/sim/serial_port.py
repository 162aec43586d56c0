"""The host's end of a serial connection: data, format, control lines and flow control."""

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from functools import partial

from axistwin.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.frames import LineError, Parity, UartFormat
from axistwin.sim.host_acts import HostAct, HostActs
from axistwin.sim.pins import Pin
from axistwin.sim.serial import Uart
from axistwin.sim.signal import Signal
from axistwin.sim.wirings import Wiring
from axistwin.units import to_ns

X_ON, X_OFF = 0x11, 0x13


class Flow(Enum):
    """The host's flow control: none, by the device's DTR, or by X_ON and X_OFF from the device."""

    NONE = "none"
    DTR = "dtr"
    X_ON_X_OFF = "xon"


class _Output(Pin):
    """An output line of the host."""

    def __init__(self, clock: Clock, kind: str, doing: HostActs) -> None:
        super().__init__(clock, f"host {kind}", True)
        self._kind, self._doing = kind, doing

    def set(self, level: bool) -> None:
        """Set the line, as an action of the host."""
        self._doing(self._kind, bool(level), super().set)


class HostEnd:
    """The host's end of a connection: its format and its two output lines.  Assign to its attributes to change them."""

    def __init__(self, clock: Clock, uart: Uart, doing: HostActs) -> None:
        self._uart, self._doing = uart, doing
        self.dtr_line: Pin = _Output(clock, "dtr", doing)
        self.rts_line: Pin = _Output(clock, "rts", doing)

    @property
    def format(self) -> UartFormat:
        """Baud rate, data bits, parity and stop bits together."""
        assert self._uart.format is not None
        return self._uart.format

    @format.setter
    def format(self, value: UartFormat) -> None:
        self._doing("format", value, partial(setattr, self._uart, "format"))

    @property
    def baudrate(self) -> int:
        """Bits per second."""
        return self.format.baudrate

    @baudrate.setter
    def baudrate(self, value: int) -> None:
        self.format = replace(self.format, baudrate=value)

    @property
    def bytesize(self) -> int:
        """Data bits: 5 to 8."""
        return self.format.bytesize

    @bytesize.setter
    def bytesize(self, value: int) -> None:
        self.format = replace(self.format, bytesize=value)

    @property
    def parity(self) -> Parity:
        """pyserial's letters: N, E, O, M, S."""
        return self.format.parity

    @parity.setter
    def parity(self, value: Parity) -> None:
        self.format = replace(self.format, parity=value)

    @property
    def stopbits(self) -> float:
        """Stop bits: 1, 1.5 or 2."""
        return self.format.stopbits

    @stopbits.setter
    def stopbits(self, value: float) -> None:
        self.format = replace(self.format, stopbits=value)

    @property
    def dtr(self) -> bool:
        """Data terminal ready, to the device's DSR."""
        return self.dtr_line.level

    @dtr.setter
    def dtr(self, on: bool) -> None:
        self.dtr_line.set(on)

    @property
    def rts(self) -> bool:
        """Request to send, to the device's CTS."""
        return self.rts_line.level

    @rts.setter
    def rts(self, on: bool) -> None:
        self.rts_line.set(on)


class SerialPort:
    """A serial connection as the host uses it.  Without device lines `dtr` and `rts`, both count as on."""

    def __init__(
        self, clock: Clock, wiring: Wiring, dtr: Pin | None = None, rts: Pin | None = None, *, line: UartFormat
    ) -> None:
        self.clock = clock
        self._uart = Uart(clock, line, on_receive=self._received)
        self._doing = HostActs(clock)
        self.host = HostEnd(clock, self._uart, self._doing)
        self.handshake = dtr is not None
        """True if there are control lines."""
        self.dtr_line, self.rts_line = dtr or Pin(clock, "dtr", True), rts or Pin(clock, "rts", True)
        self._received_bytes = bytearray()
        self._receives: Signal[int, LineError] = Signal()
        self._breaks: Signal[float] = Signal()
        self._writes: Signal[bytes] = Signal()
        self._settings: Signal[HostAct] = Signal()
        self._flow = Flow.NONE
        self._held = self._stopped = False
        self.to_device, self.from_device = wiring(self._uart)
        self.dtr_line.subscribe(lambda _: self._update_flow())

    def write(self, data: bytes) -> None:
        """Queue data for transmission; flow control decides when it leaves."""
        self._doing("write", data, self._write)

    def _write(self, data: bytes) -> None:
        self._writes.emit(data)
        self._uart.send(data)

    def read(self) -> bytes:
        """Return and remove all received bytes."""
        data = bytes(self._received_bytes)
        self._received_bytes.clear()
        return data

    def send_break(self, seconds: float = 0.25) -> None:
        """Hold the host's transmit line at space for `seconds`.  Raises UsageError for less than 1 ns."""
        if to_ns(seconds) < 1:
            raise UsageError(f"invalid break of {seconds:g} s: expected 1 ns or more, e.g. 0.25 s")
        self._doing("break", seconds, self._break)

    def _break(self, seconds: float) -> None:
        self._uart.send_break(seconds)
        self._breaks.emit(seconds)

    @property
    def control_lines(self) -> dict[str, Pin]:
        """The device's control lines by the device's names: its outputs `dtr` and `rts`, its inputs `dsr` and `cts`.

        Each input is the host's output that is wired to it.
        """
        own, host = {"dtr": self.dtr_line, "rts": self.rts_line}, self.host
        return {**own, "dsr": host.dtr_line, "cts": host.rts_line} if self.handshake else {}

    @property
    def flow(self) -> Flow:
        """The host's flow control.  Every assignment forgets an earlier X_OFF."""
        return self._flow

    @flow.setter
    def flow(self, flow: Flow) -> None:
        self._doing("flow", flow, self._set_flow)

    def _set_flow(self, flow: Flow) -> None:
        if flow is not self._flow or self._stopped:
            self._tell_setting("flow", flow)
        self._flow, self._stopped = flow, False
        self._update_flow()

    @property
    def held(self) -> bool:
        """While True the host transmits nothing, whatever its flow control; a character on the wire is completed."""
        return self._held

    @held.setter
    def held(self, on: bool) -> None:
        self._doing("hold", on, self._hold)

    def _hold(self, on: bool) -> None:
        if on is not self._held:
            self._tell_setting("hold", on)
        self._held = on
        self._update_flow()

    def drop_pending(self) -> None:
        """Discard all queued characters that have not left yet."""
        self._doing("drop", None, self._drop)

    def _drop(self, _: None) -> None:
        if self._uart.queue:
            self._tell_setting("drop", None)
        self._uart.queue.clear()

    @property
    def pending(self) -> int:
        """Number of characters queued by `write` that have not left yet."""
        return len(self._uart.queue)

    @property
    def instant(self) -> bool:
        """True if characters take no time on this connection."""
        return self.to_device.instant

    @instant.setter
    def instant(self, on: bool) -> None:
        if on is not self.instant:
            self._tell_setting("instant", on)
        self.to_device.instant = self.from_device.instant = on

    @property
    def dtr(self) -> bool:
        """The device's data terminal ready."""
        return self.dtr_line.level

    @property
    def rts(self) -> bool:
        """The device's request to send."""
        return self.rts_line.level

    def subscribe_breaks(self, callback: Callable[[float], None]) -> Callable[[], None]:
        """Call `callback(seconds)` with each break that the host sends.  Return an unsubscribe function."""
        return self._breaks.subscribe(callback)

    def subscribe_received(self, callback: Callable[[int, LineError], None]) -> Callable[[], None]:
        """Call `callback(byte, errors)` for each character that the host receives.  Return an unsubscribe function."""
        return self._receives.subscribe(callback)

    def subscribe_sent(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback(data)` with data from the host when it is queued.  Return an unsubscribe function."""
        return self._writes.subscribe(callback)

    def subscribe_settings(self, callback: Callable[[HostAct], None]) -> Callable[[], None]:
        """Call `callback(act)` before each `flow`, `hold`, `drop` and `instant` that changes something, for recordings.

        Settings within another act are reported, settings by the bench itself are not.  Return an unsubscribe function.
        """
        return self._settings.subscribe(callback)

    def _tell_setting(self, kind: str, value: object) -> None:
        if not self.clock.by_itself:
            self._settings.emit(HostAct(kind, value))

    def watch_host(self, callback: Callable[[HostAct], None]) -> Callable[[], None]:
        """Call `callback(act)` before every action of the host.  Return an unsubscribe function.

        Kinds with their values: `write` (bytes), `break` (seconds), `hold`, `dtr`, `rts` (bool), `flow` (Flow),
        `format` (UartFormat), `drop` (None).
        """
        return self._doing.subscribe(callback)

    def perform(self, act: HostAct) -> None:
        """Perform this action of the host."""
        match act.kind:
            case "write":
                self.write(act.value)
            case "break":
                self.send_break(act.value)
            case "hold":
                self.held = act.value
            case "flow":
                self.flow = act.value
            case "format" | "dtr" | "rts":
                setattr(self.host, act.kind, act.value)
            case "drop":
                self.drop_pending()
            case _:
                raise UsageError(f"unknown action {act.kind!r} at a serial line")

    def _received(self, byte: int, errors: LineError) -> None:
        self._received_bytes.append(byte)
        self._receives.emit(byte, errors)
        if byte in (X_ON, X_OFF) and self._flow is Flow.X_ON_X_OFF:
            self._stopped = byte == X_OFF
            self._update_flow()

    def _update_flow(self) -> None:
        """Hold the characters or release them."""
        by_dtr = self._flow is Flow.DTR and not self.dtr
        held = self._held or self._stopped or by_dtr
        if held is not self._uart.held:
            self._uart.held = held
            self._uart.pump()
