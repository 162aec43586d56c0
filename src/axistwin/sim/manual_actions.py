"""Reports of manual actions at a machine, for recordings: power on or off, a pushed shaft, a moved joystick.

Actions of the bench itself (by a scene's script or a fault) are not reported, because every run repeats them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.core.numbers import check_values, shortened
from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal

MOST_COUNTS = 1 << 53  # Maximum displacement in one action, in pulses or counts.
MOST_TORQUE = 1000.0  # Maximum external torque on a shaft, in N·m.


def check_counts(counts: object, action: str) -> None:
    """Raise UsageError unless `counts` is a whole number in the permitted range."""
    if type(counts) is not int:
        raise UsageError(f"invalid number of counts in {action}({counts!r}): expected a whole number, e.g. 4000")
    if abs(counts) > MOST_COUNTS:
        raise UsageError(
            f"invalid number of counts in {action}({shortened(str(counts))}): expected {-MOST_COUNTS} to {MOST_COUNTS}"
        )


def check_torque(newton_metres: float) -> None:
    """Raise UsageError if a torque is outside the permitted range."""
    check_values(newton_metres)
    if not -MOST_TORQUE <= newton_metres <= MOST_TORQUE:
        raise UsageError(f"invalid torque {newton_metres} N·m: expected -1000 to 1000 N·m")


@contextmanager
def by_itself(clock: Clock) -> Iterator[None]:
    """Attribute all actions at machines to the bench itself, so that they are not reported."""
    within, clock.by_itself = clock.by_itself, True
    try:
        yield
    finally:
        clock.by_itself = within


class ManualAct(StrEnum):
    """Kinds of manual actions at a machine.  Conversations and recordings contain the same names."""

    POWER = "power"
    JOYSTICK = "joystick"
    PUSH = "push"
    LOAD = "load"
    JAM = "jam"
    AMBIENT = "ambient"
    MASTER = "master"


class ManualActions(Signal[...]):
    """Emits each manual action at one machine part before it happens: the kind of action and its values."""

    def __init__(self, clock: Clock) -> None:
        super().__init__()
        self._clock = clock

    def report(self, act: ManualAct, *values: Any) -> None:
        """Report an action, unless the bench itself performs the action."""
        if not self._clock.by_itself:
            self.emit(act, *values)
