"""One client at a time: what a connector and a slot have in common.

The first client to come is connected; a later one is refused, unless the one before has hung up.  A client that has
sent so much that it is not read from at the moment cannot be told from one that has gone, and gives way too.

While a run is repeated the place is deaf: its client waits and is told nothing, having heard it all before.
"""

from collections.abc import Callable
from dataclasses import dataclass
from logging import getLogger
from typing import Generic, Protocol, TypeVar

from axistwin.links.pacing import Pacer
from axistwin.sim.pins import Pin

log = getLogger("axistwin.links")


class Guest(Protocol):
    """Somebody at the other end of a transport."""

    name: str

    def hung_up(self) -> bool:
        """Whether it has gone, or cannot be told from one that has; another client may then take its place."""

    def drop(self) -> None:
        """Disconnect it."""

    def pause(self) -> None:
        """Take nothing from it for the moment."""

    def resume(self) -> None:
        """Go on taking what it sends."""


@dataclass(eq=False)
class _Watch:
    """Somebody who watches a line of what is behind the place, and the level that he knows of."""

    pin: Callable[[], Pin]
    watcher: Callable[[Pin], None]
    unwatch: Callable[[], None]
    level: bool = False


G = TypeVar("G", bound=Guest)


class OneClient(Generic[G]):
    """A place for one client.  `name`: the controller's."""

    def __init__(self, name: str, pacer: Pacer) -> None:
        self.name, self.pacer = name, pacer
        self.client: G | None = None
        self._has_refused = False
        self._deaf = self._has_left = False
        self._watches: list[_Watch] = []

    @property
    def full(self) -> bool:
        """Whether nothing is taken from the client for the moment."""
        return self._deaf

    @property
    def chunk(self) -> int:
        """Bytes to be taken from a client at once; others have their turn in between."""
        return 64

    @property
    def who(self) -> str:
        """The client that is connected; "" if there is none."""
        return "" if self.client is None or self._has_left else self.client.name

    def watch(self, pin: Callable[[], Pin], watcher: Callable[[Pin], None]) -> Callable[[], None]:
        """Call `watcher(pin)` at every change of the line that `pin()` finds, also on the bench that comes after this.

        While the place is deaf that waits.  Returns what ends the watching.
        """
        watch = _Watch(pin, watcher, lambda: None)
        self._watches.append(watch)
        self._join(watch)

        def unwatch() -> None:
            self._watches.remove(watch)
            watch.unwatch()

        return unwatch

    def connect(self, client: G) -> bool:
        """Let this client in, if there is no other."""
        if self._deaf:
            self._tell_refused(client, "the run is being repeated")
            return False
        if self.client is not None and self.client is not client:
            if not self.client.hung_up():
                self._tell_refused(client, f"{self.client.name} is connected")
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
        if self.client is client and self._deaf:
            self._has_left = True
        elif self.client is client:
            self.pacer.sync()
            self.client = None
            self.end()
            self.pacer.work()

    def begin(self) -> None:
        """A client has come."""

    def end(self) -> None:
        """The client has gone."""

    def hand_over(self) -> None:
        """Tell the client what there is to tell by now."""

    def _tell_refused(self, client: G, why: str) -> None:
        """Told once for each client that is connected: others may try for ever."""
        if not self._has_refused:
            log.warning("%s: refused %s, as %s", self.name, client.name, why)
        self._has_refused = True

    # While a run is repeated

    @property
    def deaf(self) -> bool:
        """While True the client is not read from and told nothing, and another one is refused."""
        return self._deaf

    @deaf.setter
    def deaf(self, on: bool) -> None:
        if on and not self._deaf:
            self.hand_over()
            for watch in self._watches:
                watch.level = watch.pin().level
            if self.client is not None:
                self.client.pause()
        self._deaf, self._has_refused = on, False

    def make_up(self) -> None:
        """It is not deaf any more: what has been missed is made up for."""
        if self.client is None:
            return
        if self._has_left:
            self._has_left = False
            self.disconnect(self.client)
            return
        for watch in tuple(self._watches):
            if (pin := watch.pin()).level is not watch.level:
                watch.watcher(pin)
        if not self.full:
            self.client.resume()

    def exchanged(self) -> None:
        """Another bench has taken the place of the one before: its lines are watched from now on."""
        for watch in self._watches:
            watch.unwatch()
            self._join(watch)

    def _join(self, watch: _Watch) -> None:
        def changed(pin: Pin) -> None:
            if not self._deaf:
                watch.watcher(pin)

        watch.unwatch = watch.pin().watch(changed)
