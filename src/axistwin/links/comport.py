"""The server side of one RFC 2217 connection: converts bytes from the client to events, without sockets or clock.

The client negotiates the Com Port Control option and then sends commands: line format, control lines, break, flow
control, purge.  Every command is answered with the present setting.  The server reports changes of the client's
DSR and CTS, which are the device's DTR and RTS.  Line errors of received characters are reported on request.

`receive` returns the client's requests as events; answers are collected in `replies`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum, IntFlag
from functools import partial
from typing import Any

from axistwin.links.telnet import Command, Item, Negotiation, Option, Parser, Subnegotiation, Verb
from axistwin.sim.frames import BITS, FASTEST_BAUD, LineError, UartFormat
from axistwin.sim.serial_port import SetFormat

SERVER = 100  # Number that is added to the code of a command to get the code of its answer.


class Code(IntEnum):
    """Codes of the RFC 2217 commands that a client sends."""

    SIGNATURE = 0
    SET_BAUDRATE = 1
    SET_DATASIZE = 2
    SET_PARITY = 3
    SET_STOPSIZE = 4
    SET_CONTROL = 5
    NOTIFY_LINESTATE = 6
    NOTIFY_MODEMSTATE = 7
    FLOWCONTROL_SUSPEND = 8
    FLOWCONTROL_RESUME = 9
    SET_LINESTATE_MASK = 10
    SET_MODEMSTATE_MASK = 11
    PURGE_DATA = 12


class Control(IntEnum):
    """Values of RFC 2217's SET-CONTROL; `ASK_…` asks for the setting whose values come after it in this list."""

    ASK_FLOW = 0
    FLOW_NONE = 1
    FLOW_X_ON_X_OFF = 2
    FLOW_HARDWARE = 3
    ASK_BREAK = 4
    BREAK_ON = 5
    BREAK_OFF = 6
    ASK_DTR = 7
    DTR_ON = 8
    DTR_OFF = 9
    ASK_RTS = 10
    RTS_ON = 11
    RTS_OFF = 12
    ASK_INBOUND_FLOW = 13
    INBOUND_NONE = 14
    INBOUND_X_ON_X_OFF = 15
    INBOUND_HARDWARE = 16
    FLOW_DCD = 17
    INBOUND_DTR = 18
    FLOW_DSR = 19


class ModemState(IntFlag):
    """NOTIFY-MODEMSTATE: the client's input lines, and their changes."""

    NONE = 0
    CTS_CHANGED = 1
    DSR_CHANGED = 2
    CTS = 16
    DSR = 32


class LineState(IntFlag):
    """NOTIFY-LINESTATE: bits of a UART's line status register."""

    NONE = 0
    PARITY_ERROR = 4
    FRAMING_ERROR = 8
    BREAK = 16
    EMPTY = 32 | 64


@dataclass(frozen=True)
class SetLines:
    """Request to set levels of control lines."""

    dtr: bool
    rts: bool


@dataclass(frozen=True)
class SetBreak:
    """Request to begin or end a break."""

    on: bool


@dataclass(frozen=True)
class SetFlow:
    """Request for a kind of flow control for data to the device, e.g. FLOW_NONE or FLOW_HARDWARE."""

    outbound: Control


@dataclass(frozen=True)
class Purge:
    """Request to discard characters received from the device, or not yet transmitted to the device."""

    received: bool
    to_transmit: bool


@dataclass(frozen=True)
class Suspend:
    """Request of the client to the server: stop sending data to the client, or resume sending."""

    on: bool


Event = bytes | SetFormat | SetLines | SetBreak | SetFlow | Purge | Suspend

OURS = frozenset((Option.BINARY, Option.ECHO, Option.SUPPRESS_GO_AHEAD, Option.COM_PORT))
"""Options that the server accepts for itself.  An echo, if any, comes from the controller."""
THEIRS = frozenset((Option.BINARY, Option.SUPPRESS_GO_AHEAD, Option.COM_PORT))  # Accepted for the client.
PARTS: dict[Code, tuple[str, dict[int, Any]]] = {
    Code.SET_DATASIZE: ("bytesize", {size: size for size in BITS}),
    Code.SET_PARITY: ("parity", {1: "N", 2: "O", 3: "E", 4: "M", 5: "S"}),
    Code.SET_STOPSIZE: ("stopbits", {1: 1, 2: 2, 3: 1.5}),
}
"""Parts of a line format by command; each maps the numbers of RFC 2217 to values."""
INBOUND = {
    Control.FLOW_NONE: Control.INBOUND_NONE, Control.FLOW_X_ON_X_OFF: Control.INBOUND_X_ON_X_OFF,
    Control.FLOW_HARDWARE: Control.INBOUND_HARDWARE,
}  # fmt: skip
"""Inbound setting that each setting for "outbound or both" implies."""


