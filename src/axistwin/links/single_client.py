"""An endpoint for one client at a time: the base of a serial plug and a bus slot.

The first client is connected.  A later client is refused, unless the present client has hung up.  While a client that
has sent too much is not read, its disconnection is not noticed.  A later client then replaces it.

While the gate of an endpoint is closed, nothing is read from its client, and new clients are refused.
"""

from logging import getLogger
from typing import Generic, Protocol, TypeVar

from axistwin.links.pacing import Pacer
from axistwin.sim.signal import Signal

log = getLogger("axistwin.links")


class Client(Protocol):
    """The connection of one host program to a serial port or a bus of a controller."""

    name: str

    def hung_up(self) -> bool:
        """True if this client has disconnected, or may have, so that another client may replace it."""

    def drop(self) -> None: ...

    def pause(self) -> None: ...

    def resume(self) -> None: ...


class Gate:
    """Controls whether clients may connect and send data."""

    def __init__(self) -> None:
        self.reason = ""  # Reason why the gate is closed; "" while it is open.
        self.changes: Signal[[]] = Signal()  # Event: the gate has been opened or closed.
        self.admitted: Signal[[]] = Signal()  # Event: a client has been connected.

    @property
    def closed(self) -> bool:
        return self.reason != ""

    def close(self, reason: str) -> None:
        """Send pending output, stop reading from clients, and refuse new clients.  An empty reason opens the gate."""
        if reason != self.reason:
            self.reason = reason
            self.changes.emit()

    def open(self) -> None:
        self.close("")


G = TypeVar("G", bound=Client)


class SingleClient(Generic[G]):
    """An endpoint for one client.  `name`: the name of the controller."""

    def __init__(self, name: str, pacer: Pacer, gate: Gate | None = None) -> None:
        self.name, self.pacer, self.gate = name, pacer, gate or Gate()
        self.client: G | None = None
        self.heard_ns = -1  # Virtual time at which a client has last sent data, in ns; -1 if none has.
        self._has_refused = False
        self._has_disconnected = False  # True if the client has left while the gate was closed and nobody could send.
        self.gate.changes.subscribe(self._gate_changed)

    @property
    def full(self) -> bool:
        """True while the endpoint reads nothing from the client, because the gate is closed."""
        return self.gate.closed

    @property
    def refuses_because(self) -> str:
        """Reason why no client can connect; "" if a client can."""
        return self.gate.reason

    @property
    def chunk(self) -> int:
        """Largest number of bytes read from a client at once; then other clients are served."""
        return 64

    @property
    def client_name(self) -> str:
        return "" if self.client is None or self._has_disconnected else self.client.name

    def connect(self, client: G) -> bool:
        """Connect a client; return False while the gate is closed or another client is connected."""
        if self.refuses_because:
            self._warn_refused(client, self.refuses_because)
            return False
        if self.client is not None and self.client is not client:
            if not self.client.hung_up():
                self._warn_refused(client, f"{self.client.name} is connected")
                return False
            self.client.drop()
            self.disconnect(self.client)
        self.pacer.sync()
        self.client, self._has_refused = client, False
        self.begin()
        self.pacer.work()
        self.gate.admitted.emit()
        return True

    def disconnect(self, client: G) -> None:
        if self.client is client and self.gate.closed:
            self._has_disconnected = True
        elif self.client is client:
            self.pacer.sync()
            self.client = None
            self.end()
            self.pacer.work()

    def begin(self) -> None: ...

    def end(self) -> None: ...

    def flush_pending(self) -> None: ...

    def _warn_refused(self, client: G, why: str) -> None:
        """Log a refused client; no further one until a client connects or the gate opens or closes."""
        if not self._has_refused:
            log.warning("%s: refused %s, as %s", self.name, client.name, why)
        self._has_refused = True

    def _gate_changed(self) -> None:
        self._has_refused = False
        if self.gate.closed:
            self.flush_pending()
        if self.client is None:
            return
        if self.gate.closed:
            self.client.pause()
        elif self._has_disconnected:
            self._has_disconnected = False
            self.disconnect(self.client)
        elif not self.full:
            self.client.resume()
