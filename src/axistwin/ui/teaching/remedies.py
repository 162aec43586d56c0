"""Sentences that tell the user how to set a terminal, how to end a fault, and how to switch the power."""

from axistwin.bench import Controller
from axistwin.plant.axes import Axis

MARGIN = 100  # Distance from a limit switch at which a suggested move ends.


class Remedies:
    """Instructions that tell the user how to set inputs, end faults and switch the power.

    The instructions contain the lines to type in a terminal.  The panel has a subclass that names the buttons and
    switches of the panel.
    """

    def drive(self, pin: str, level: str) -> str:
        """Return how to force a level, e.g. "type :drive dsr high"; `pin`: an input without a machine."""
        return f"type  :drive {pin} {level}"

    def release(self, pin: str) -> str:
        """Return a text that tells the user how to end a forced input level, e.g. "type  :drive dsr release"."""
        return f"type  :drive {pin} release"

    def mend(self, pin: str) -> str:
        return f"an injected fault holds {pin}: type  :drive mend all"

    def power(self, *words: str) -> str:
        """Return the request to switch the controller; `words`: "off", "on", or both, in this sequence."""
        return "type  " + "  and  ".join(f":drive power {word}" for word in words)

    def address(self, number: int) -> str:  # noqa: ARG002  # the panel uses it
        """Return how to address a SmartMotor: a power cycle, because no address byte can be typed in a terminal."""
        return self.power("off", "on")


def at_limit(controller: Controller, plus: bool) -> tuple[str, Axis, int] | None:
    """Return an axis that is on a limit switch, and the move back to `MARGIN` inside; None if none is on one."""
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
