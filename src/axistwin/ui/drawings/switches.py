"""Drawing of the switches and lamps at the terminals of a controller; a click presses or releases a switch."""

import re
from collections.abc import Callable, Iterator
from html import escape

from axistwin.bench import Controller
from axistwin.controllers.front import Lamp, Tone
from axistwin.sim.pins import Pin, SensedPin
from axistwin.ui.drawings.drawing import Drawing

Press = Callable[[str, str], None]
"""Function that performs an action at a terminal: its arguments are the terminal, and `high`, `low` or `release`."""
LAMPS = re.compile(r"output\d|led")


class Switches:
    """The drawing of switches and lamps, without the limit and home switches that an axis shows."""

    def __init__(self, controller: Controller, press: Press) -> None:
        self._lamps = {lamp.source: lamp for group in controller.product.front for lamp in group.items
                       if isinstance(lamp, Lamp) and lamp.source in controller.pins}  # fmt: skip
        elsewhere = {*on_slides(controller)}
        self.inputs = [name for name in self._inputs(controller) if name not in elsewhere]
        self.outputs = [name for name, pin in controller.pins.items() if pin.is_output and LAMPS.match(name)]
        self._name = controller.name
        self.drawing = Drawing(
            f"switches {controller.name}", "switchboard", self._art(), lambda name: press(name, action(self._pin(name)))
        )
        self._pins = controller.pins

    def show(self, controller: Controller) -> None:
        drawing, self._pins = self.drawing, controller.pins
        for name in self.inputs:
            show_switch(drawing, f"switch-{name}", self._pin(name))
        for name in self.outputs:
            level = self._pin(name).level
            lamp = self._lamps.get(name)
            on = controller.powered and (level if lamp is None else level is lamp.lit)
            drawing.flag(f"lamp-{name}", "lit", on)
            drawing.put(f"lamp-{name}", "aria-label", f"{self._title(name)}: {'on' if on else 'off'}")
            drawing.write(f"lamp-{name}-level", "high" if level else "low")

    def _pin(self, name: str) -> Pin:
        return self._pins[name]

    def _inputs(self, controller: Controller) -> Iterator[str]:
        """Yield the inputs of the front panel, and the home input; sensors and the joystick set their own levels.

        Without a description of the front panel, all inputs.
        """
        stick, homes = controller.product.joystick, controller.product.home_pins.values()
        for name, pin in controller.pins.items():
            shown = name in self._lamps or name in homes or not controller.product.front
            own = isinstance(pin, SensedPin) or (stick is not None and name == stick.at_zero)
            if shown and pin.drivable and not own:
                yield name

    def _title(self, name: str) -> str:
        lamp = self._lamps.get(name)
        if lamp is not None and not name.startswith("output"):
            return lamp.name
        return re.sub(r"(?<=[a-z])(?=\d)", " ", name.replace("_", " "))

    def _art(self) -> str:
        rows = ("".join(map(self._switch, self.inputs)), "".join(map(self._lamp, self.outputs)))
        return "".join(f"<div>{row}</div>" for row in rows if row)

    def _switch(self, name: str) -> str:
        part, level = f"switch-{name}", f'<small data-part="switch-{name}-level"></small>'
        act = f'data-act="{name}" data-part="{part}" aria-pressed="false" title="{escape(self._tip(name))}"'
        words = f'<b>{escape(self._title(name))}</b> <span data-part="{part}-word">free</span> {level}'
        return f'<button type="button" class="push" {act}>{_PUSH}{words}</button>'

    def _lamp(self, name: str) -> str:
        part, tone = f"lamp-{name}", self._lamps[name].tone if name in self._lamps else Tone.PLAIN
        words = f'<b>{escape(self._title(name))}</b><small data-part="{part}-level"></small>'
        role = f'role="img" data-part="{part}" title="{escape(self._tip(name))}"'
        return f'<div class="bulb bulb-{tone.value}" {role}>{_BULB}{words}</div>'

    def _tip(self, name: str) -> str:
        doc = self._lamps[name].doc if name in self._lamps else ""
        return f"{self._name}.{name}.  {doc}".strip()


def on_slides(controller: Controller, *only: str) -> dict[str, str]:
    """Return the limit and home inputs that the axes (or `only` these) show, with their parts in the drawing."""
    product = controller.product
    found: dict[str, str] = {}
    for name, axis in controller.axes.items():
        if axis.limits is not None and name in (only or (name,)):
            found |= dict(zip(product.limit_pins.get(name, ()), ("minus", "plus"), strict=False))
            if name in product.home_pins and getattr(axis, "home", None) is not None:
                found[product.home_pins[name]] = "home"
    return found


def show_switch(drawing: Drawing, part: str, pin: Pin, free: str = "free") -> None:
    """Show a switch and its terminal's level; `free`: the word for a switch that is not pressed."""
    pressed = is_pressed(pin)
    word = "stuck" if pin.held else "pressed" if pressed else "output" if pin.is_output else free
    drawing.put(part, "aria-pressed", "true" if pressed else "false")
    drawing.write(f"{part}-word", word)
    drawing.write(f"{part}-level", "high" if pin.level else "low")


def is_pressed(pin: Pin) -> bool:
    """Return True if a user has driven the terminal to another level than the connected part."""
    return pin.driven and pin.level is not pin.undriven


def action(pin: Pin) -> str:
    """Return what a click does: "low" and "high" set the level, "release" opens a pressed switch."""
    if is_pressed(pin):
        return "release"
    return "low" if pin.undriven else "high"


_PUSH = (
    '<svg viewBox="0 0 40 40" aria-hidden="true"><rect class="plate" x="1" y="1" width="38" height="38" rx="6"/>'
    '<circle class="bezel" cx="20" cy="20" r="15"/><circle class="cap" cx="20" cy="20" r="11.5"/>'
    '<path class="shine" d="M12 17a9 9 0 0 1 16 0"/></svg>'
)
_BULB = (
    '<svg viewBox="0 0 40 40" aria-hidden="true"><rect class="plate" x="1" y="1" width="38" height="38" rx="6"/>'
    '<circle class="bezel" cx="20" cy="20" r="13"/><circle class="glass" cx="20" cy="20" r="10"/>'
    '<path class="shine" d="M13 17a8 8 0 0 1 14 0"/></svg>'
)
