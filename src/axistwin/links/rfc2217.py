"""RFC 2217: TCP with line format, control lines, break and flow control.

The client's DTR is the device's DSR, and the client's RTS is the device's CTS.  The device's DTR is the client's DSR,
and the device's RTS is the client's CTS (with `?cts=dtr`: the device's DTR).  The client chooses the flow control.
With hardware flow control (RTS/CTS or DSR), characters for the device are held while the device's DTR is off: the
manual's 5-wire cable connects DTR to the input that the host uses.
"""

import asyncio
from collections.abc import Callable

from axistwin.links.comport import ComPort, Control, Event, ModemState, Purge, SetBreak, SetFlow, SetLines, Suspend
from axistwin.links.plug import Plug
from axistwin.links.tcp import STALLED, TcpClient
from axistwin.links.telnet import escape
from axistwin.sim.frames import LineError
from axistwin.sim.serial_port import Flow, SetFormat

FLOWS = {
    Control.FLOW_NONE: Flow.NONE, Control.FLOW_X_ON_X_OFF: Flow.X_ON_X_OFF, Control.FLOW_HARDWARE: Flow.DTR,
    Control.FLOW_DSR: Flow.DTR,
}  # fmt: skip


class ComPortClient(TcpClient):
    """A client that speaks RFC 2217."""

    linger_s = 0  # Reset DTR and RTS as soon as the client disconnects.
    answers = True

    def __init__(self, plug: Plug, cts: str = "rts") -> None:
        super().__init__(plug)
        self.plug: Plug = plug
        self._dsr = plug.serial.dtr_line
        self._cts = self._dsr if cts == "dtr" else plug.serial.rts_line
        self.flow = Flow.NONE
        self._port = ComPort(plug.default_format, f"axistwin {plug.title}")
        self._moved = ModemState.NONE
        self._suspended: bytearray | None = None
        self._unsubscribe: list[Callable[[], None]] = []

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._port.set_modem_state(dsr=self._dsr.level, cts=self._cts.level)
        self._unsubscribe = [
            self._dsr.subscribe(lambda _: self._line_moved(ModemState.DSR_CHANGED)),
            self._cts.subscribe(lambda _: self._line_moved(ModemState.CTS_CHANGED)),
        ]

    def connection_lost(self, exc: Exception | None) -> None:
        for unsubscribe in self._unsubscribe:
            unsubscribe()
        super().connection_lost(exc)

    # From the client

    def received(self, data: bytes) -> None:
        """Process bytes from the client: commands and data."""
        for event in self._port.receive(data):
            self._obey(event)
        self._reply()

    def _obey(self, event: Event) -> None:
        plug, host = self.plug, self.plug.serial.host
        match event:
            case bytes():
                plug.send(event)
            case SetFormat(fmt):
                plug.change(lambda: setattr(host, "format", fmt))
            case SetLines(dtr, rts):
                plug.change(lambda: self._set_lines(dtr, rts))
            case SetBreak(on):
                plug.change(lambda: plug.set_break(on))
            case SetFlow(outbound):
                self.flow = FLOWS[outbound]
                plug.change(plug.apply_flow)
            case Purge(received, to_transmit):
                if received and self._suspended:
                    self._suspended.clear()
                if to_transmit:
                    plug.change(plug.serial.drop_pending)
            case Suspend(on):
                self._suspend(on)

    def _suspend(self, on: bool) -> None:
        if on and self._suspended is None:
            self._suspended = bytearray()
        elif not on and self._suspended is not None:
            data, self._suspended = bytes(self._suspended), None
            self.write(escape(data))

    def _set_lines(self, dtr: bool, rts: bool) -> None:
        self.plug.serial.host.dtr, self.plug.serial.host.rts = dtr, rts

    # To the client

    def deliver(self, data: bytes, errors: LineError) -> None:
        self._report_lines()
        if errors:
            self._port.set_line_state(errors)
        self._reply()
        if self._suspended is None:
            self.write(escape(data))
        else:
            room = max(0, STALLED - len(self._suspended))
            self._suspended += data[:room]
            self.dropped += len(data[room:])

    def _reply(self) -> None:
        replies = self._port.take_replies()
        if replies and not self._transport.is_closing():
            self.transmit(replies)

    def _line_moved(self, moved: ModemState) -> None:
        self._moved |= moved
        self.plug.request_flush()

    def _report_lines(self) -> None:
        if self._moved and not self.stalled:
            moved, self._moved = self._moved, ModemState.NONE
            self._port.set_modem_state(dsr=self._dsr.level, cts=self._cts.level, moved=moved)
