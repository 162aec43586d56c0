"""What a person does at a machine, reported to those who record it.

What the bench does by itself (the script of a scene, a fault) is not reported: it happens again without them.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from axistwin.sim.clock import Clock

Watcher = Callable[..., object]


@contextmanager
def by_itself(clock: Clock) -> Iterator[None]:
    """What is done to machines meanwhile, the bench does by itself."""
    within, clock.by_itself = clock.by_itself, True
    try:
        yield
    finally:
        clock.by_itself = within


class ByHand:
    """Reports what a person does at one thing: the name of the act, and its values."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._watchers: list[Watcher] = []

    def watch(self, watcher: Watcher) -> Callable[[], None]:
        """Call `watcher(act, *values)` before each act.  Returns what ends the watching."""
        self._watchers.append(watcher)
        return lambda: self._watchers.remove(watcher)

    def tell(self, act: str, *values: Any) -> None:
        """A person does this now, unless the bench does it by itself."""
        if not self._clock.by_itself:
            for watcher in tuple(self._watchers):
                watcher(act, *values)
