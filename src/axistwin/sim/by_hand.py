"""Actions of a person at a machine, reported so that they can be recorded.

Actions of the bench itself (a scene's script, a fault) are not reported: they happen again in every run.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from axistwin.errors import UsageError
from axistwin.numbers import shortened
from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal

MOST_COUNTS = 1 << 53
"""Maximum displacement in one action, in pulses or counts."""
MOST_TORQUE = 1000.0
"""Maximum external torque on a shaft, in N·m."""


def check_counts(counts: object, act: str) -> None:
    """Raises UsageError if a person cannot move a part by this number of counts."""
    if type(counts) is not int:
        raise UsageError(f"{act}({counts!r}): give a whole number of counts")
    if abs(counts) > MOST_COUNTS:
        raise UsageError(f"{act}({shortened(str(counts))}): expected {-MOST_COUNTS} to {MOST_COUNTS} counts, e.g. 4000")


def check_torque(newton_metres: float) -> None:
    """Raises UsageError if a person cannot apply this torque to a shaft."""
    if not -MOST_TORQUE <= newton_metres <= MOST_TORQUE:
        raise UsageError(f"a torque of {newton_metres} N·m: give a number from -1000 to 1000")


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

    def report(self, act: str, *values: Any) -> None:
        """Report an action, unless the bench itself performs it."""
        if not self._clock.by_itself:
            self._begins.emit(act, *values)
