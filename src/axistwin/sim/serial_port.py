"""The host's end of a serial connection: what it writes and reads, its format, its control lines, its flow control."""

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
from axistwin.sim.wirings import Wiring
from axistwin.units import to_ns

X_ON, X_OFF = 0x11, 0x13


class Flow(Enum):
    """What makes a host hold back its characters: nothing, the device's DTR, or what the device sends."""

    NONE = "none"
    DTR = "dtr"
    X_ON_X_OFF = "xon"


class _Output(Pin):
    """An output of the host's."""

    def __init__(self, clock: Clock, kind: str, doing: HostActs) -> None:
        super().__init__(clock, f"host {kind}", True)
        self._kind, self._doing = kind, doing

    def set(self, level: bool) -> None:
        """The host does it."""
        self._doing(self._kind, bool(level), super().set)


class HostEnd:
    """The host's end of a connection: its format and its two output lines.  Assign to change them."""

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
        """1, 1.5 or 2."""
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
    """What a host sees of a serial connection.  Without lines `dtr` and `rts` of a device these count as on."""

    def __init__(
        self, clock: Clock, wiring: Wiring, dtr: Pin | None = None, rts: Pin | None = None, *, line: UartFormat
    ) -> None:
        self.clock = clock
        self._uart = Uart(clock, line, on_receive=self._received)
        self._doing = HostActs(clock)
        self.host = HostEnd(clock, self._uart, self._doing)
        self.handshake = dtr is not None
        """Whether there are control lines."""
        self.dtr_line, self.rts_line = dtr or Pin(clock, "dtr", True), rts or Pin(clock, "rts", True)
        self._received_bytes = bytearray()
        self._hearers: list[Callable[[int, LineError], None]] = []
        self._break_watchers: list[Callable[[float], None]] = []
        self._listeners: list[Callable[[bytes], None]] = []
        self._setting_watchers: list[Callable[[HostAct], None]] = []
        self._flow = Flow.NONE
        self._held = self._stopped = False
        self.to_device, self.from_device = wiring(self._uart)
        self.dtr_line.watch(lambda _: self._settle())

    def write(self, data: bytes) -> None:
        """Queue what the host transmits; it leaves as its flow control allows."""
        self._doing("write", data, self._write)

    def _write(self, data: bytes) -> None:
        for listener in tuple(self._listeners):
            listener(data)
        self._uart.send(data)

    def read(self) -> bytes:
        """Everything the host has received and not yet read."""
        data = bytes(self._received_bytes)
        self._received_bytes.clear()
        return data

    def send_break(self, seconds: float = 0.25) -> None:
        """Hold the host's transmit line at space for so long.  Raises UsageError for less than 1 ns."""
        if to_ns(seconds) < 1:
            raise UsageError(f"a break of {seconds:g} s is none: give 1 ns or more, such as 0.25 s")
        self._doing("break", seconds, self._break)

    def _break(self, seconds: float) -> None:
        self._uart.send_break(seconds)
        for watcher in tuple(self._break_watchers):
            watcher(seconds)

    @property
    def control_lines(self) -> dict[str, Pin]:
        """The device's control lines by its names: its outputs `dtr` and `rts`, its inputs `dsr` and `cts`.

        A host's output is what the device's input is wired to.
        """
        own, host = {"dtr": self.dtr_line, "rts": self.rts_line}, self.host
        return {**own, "dsr": host.dtr_line, "cts": host.rts_line} if self.handshake else {}

    @property
    def flow(self) -> Flow:
        """What makes this host hold back its characters.  Set, also anew, it forgets an X_OFF that has come before."""
        return self._flow

    @flow.setter
    def flow(self, flow: Flow) -> None:
        self._doing("flow", flow, self._set_flow)

    def _set_flow(self, flow: Flow) -> None:
        if flow is not self._flow or self._stopped:
            self._tell_setting("flow", flow)
        self._flow, self._stopped = flow, False
        self._settle()

    @property
    def held(self) -> bool:
        """While True the host transmits nothing, whatever its flow control; the character on the wire is the last."""
        return self._held

    @held.setter
    def held(self, on: bool) -> None:
        self._doing("hold", on, self._hold)

    def _hold(self, on: bool) -> None:
        if on is not self._held:
            self._tell_setting("hold", on)
        self._held = on
        self._settle()

    def drop_pending(self) -> None:
        """Forget what is queued and has not left yet."""
        self._doing("drop", None, self._drop)

    def _drop(self, _: None) -> None:
        if self._uart.queue:
            self._tell_setting("drop", None)
        self._uart.queue.clear()

    @property
    def pending(self) -> int:
        """Characters queued by `write` that have not left yet."""
        return len(self._uart.queue)

    @property
    def instant(self) -> bool:
        """Whether characters take no time on this connection."""
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

    def watch_breaks(self, watcher: Callable[[float], None]) -> Callable[[], None]:
        """Call `watcher(seconds)` with each break that the host sends.  Returns what ends the watching."""
        self._break_watchers.append(watcher)
        return lambda: self._break_watchers.remove(watcher)

    def hear(self, hearer: Callable[[int, LineError], None]) -> Callable[[], None]:
        """Call `hearer(byte, errors)` for each character the host receives.  Returns what ends the hearing."""
        self._hearers.append(hearer)
        return lambda: self._hearers.remove(hearer)

    def listen(self, listener: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `listener(data)` with what the host writes, when it is queued.  Returns what ends the listening."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def watch_settings(self, watcher: Callable[[HostAct], None]) -> Callable[[], None]:
        """Call `watcher(act)` before each `flow`, `hold`, `drop` and `instant` that changes something, for recordings.

        Also within another act; not what the bench does by itself.  Returns what ends the watching.
        """
        self._setting_watchers.append(watcher)
        return lambda: self._setting_watchers.remove(watcher)

    def _tell_setting(self, kind: str, value: object) -> None:
        if not self.clock.by_itself:
            for watcher in tuple(self._setting_watchers):
                watcher(HostAct(kind, value))

    def watch_host(self, watcher: Callable[[HostAct], None]) -> Callable[[], None]:
        """Call `watcher(act)` before everything that is done from the host's side.  Returns what ends the watching.

        Kinds, with their values: `write` (bytes), `break` (seconds), `hold`, `dtr`, `rts` (bool), `flow` (Flow),
        `format` (UartFormat), `drop` (None).
        """
        return self._doing.watch(watcher)

    def perform(self, act: HostAct) -> None:
        """Do, from the host's side, what such an act says."""
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
                raise UsageError(f"a host at a serial line cannot {act.kind!r}")

    def _received(self, byte: int, errors: LineError) -> None:
        self._received_bytes.append(byte)
        for hearer in tuple(self._hearers):
            hearer(byte, errors)
        if byte in (X_ON, X_OFF) and self._flow is Flow.X_ON_X_OFF:
            self._stopped = byte == X_OFF
            self._settle()

    def _settle(self) -> None:
        """Hold the characters back, or let them go."""
        by_dtr = self._flow is Flow.DTR and not self.dtr
        held = self._held or self._stopped or by_dtr
        if held is not self._uart.held:
            self._uart.held = held
            self._uart.pump()
