"""An endpoint for one client at a time: the base of a serial plug and a bus slot.

The first client is connected.  A later client is refused, unless the present client has hung up.  A client that is
not being read from, because it has sent too much, may have hung up unnoticed; a later client replaces it.

While a recorded run is replayed the endpoint is muted: nothing is read from its client or sent to it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from logging import getLogger
from typing import Generic, Protocol, TypeVar

from axistwin.links.pacing import Pacer
from axistwin.sim.pins import Pin

log = getLogger("axistwin.links")


class Client(Protocol):
    """A client at the other end of a transport."""

    name: str

    def hung_up(self) -> bool:
        """True if the client has disconnected, or may have; another client may then replace it."""

    def drop(self) -> None:
        """Disconnect the client."""

    def pause(self) -> None:
        """Stop reading from the client."""

    def resume(self) -> None:
        """Continue reading from the client."""


@dataclass(eq=False)
class _Subscription:
    """An observer of a device line, and the last level that was reported to the observer."""

    pin: Callable[[], Pin]
    observer: Callable[[Pin], None]
    unsubscribe: Callable[[], None]
    level: bool = False


G = TypeVar("G", bound=Client)


class SingleClient(Generic[G]):
    """An endpoint for one client.  `name`: the name of the controller."""

    def __init__(self, name: str, pacer: Pacer) -> None:
        self.name, self.pacer = name, pacer
        self.client: G | None = None
        self._has_refused = False
        self._muted = self._has_disconnected = False
        self._subscriptions: list[_Subscription] = []

    @property
    def full(self) -> bool:
        """True while nothing is read from the client."""
        return self._muted

    @property
    def chunk(self) -> int:
        """Largest number of bytes read from a client at once; other clients are served in between."""
        return 64

    @property
    def client_name(self) -> str:
        """Name of the connected client; "" without one."""
        return "" if self.client is None or self._has_disconnected else self.client.name

    def subscribe(self, pin: Callable[[], Pin], observer: Callable[[Pin], None]) -> Callable[[], None]:
        """Call `observer(pin)` at every change of the line `pin()`, also after the bench has been replaced.

        While the endpoint is muted, changes are held back.  Returns an unsubscribe function.
        """
        subscription = _Subscription(pin, observer, lambda: None)
        self._subscriptions.append(subscription)
        self._observe(subscription)

        def unsubscribe() -> None:
            self._subscriptions.remove(subscription)
            subscription.unsubscribe()

        return unsubscribe

    def connect(self, client: G) -> bool:
        """Connect this client, unless another client is connected.  Returns True if the client is connected."""
        if self._muted:
            self._warn_refused(client, "the run is being repeated")
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
        return True

    def disconnect(self, client: G) -> None:
        """Release the endpoint after this client has disconnected."""
        if self.client is client and self._muted:
            self._has_disconnected = True
        elif self.client is client:
            self.pacer.sync()
            self.client = None
            self.end()
            self.pacer.work()

    def begin(self) -> None:
        """Prepare the device for a new client."""

    def end(self) -> None:
        """Restore the device after a client has disconnected."""

    def flush_pending(self) -> None:
        """Flush pending output to the client."""

    def _warn_refused(self, client: G, why: str) -> None:
        """Log a refusal, once per connected client: a refused client may try again and again."""
        if not self._has_refused:
            log.warning("%s: refused %s, as %s", self.name, client.name, why)
        self._has_refused = True

    # Replaying a run

    @property
    def muted(self) -> bool:
        """True while nothing is read from the client or sent to it, and new clients are refused."""
        return self._muted

    @muted.setter
    def muted(self, on: bool) -> None:
        if on and not self._muted:
            self.flush_pending()
            for subscription in self._subscriptions:
                subscription.level = subscription.pin().level
            if self.client is not None:
                self.client.pause()
        self._muted, self._has_refused = on, False

    def catch_up(self) -> None:
        """Update the client, after unmuting, with what has changed meanwhile."""
        if self.client is None:
            return
        if self._has_disconnected:
            self._has_disconnected = False
            self.disconnect(self.client)
            return
        for subscription in tuple(self._subscriptions):
            if (pin := subscription.pin()).level is not subscription.level:
                subscription.observer(pin)
        if not self.full:
            self.client.resume()

    def resubscribe(self) -> None:
        """Observe the lines of the bench that has replaced the last one."""
        for subscription in self._subscriptions:
            subscription.unsubscribe()
            self._observe(subscription)

    def _observe(self, subscription: _Subscription) -> None:
        def changed(pin: Pin) -> None:
            if not self._muted:
                subscription.observer(pin)

        subscription.unsubscribe = subscription.pin().subscribe(changed)
