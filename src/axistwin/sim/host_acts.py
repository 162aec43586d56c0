"""What a host does at its end of a line or at its registers, told to those who want to do the same again.

An act brings others about: a fault that waits for a character sets the host's baud rate, somebody attends to a status
that has changed.  If that happens at once, within the act, it is not told: it happens again when the act is repeated.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

from axistwin.sim.clock import Clock

V = TypeVar("V")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class HostAct:
    """One thing that a host does; `value`: with what.  Each kind of port says which kinds there are."""

    kind: str
    value: Any = None


@contextmanager
def one_act(clock: Clock) -> Iterator[bool]:
    """What hosts do meanwhile, at any port, is part of one act and is not told.

    Yields whether this act is itself part of no other.
    """
    within, clock.acting = clock.acting, True
    try:
        yield not within
    finally:
        clock.acting = within


class HostActs:
    """Whoever is told of what a host does at one port."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._watchers: list[Callable[[HostAct], None]] = []

    def watch(self, watcher: Callable[[HostAct], None]) -> Callable[[], None]:
        """Call `watcher(act)` before each.  Returns what ends the watching."""
        self._watchers.append(watcher)
        return lambda: self._watchers.remove(watcher)

    def __call__(self, kind: str, value: V, action: Callable[[V], T]) -> T:
        """Do it: `action(value)`, after it has been told."""
        if not self._watchers:
            return action(value)
        with one_act(self._clock) as outermost:
            for watcher in tuple(self._watchers) if outermost else ():
                watcher(HostAct(kind, value))
            return action(value)