class ComPort:
    """The state of one client's port.  `line`: the initial format."""

    def __init__(self, line: UartFormat, signature: str) -> None:
        self.format, self.signature = line, signature
        self.dtr = self.rts = True
        self.break_on = False
        self.outbound, self.inbound = Control.FLOW_NONE, Control.INBOUND_NONE
        self.agreed = False  # True after the client has negotiated RFC 2217.
        self.replies = bytearray()
        self._ours: set[int] = set()
        self._theirs: set[int] = set()
        self._modem_state, self._modem_mask = ModemState.NONE, 0xFF
        self._line_state, self._line_mask = LineState.EMPTY, 0
        self._parser = Parser()

    # Functions that convert bytes from the client to requests

    def receive(self, data: bytes) -> list[Event]:
        """Process bytes from the client, and return the client's requests as events."""
        events = [self._process(item) for item in self._parser.feed(data)]
        return [event for event in events if event is not None]

    def take_replies(self) -> bytes:
        replies = bytes(self.replies)
        self.replies.clear()
        return replies

    def _process(self, item: Item) -> Event | None:
        match item:
            case bytes():
                return item
            case Negotiation(Verb.DO | Verb.DONT):
                self._negotiate(item, self._ours, OURS, Verb.WILL, Verb.WONT)
            case Negotiation():
                self._negotiate(item, self._theirs, THEIRS, Verb.DO, Verb.DONT)
            case Subnegotiation(Option.COM_PORT, payload) if payload and payload[0] in _COMMANDS:
                return _COMMANDS[Code(payload[0])](self, payload[1:])
            case Subnegotiation() | Command():
                pass
        return None

    def _negotiate(
        self, asked: Negotiation, active: set[int], possible: frozenset[Option], yes: Verb, no: Verb
    ) -> None:
        """Negotiate a Telnet option; a request for the present state gets no answer, lest both answer for ever."""
        on = asked.verb in (Verb.DO, Verb.WILL)
        if on and asked.option not in possible:
            self.replies += bytes(Negotiation(no, asked.option))
        elif on is not (asked.option in active):
            active.symmetric_difference_update({asked.option})
            self.replies += bytes(Negotiation(yes if on else no, asked.option))
            if on and asked.option == Option.COM_PORT and not self.agreed:
                self.agreed = True
                self._report_modem_state()

    def _answer(self, code: Code, value: bytes) -> None:
        self.replies += bytes(Subnegotiation(Option.COM_PORT, bytes((SERVER + code,)) + value))

    # If a client requests an invalid baud rate, the server answers with the present baud rate.

    def _report_signature(self, value: bytes) -> None:
        if not value:  # A command SIGNATURE without text requests the server's identification.
            self._answer(Code.SIGNATURE, self.signature.encode())

    def _set_baudrate(self, value: bytes) -> Event | None:
        baudrate = int.from_bytes(value, "big") if len(value) == 4 else 0
        possible = 1 <= baudrate <= FASTEST_BAUD
        event = self._set_format(replace(self.format, baudrate=baudrate)) if possible else None
        self._answer(Code.SET_BAUDRATE, self.format.baudrate.to_bytes(4, "big"))
        return event

    def _set_part(self, value: bytes, code: Code) -> Event | None:
        name, settings = PARTS[code]
        known = value[:1] and value[0] in settings
        event = self._set_format(replace(self.format, **{name: settings[value[0]]})) if known else None
        self._answer(code, bytes(n for n, setting in settings.items() if setting == getattr(self.format, name)))
        return event

    def _set_format(self, fmt: UartFormat) -> Event:
        self.format = fmt
        return SetFormat(fmt)

    def _set_control(self, value: bytes) -> Event | None:
        if not value or value[0] > max(Control):
            return None
        event: Event | None = None
        match control := Control(value[0]):
            case Control.ASK_FLOW | Control.FLOW_DCD:  # DCD: no such line
                control = self.outbound
            case Control.FLOW_NONE | Control.FLOW_X_ON_X_OFF | Control.FLOW_HARDWARE | Control.FLOW_DSR:
                self.outbound, self.inbound = control, INBOUND.get(control, self.inbound)
                event = SetFlow(control)
            case Control.ASK_INBOUND_FLOW:
                control = self.inbound
            case Control.INBOUND_NONE | Control.INBOUND_X_ON_X_OFF | Control.INBOUND_HARDWARE | Control.INBOUND_DTR:
                self.inbound = control
            case Control.ASK_BREAK:
                control = Control.BREAK_ON if self.break_on else Control.BREAK_OFF
            case Control.BREAK_ON | Control.BREAK_OFF:
                self.break_on = control is Control.BREAK_ON
                event = SetBreak(self.break_on)
            case Control.ASK_DTR:
                control = Control.DTR_ON if self.dtr else Control.DTR_OFF
            case Control.ASK_RTS:
                control = Control.RTS_ON if self.rts else Control.RTS_OFF
            case Control.DTR_ON | Control.DTR_OFF:
                self.dtr = control is Control.DTR_ON
                event = SetLines(self.dtr, self.rts)
            case Control.RTS_ON | Control.RTS_OFF:
                self.rts = control is Control.RTS_ON
                event = SetLines(self.dtr, self.rts)
        self._answer(Code.SET_CONTROL, bytes((control,)))
        return event

    def _set_line_state_mask(self, value: bytes) -> None:
        self._line_mask = value[0] if value else self._line_mask
        self._answer(Code.SET_LINESTATE_MASK, bytes((self._line_mask,)))

    def _set_modem_state_mask(self, value: bytes) -> None:
        self._modem_mask = value[0] if value else self._modem_mask
        self._answer(Code.SET_MODEMSTATE_MASK, bytes((self._modem_mask,)))
        self._report_modem_state()

    def _purge(self, value: bytes) -> Event | None:
        if value not in (b"\1", b"\2", b"\3"):
            return None
        self._answer(Code.PURGE_DATA, value)
        return Purge(received=bool(value[0] & 1), to_transmit=bool(value[0] & 2))

    # Notifications

    def set_modem_state(self, *, dsr: bool, cts: bool, moved: ModemState = ModemState.NONE) -> None:
        """Report the client's input lines; `moved`: lines that have changed, even if they have changed back."""
        now = (ModemState.DSR if dsr else ModemState.NONE) | (ModemState.CTS if cts else ModemState.NONE)
        changed = self._modem_state ^ now
        moved |= ModemState.DSR_CHANGED if changed & ModemState.DSR else ModemState.NONE
        moved |= ModemState.CTS_CHANGED if changed & ModemState.CTS else ModemState.NONE
        self._modem_state = now
        if self.agreed and (moved | moved << 4) & self._modem_mask:
            self._report_modem_state(moved)

    def set_line_state(self, errors: LineError) -> None:
        # Shift by 2 bits: a parity error is bit 0 of `LineError`, but bit 2 in RFC 2217.
        state = self._line_state = LineState.EMPTY | LineState(errors.value << 2)
        if self.agreed and state & ~LineState.EMPTY & self._line_mask:
            self._report_line_state()

    def _report_modem_state(self, moved: ModemState = ModemState.NONE) -> None:
        self._answer(Code.NOTIFY_MODEMSTATE, bytes(((self._modem_state | moved) & self._modem_mask,)))

    def _report_line_state(self) -> None:
        self._answer(Code.NOTIFY_LINESTATE, bytes((self._line_state,)))
        self._line_state = LineState.EMPTY


_COMMANDS: dict[int, Callable[[ComPort, bytes], Event | None]] = {
    Code.SIGNATURE: ComPort._report_signature, Code.SET_BAUDRATE: ComPort._set_baudrate,
    **{code: partial(ComPort._set_part, code=code) for code in PARTS}, Code.SET_CONTROL: ComPort._set_control,
    Code.NOTIFY_LINESTATE: lambda port, _: port._report_line_state(),
    Code.NOTIFY_MODEMSTATE: lambda port, _: port._report_modem_state(),
    Code.FLOWCONTROL_SUSPEND: lambda _, __: Suspend(True), Code.FLOWCONTROL_RESUME: lambda _, __: Suspend(False),
    Code.SET_LINESTATE_MASK: ComPort._set_line_state_mask, Code.SET_MODEMSTATE_MASK: ComPort._set_modem_state_mask,
    Code.PURGE_DATA: ComPort._purge,
}  # fmt: skip
