"""The serial connector of one controller: one client at a time, over any transport.

A new client finds empty buffers, the default line format, and DTR and RTS on.  Characters of the last client are still
transmitted until the next client connects.

A replay may end before the time at which the client has set a format, a control line or flow control.  The plug then
sets them again.
"""

from collections.abc import Callable
from functools import partial
from typing import Protocol

from axistwin.links.pacing import BLOCK_S, Pacer
from axistwin.links.single_client import Client, SingleClient
from axistwin.sim.frames import SOUND, LineError
from axistwin.sim.host_acts import HostAct
from axistwin.sim.serial_port import X_OFF, X_ON, Flow, SerialPort
from axistwin.units import to_seconds

FULL = 512
"""With more characters waiting for the wire, nothing is read from the client until half of them are sent."""
CHUNK = 512
"""Largest number of characters read from a client at once."""
INSTANT_CHUNK = 32
"""The same on an instant line, where the controller processes a chunk at once while other clients wait."""
FEW = 64
"""While the bench is behind the wall clock, nothing is read from a client with more characters waiting."""


LASTING_ACTS = "format", "dtr", "rts", "flow", "hold"
"""Kinds of host acts that set a lasting state of the line."""


class SerialClient(Client, Protocol):
    """A host with a serial port, at the other end of a transport."""

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
        serial: SerialPort,
        pacer: Pacer,
        *,
        title: str = "",
        flow: Flow = Flow.DTR,
        reset: Callable[[], object] = lambda: None,
    ) -> None:
        super().__init__(name, pacer)
        self.serial, self.title = serial, title or name
        self.flow, self.reset = flow, reset
        self.default_format = self.serial.host.format
        self._flush_requested = False
        self._errors = SOUND
        self._break_from_ns: int | None = None
        self._stop_observing: Callable[[], None] | None = None
        self._settings: dict[str, tuple[int, HostAct]] = {}  # the last lasting act of each kind, with its time
        self._unsubscribe_received = self.serial.subscribe_received(self._received)
        self._apply(self.apply_flow)

    # Connecting and disconnecting

    def begin(self) -> None:
        """Prepare the port for a new client."""
        self._apply(self._clean)
        self.reset()

    def end(self) -> None:
        """Restore the line after the client has disconnected."""
        self._apply(self._leave)
        self._end_pause()

    def _leave(self) -> None:
        self.set_break(False)
        self.serial.host.dtr = self.serial.host.rts = True
        self.apply_flow()

    def _clean(self) -> None:
        self.serial.drop_pending()
        self.serial.read()
        self._errors = SOUND
        self.serial.host.format = self.default_format
        self.serial.flow = self._flow

    # From the client

    @property
    def full(self) -> bool:
        """True while nothing is read from the client."""
        return self._muted or self._stop_observing is not None

    @property
    def chunk(self) -> int:
        """Largest number of characters read from the client at once."""
        return INSTANT_CHUNK if self.serial.instant else CHUNK

    @property
    def _behind(self) -> bool:
        """True while the bench is too slow for the characters that have been sent."""
        return self.pacer.behind_s > BLOCK_S and self.serial.pending > FEW

    def send(self, data: bytes) -> None:
        """Transmit characters from the client."""
        self.pacer.sync()
        self.serial.write(data)
        self.pacer.work()
        if (self.serial.pending > FULL or self._behind) and not self.full and self.client is not None:
            self.client.pause()
            self._stop_observing = self.pacer.subscribe(self._resume_when_emptier)

    def change(self, change: Callable[[], object]) -> None:
        """Apply another act of the client: a line format, a control line."""
        self.pacer.sync()
        self._apply(change)
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
            if self.client is not None and not self._muted:
                self.client.resume()

    def _end_pause(self) -> None:
        if self._stop_observing is not None:
            self._stop_observing()
            self._stop_observing = None

    # From the controller

    def request_flush(self) -> None:
        """Request a flush after the bench has been advanced."""
        if not self._flush_requested:
            self._flush_requested = True
            self.pacer.request_flush(self)

    def flush(self) -> None:
        """Send received characters to the client.  Without a client they are lost, as on an open cable."""
        self._flush_requested = False
        data, errors, self._errors = self.serial.read(), self._errors, SOUND
        if self.client is None or self._muted:
            return
        if (X_ON in data or X_OFF in data) and self.serial.flow is Flow.X_ON_X_OFF:
            data = data.translate(None, bytes((X_ON, X_OFF)))
        self.client.deliver(data, errors)

    def _received(self, _: int, errors: LineError) -> None:
        self.request_flush()
        if errors:
            self._errors |= errors

    def flush_pending(self) -> None:
        """Flush pending output to the client."""
        if self._flush_requested:
            self.flush()

    # Replaying a run

    def replace_port(self, serial: SerialPort) -> None:
        """Connect the client to another port, without changing that port."""
        self._unsubscribe_received()
        self.serial = serial
        self._unsubscribe_received = serial.subscribe_received(self._received)
        self.resubscribe()

    def catch_up(self) -> None:
        """Set again what the client has set after the present time, and update the client."""
        self.pacer.sync()
        now_ns = self.pacer.clock.now
        for set_ns, act in tuple(self._settings.values()):
            if set_ns > now_ns:  # not yet set on this bench
                self._apply(partial(self.serial.perform, act))
        super().catch_up()

    def _apply(self, change: Callable[[], object]) -> None:
        """Perform an act of the client, and store its lasting settings."""
        unwatch = self.serial.watch_host(self._store_setting)
        try:
            change()
        finally:
            unwatch()

    def _store_setting(self, act: HostAct) -> None:
        if act.kind in LASTING_ACTS:
            self._settings[act.kind] = self.pacer.clock.now, act

    # Flow control: "The controller should therefore interrupt data transmission if this signal becomes reset"

    @property
    def _flow(self) -> Flow:
        wanted = None if self.client is None else self.client.flow
        return self.flow if wanted is None else wanted

    def apply_flow(self) -> None:
        """Give the host's end the flow control that the client has chosen."""
        if self.serial.flow is not self._flow:
            self.serial.flow = self._flow
