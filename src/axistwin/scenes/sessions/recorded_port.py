"""Ports of a session for hosts.  Each action of a host is recorded, and a port can be moved to another bench.

A port is muted during a replay, because the replay repeats data that its host has already received.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.pins import Pin
from axistwin.sim.registers import CONTROL, DATA, BusAct, Init, ReadData, RegisterPort, WriteRegister, check_byte
from axistwin.sim.serial import Line
from axistwin.sim.serial_port import (
    DropPending,
    Flow,
    Hold,
    HostEnd,
    LineAct,
    SendBreak,
    SerialPort,
    SetFlow,
    SetFormat,
    SetLine,
    Write,
    check_break,
)
from axistwin.sim.signal import Signal


class MutableLine(Pin):
    """A control line of a device on the present bench; its changes are not reported while it is muted."""

    def __init__(self, pin: Pin) -> None:
        super().__init__(pin.clock, pin.name, output=True)
        self._muted = self._last = False
        self._line, self._unsubscribe = pin, pin.subscribe(self._forward)

    def attach(self, pin: Pin) -> None:
        self._unsubscribe()
        self._line, self._unsubscribe = pin, pin.subscribe(self._forward)

    @property
    def level(self) -> bool:
        return self._line.level

    def mute(self, on: bool) -> None:
        """Begin or end muting; at the end, report a level that has changed since the beginning."""
        if on is self._muted:
            return
        self._muted = on
        if on:
            self._last = self.level
        else:
            self._update(self._last)

    def _forward(self, _: Pin) -> None:
        if not self._muted:
            self._announce()


def _forwarded(name: str, act: Callable[[Any], LineAct] | None = None) -> Any:
    def assign(recorded: "RecordedHost | RecordedPort", value: object) -> None:
        assert act is not None, "the property can be set"
        recorded.do(act(value), lambda present: setattr(present, name, value))

    return property(lambda recorded: getattr(recorded.present, name), assign if act else None)


class RecordedHost:
    """The host's end of a serial line, with a record of each change of character format, DTR and RTS."""

    format: UartFormat = _forwarded("format", SetFormat)
    dtr: bool = _forwarded("dtr", partial(SetLine, "dtr"))
    rts: bool = _forwarded("rts", partial(SetLine, "rts"))

    def __init__(self, port: "RecordedPort") -> None:
        self._port = port

    @property
    def present(self) -> HostEnd:
        return self._port.present.host

    def do(self, act: LineAct, perform: Callable[[HostEnd], object]) -> None:
        self._port.do(act, lambda port: perform(port.host))


class RecordedPort:
    """A serial port whose host's actions are recorded: `record` is called before each."""

    flow: Flow = _forwarded("flow", SetFlow)
    held: bool = _forwarded("held", Hold)
    pending: int = _forwarded("pending")
    to_device: Line = _forwarded("to_device")

    def __init__(self, port: SerialPort, record: Callable[[LineAct], object]) -> None:
        self.present, self._record = port, record
        self.host = RecordedHost(self)
        self.dtr_line, self.rts_line = MutableLine(port.dtr_line), MutableLine(port.rts_line)
        self.hung_up = MutableLine(port.hung_up)
        self._muted = False
        self._receives: Signal[int, LineError] = Signal()
        self._settings: dict[object, tuple[int, Callable[[], None]]] = {}
        """Last setting of each kind: its time, and a function that repeats the setting."""
        self._unsubscribe = port.subscribe_received(self._received)

    def attach(self, port: SerialPort) -> None:
        """Connect to the port of a new controller, without a change of its settings."""
        self._unsubscribe()
        self.present = port
        self._unsubscribe = port.subscribe_received(self._received)
        self.dtr_line.attach(port.dtr_line)
        self.rts_line.attach(port.rts_line)
        self.hung_up.attach(port.hung_up)

    def mute(self, on: bool) -> None:
        """Begin or end the muting of the port.  A muted port passes no data and no level changes to its host.

        `on`: True begins the muting, False ends the muting.  At the end, repeat each setting whose recorded time is
        later than the present virtual time.
        """
        self._muted = on
        if not on:
            now_ns = self.present.clock.now
            for set_ns, repeat in tuple(self._settings.values()):
                if set_ns > now_ns:
                    repeat()
        self.dtr_line.mute(on)
        self.rts_line.mute(on)
        self.hung_up.mute(on)

    def do(self, act: LineAct, perform: Callable[[SerialPort], object]) -> None:
        self._record(act)
        if isinstance(act, SetFormat | SetLine | SetFlow | Hold):
            kind = act.line if isinstance(act, SetLine) else type(act)
            self._settings[kind] = self.present.clock.now, lambda: self.do(act, perform)
        perform(self.present)

    def write(self, data: bytes) -> None:
        self.do(Write(data), lambda port: port.write(data))

    def read(self) -> bytes:
        return self.present.read()

    def send_break(self, seconds: float) -> None:
        """Hold the host's transmit line at space for `seconds`.  Raises UsageError for less than 1 ns."""
        check_break(seconds)
        self.do(SendBreak(seconds), lambda port: port.send_break(seconds))

    def drop_pending(self) -> None:
        self.do(DropPending(), lambda port: port.drop_pending())

    def subscribe_received(self, callback: Callable[[int, LineError], None]) -> Callable[[], None]:
        return self._receives.subscribe(callback)

    def _received(self, byte: int, errors: LineError) -> None:
        if self._muted:
            # A replay repeats the earlier output of the controller; the host must not receive this output twice.
            self.present.read()
        else:
            self._receives.emit(byte, errors)


class RecordedBus:
    """The registers of a board.  `record` is called with each action that changes the board, before it is performed."""

    def __init__(self, bus: RegisterPort, record: Callable[[BusAct], object]) -> None:
        self.present, self._record = bus, record
        self.interrupt_line = MutableLine(bus.interrupt_line)

    def attach(self, bus: RegisterPort) -> None:
        self.present = bus
        self.interrupt_line.attach(bus.interrupt_line)

    def mute(self, on: bool) -> None:
        self.interrupt_line.mute(on)

    @property
    def interrupt(self) -> bool:
        return self.interrupt_line.level

    def read(self, offset: int) -> int:
        """Read a register.  A read of the status byte changes nothing."""
        if offset == DATA:
            self._report(ReadData())
        return self.present.read(offset)

    def write(self, offset: int, value: int) -> None:
        check_byte("offset", offset, CONTROL)
        check_byte("value", value)
        self._report(WriteRegister(offset, value))
        self.present.write(offset, value)

    def init(self) -> None:
        self._report(Init())
        self.present.init()

    def _report(self, act: BusAct) -> None:
        if self.present.powered:
            self._record(act)
