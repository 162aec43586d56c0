"""Actions of a host at its end of a line or at its registers, reported so that they can be repeated.

One action may cause others: a character triggers a fault that sets the host's baud rate, or a status change makes a
host read a register.  An action that another one causes immediately is not reported: repeating the first repeats both.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal

V = TypeVar("V")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class HostAct:
    """One action of a host with its `value`.  The kinds depend on the kind of port."""

    kind: str
    value: Any = None


@contextmanager
def one_act(clock: Clock) -> Iterator[bool]:
    """Combine all actions of hosts, at any port, into one action; inner actions are not reported.

    Yield True if this action is not itself inside another one.
    """
    within, clock.acting = clock.acting, True
    try:
        yield not within
    finally:
        clock.acting = within


class HostActs:
    """Performs and reports the actions of a host at one port."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._begins: Signal[HostAct] = Signal()

    def subscribe(self, callback: Callable[[HostAct], None]) -> Callable[[], None]:
        """Call `callback(act)` before each action.  Return an unsubscribe function."""
        return self._begins.subscribe(callback)

    def __call__(self, kind: str, value: V, action: Callable[[V], T]) -> T:
        """Report the action, then perform it: `action(value)`."""
        if not self._begins:
            return action(value)
        with one_act(self._clock) as outermost:
            if outermost:
                self._begins.emit(HostAct(kind, value))
            return action(value)
