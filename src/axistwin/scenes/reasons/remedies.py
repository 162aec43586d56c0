"""Sentences that tell the user how to set a terminal, how to end a fault, and how to switch the power."""

from axistwin.bench import Controller
from axistwin.plant.axes import Axis
from axistwin.scenes.tables import ButtonTable, OperatorTable

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


class ByHand(Remedies):
    """Instructions to a person at the machine, who has its operator panel and its switches: `press Start`."""

    def __init__(self, operator: OperatorTable, name: str) -> None:
        self._operator, self._name = operator, name

    def drive(self, pin: str, level: str) -> str:
        button = self._button(pin)
        if button is not None:
            return f"press {button.name}" if button.pressed == level else f"release {button.name}"
        for selector in self._operator.selector:
            for word, selected in selector.positions.items():
                if selected == f"{self._name}.{pin}" and selector.selected == level:
                    return f"turn {selector.name} to {word}"
        return f"click the switch {pin}"

    def release(self, pin: str) -> str:
        button = self._button(pin)
        if button is None:
            return f"click the switch {pin} again"
        return f"press {button.name} again" if button.latching else f"release {button.name}"

    def mend(self, pin: str) -> str:
        return f"a fault holds {pin}: press mend in the list of faults"

    def address(self, number: int) -> str:
        return f"type  \\x{0x80 + number:02x}"

    def power(self, *words: str) -> str:
        """Return `switch the power off (button power)`; `words`: "off", "on" or both, in this order."""
        return f"switch the power {' and '.join(words)} (button power)"

    def _button(self, pin: str) -> ButtonTable | None:
        return next((each for each in self._operator.button if each.pin in (pin, f"{self._name}.{pin}")), None)
