"""The serial connector of one controller.  It takes one plug: one client at a time, whatever the transport.

A client finds empty buffers, the usual line format and DTR and RTS on.  What a client that went away has sent is still
transmitted, until the next one comes.

When a run has been repeated up to a moment before the client has asked for something (a format, a control line, a kind
of flow control), it is asked for again.
"""

from collections.abc import Callable
from functools import partial
from typing import Protocol

from axistwin.links.one import Guest, OneClient
from axistwin.links.pacing import BLOCK_S, Pacer
from axistwin.sim.frames import SOUND, LineError
from axistwin.sim.host_acts import HostAct
from axistwin.sim.serial_port import X_OFF, X_ON, Flow, SerialPort
from axistwin.units import to_seconds

FULL = 512
"""With so many characters waiting for the wire a client is not read from, until half of them have left."""
CHUNK = 512
"""Characters taken from a client at once."""
INSTANT_CHUNK = 32
"""The same on a line that takes no time: the controller deals with them in one go, and others wait meanwhile."""
FEW = 64
"""A client is not read from while the bench is behind the wall clock and more than these wait for the wire."""


LASTING = "format", "dtr", "rts", "flow", "hold"
"""What a client asks for and what stays so until it asks for something else."""


class Client(Guest, Protocol):
    """A host at the other end of a transport."""

    flow: Flow | None
    """The flow control it asks for; None: the link's own."""

    def deliver(self, data: bytes, errors: LineError) -> None:
        """Characters from the controller; `errors`: what was found wrong with some of them."""


class Plug(OneClient[Client]):
    """Joins a serial port to the client that is connected.

    `title`: what is at the port.  `reset`: what is done for each new client.
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
        self.usual = self.serial.host.format
        self._dirty = False
        self._errors = SOUND
        self._break_from_ns: int | None = None
        self._unwatch: Callable[[], None] | None = None
        self._asked: dict[str, tuple[int, HostAct]] = {}  # what lasts, when, by kinds of acts
        self._deafen = self.serial.hear(self._heard)
        self._ask(self.settle_flow)

    # Clients come and go

    def begin(self) -> None:
        """A client has come."""
        self._ask(self._clean)
        self.reset()

    def end(self) -> None:
        """The client has gone."""
        self._ask(self._leave)
        self._stop_waiting()

    def _leave(self) -> None:
        self.set_break(False)
        self.serial.host.dtr = self.serial.host.rts = True
        self.settle_flow()

    def _clean(self) -> None:
        self.serial.drop_pending()
        self.serial.read()
        self._errors = SOUND
        self.serial.host.format = self.usual
        self.serial.flow = self._flow

    # From the client

    @property
    def full(self) -> bool:
        """Whether it takes no more characters for the moment."""
        return self._deaf or self._unwatch is not None

    @property
    def chunk(self) -> int:
        """Characters to be taken from a client at once."""
        return INSTANT_CHUNK if self.serial.instant else CHUNK

    @property
    def _behind(self) -> bool:
        """True while the bench cannot keep pace with what has been sent."""
        return self.pacer.behind_s > BLOCK_S and self.serial.pending > FEW

    def send(self, data: bytes) -> None:
        """Characters from the client."""
        self.pacer.sync()
        self.serial.write(data)
        self.pacer.work()
        if (self.serial.pending > FULL or self._behind) and not self.full and self.client is not None:
            self.client.pause()
            self._unwatch = self.pacer.watch(self._resume_when_emptier)

    def change(self, change: Callable[[], object]) -> None:
        """Something else from the client: a format, a control line."""
        self.pacer.sync()
        self._ask(change)
        self.pacer.work()

    def set_break(self, on: bool) -> None:
        """The client begins or ends a break.

        How long it is is known at its end only, so that is when the line goes to space, for as long as the client has
        waited but at least two characters.  Meanwhile nothing is sent.
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
            self._stop_waiting()
            if self.client is not None and not self._deaf:
                self.client.resume()

    def _stop_waiting(self) -> None:
        if self._unwatch is not None:
            self._unwatch()
            self._unwatch = None

    # From the controller

    def mark(self) -> None:
        """There is something to tell the client once the bench has been advanced."""
        if not self._dirty:
            self._dirty = True
            self.pacer.mark(self)

    def flush(self) -> None:
        """Hand over what has come.  Without a client it is lost, as with nobody at the other end of the cable."""
        self._dirty = False
        data, errors, self._errors = self.serial.read(), self._errors, SOUND
        if self.client is None or self._deaf:
            return
        if (X_ON in data or X_OFF in data) and self.serial.flow is Flow.X_ON_X_OFF:
            data = data.translate(None, bytes((X_ON, X_OFF)))
        self.client.deliver(data, errors)

    def _heard(self, _: int, errors: LineError) -> None:
        self.mark()
        if errors:
            self._errors |= errors

    def hand_over(self) -> None:
        """Tell the client what there is to tell by now."""
        if self._dirty:
            self.flush()

    # What the client has asked for, on another bench

    def exchange(self, serial: SerialPort) -> None:
        """This port takes the place of the one before.  It is left as it is."""
        self._deafen()
        self.serial = serial
        self._deafen = serial.hear(self._heard)
        self.exchanged()

    def make_up(self) -> None:
        """It is not deaf any more: what has been missed is made up for."""
        self.pacer.sync()
        now_ns = self.pacer.clock.now
        for asked_ns, act in tuple(self._asked.values()):
            if asked_ns > now_ns:  # it has not been on this bench
                self._ask(partial(self.serial.perform, act))
        super().make_up()

    def _ask(self, change: Callable[[], object]) -> None:
        """Do something for the client, and remember what of it lasts."""
        unwatch = self.serial.watch_host(self._remember)
        try:
            change()
        finally:
            unwatch()

    def _remember(self, act: HostAct) -> None:
        if act.kind in LASTING:
            self._asked[act.kind] = self.pacer.clock.now, act

    # Flow control: "The controller should therefore interrupt data transmission if this signal becomes reset"

    @property
    def _flow(self) -> Flow:
        wanted = None if self.client is None else self.client.flow
        return self.flow if wanted is None else wanted

    def settle_flow(self) -> None:
        """The host's flow control is what its client asks for."""
        if self.serial.flow is not self._flow:
            self.serial.flow = self._flow
