"""Sentences that tell the user how to set a terminal, how to end a fault, and how to switch the power."""

from axistwin.bench import Controller
from axistwin.plant.axes import Axis

MARGIN = 100
"""Distance from a limit switch at which a suggested move ends."""


class Remedies:
    """Lines to type in a terminal.  The panel has a subclass that names its buttons and switches."""

    def drive(self, pin: str, level: str) -> str:
        """Return how to give an input a level on a bench where nothing is connected to the input."""
        return f"type  :drive {pin} {level}"

    def release(self, pin: str) -> str:
        """Return how to remove the level that the user has forced."""
        return f"type  :drive {pin} release"

    def mend(self, pin: str) -> str:
        """Return how to end the fault that holds a terminal."""
        return f"an injected fault holds {pin}: it lasts until its end, or until  ! mend all  in a program"

    def power(self, *words: str) -> str:
        """Return how to switch the power on, or off and on."""
        return "type  " + "  and  ".join(f":drive power {word}" for word in words)


def at_limit(controller: Controller, plus: bool) -> tuple[str, Axis, int] | None:
    """Return the axis that stands on a limit switch, and its distance to a place `MARGIN` from this switch.

    None if no axis stands on the switch.
    """
    for name, axis in controller.axes.items():
        if axis.limits is None:
            continue
        first, last = axis.limits
        margin = min(MARGIN, (last - first) // 2)
        if plus and axis.position > last:
            return name, axis, last - margin - axis.position
        if not plus and axis.position < first:
            return name, axis, first + margin - axis.position
    return None
