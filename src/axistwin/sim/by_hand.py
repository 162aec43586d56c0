"""Actions of a person at a machine, reported so that they can be recorded.

Actions of the bench itself (a scene's script, a fault) are not reported: they happen again in every run.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal


@contextmanager
def by_itself(clock: Clock) -> Iterator[None]:
    """Attribute all actions at machines to the bench itself, so that they are not reported."""
    within, clock.by_itself = clock.by_itself, True
    try:
        yield
    finally:
        clock.by_itself = within


class ByHand:
    """Reports the actions of a person at one machine part: the name of the action and its values."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._begins: Signal[...] = Signal()

    def subscribe(self, callback: Callable[..., object]) -> Callable[[], None]:
        """Call `callback(act, *values)` before each action.  Return an unsubscribe function."""
        return self._begins.subscribe(callback)

    def tell(self, act: str, *values: float) -> None:
        """Report an action, unless the bench itself performs it."""
        if not self._clock.by_itself:
            self._begins.emit(act, *values)
