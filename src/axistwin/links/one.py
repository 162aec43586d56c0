"""One client at a time: what a connector and a slot have in common.

The first client to come is connected; a later one is refused, unless the one before has hung up.  A client that has
sent so much that it is not read from at the moment cannot be told from one that has gone, and gives way too.
"""

from logging import getLogger
from typing import Generic, Protocol, TypeVar

from axistwin.links.pacing import Pacer

log = getLogger("axistwin.links")


class Guest(Protocol):
    """Somebody at the other end of a transport."""

    name: str

    def hung_up(self) -> bool:
        """Whether it has gone, or cannot be told from one that has; another client may then take its place."""

    def drop(self) -> None:
        """Disconnect it."""


G = TypeVar("G", bound=Guest)


class OneClient(Generic[G]):
    """A place for one client.  `name`: the controller's."""

    def __init__(self, name: str, pacer: Pacer) -> None:
        self.name, self.pacer = name, pacer
        self.client: G | None = None
        self._has_refused = False

    @property
    def full(self) -> bool:
        """Whether nothing is taken from the client for the moment."""
        return False

    def connect(self, client: G) -> bool:
        """Let this client in, if there is no other."""
        if self.client is not None and self.client is not client:
            if not self.client.hung_up():
                self._tell_refused(client, self.client)
                return False
            self.client.drop()
            self.disconnect(self.client)
        self.pacer.sync()
        self.client, self._has_refused = client, False
        self.begin()
        self.pacer.work()
        return True

    def disconnect(self, client: G) -> None:
        """This client has gone."""
        if self.client is client:
            self.pacer.sync()
            self.client = None
            self.end()
            self.pacer.work()

    def begin(self) -> None:
        """A client has come."""

    def end(self) -> None:
        """The client has gone."""

    def _tell_refused(self, client: G, connected: G) -> None:
        """Told once for each client that is connected: others may try for ever."""
        if not self._has_refused:
            log.warning("%s: refused %s, as %s is connected", self.name, client.name, connected.name)
        self._has_refused = True
