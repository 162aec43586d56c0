"""What a person does at a machine, reported to those who record it.

What the bench does by itself (the script of a scene, a fault) is not reported: it happens again without them.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from axistwin.errors import UsageError
from axistwin.numbers import shortened
from axistwin.sim.clock import Clock

MOST_COUNTS = 1 << 53
"""Pulses or counts that a person moves something by."""
MOST_TORQUE = 1000.0
"""N·m on a shaft from outside."""
Watcher = Callable[..., object]


def check_counts(counts: object, act: str) -> None:
    """Raises UsageError if a person cannot move anything by so many counts."""
    if type(counts) is not int:
        raise UsageError(f"{act}({counts!r}): give a whole number of counts")
    if abs(counts) > MOST_COUNTS:
        raise UsageError(f"{act}({shortened(str(counts))}): expected {-MOST_COUNTS} to {MOST_COUNTS} counts, e.g. 4000")


def check_torque(newton_metres: float) -> None:
    """Raises UsageError if a person cannot load a shaft like that."""
    if not -MOST_TORQUE <= newton_metres <= MOST_TORQUE:
        raise UsageError(f"a torque of {newton_metres} N·m: give a number from -1000 to 1000")


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
