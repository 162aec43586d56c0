"""Drawing of the switches and lamps at the terminals of a controller; a click presses or releases a switch."""

import re
from collections.abc import Callable, Iterator, Mapping
from html import escape

from axistwin.bench import Controller
from axistwin.controllers.front import Lamp, Tone
from axistwin.sim.pins import Pin, SensedPin
from axistwin.ui.drawings.drawing import Drawing
from axistwin.ui.drawings.scale import travel

Press = Callable[[str, str], None]
"""Function that performs an action at a terminal: its arguments are the terminal, and `high`, `low` or `release`."""
STOP = "estop"  # The input of an emergency stop; it is low while the stop is pressed.
LAMPS = re.compile(r"output\d|led")


class Switches:
    """The drawing of switches and lamps, without the limit and home switches that an axis shows.

    Wired and named terminals are in sight, the others folded.  `named`: names on the machine, by terminal.
    """

    def __init__(self, controller: Controller, press: Press, named: Mapping[str, str] | None = None) -> None:
        self._lamps = lamps_of(controller)
        elsewhere = {*on_slides(controller)}
        self.inputs = [name for name in self._inputs(controller) if name not in elsewhere]
        self.outputs = [name for name, pin in controller.pins.items() if pin.is_output and LAMPS.match(name)]
        self._name, self._wired = controller.name, wired_to(controller)
        self._notes = self._wired | dict(named or {})
        self.drawing = Drawing(
            f"switches {controller.name}", "switchboard", self._art(), lambda name: press(name, action(self._pin(name)))
        )
        self._pins = controller.pins
        self._wanted, self._seen = "", dict[str, tuple[bool, ...]]()

    def show(self, controller: Controller, wanted: str = "") -> None:
        """Update the drawing; `wanted`: the input that the user must change, which is marked."""
        drawing, self._pins = self.drawing, controller.pins
        if wanted != self._wanted:
            for name in {wanted, self._wanted} & {*self.inputs}:
                drawing.flag(f"switch-{name}", "wanted", name == wanted)
            self._wanted = wanted
        for name in self.inputs:
            pin, part = self._pin(name), f"switch-{name}"
            now = (pin.level, pin.undriven, pin.driven, pin.held, pin.is_output)
            if self._seen.get(name) == now:
                continue
            self._seen[name] = now
            show_switch(drawing, part, pin, wired=name in self._wired)
            drawing.flag(part, "bad", name == STOP and not pin.level)
        for name in self.outputs:
            level = self._pin(name).level
            lamp = self._lamps.get(name)
            on = controller.powered and (level if lamp is None else level is lamp.lit)
            drawing.flag(f"lamp-{name}", "lit", on)
            drawing.put(f"lamp-{name}", "aria-label", f"{title_of(name, self._lamps)}: {'on' if on else 'off'}")
            drawing.write(f"lamp-{name}-word", "on" if on else "off")
            drawing.put(f"lamp-{name}", "title", f"{self._name}.{name}: {'high' if level else 'low'}")

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

    def _art(self) -> str:
        shown = [*((name, self._switch) for name in self.inputs), *((name, self._lamp) for name in self.outputs)]
        first = "".join(draw(name) for name, draw in shown if name in self._notes)
        rest = [(name, draw) for name, draw in shown if name not in self._notes]
        none = "" if first else '<span class="quiet">nothing</span>'
        row = f'<div class="wired"><span class="quiet">Wired</span>{first}{none}</div>'
        if not rest:
            return row
        inputs = sum(name in self.inputs for name, _ in rest)
        outputs = f", {len(rest) - inputs} outputs" if len(rest) > inputs else ""
        told = f"{len(rest)} unused" if first else f"{inputs} inputs{outputs} unused"
        folded = "".join(draw(name) for name, draw in rest)
        return f'{row}<details class="unused"><summary>{told}</summary><div>{folded}</div></details>'

    def _switch(self, name: str) -> str:
        part = f"switch-{name}"
        act = f'data-act="{name}" data-part="{part}" aria-pressed="false"'
        kind = "pin safety" if name == STOP else "pin"
        words = f'<i></i>{self._words(name)} <b data-part="{part}-word">off</b>'
        return f'<button type="button" class="{kind}" {act}>{words}</button>'

    def _lamp(self, name: str) -> str:
        part, tone = f"lamp-{name}", self._lamps[name].tone if name in self._lamps else Tone.PLAIN
        words = f'<i></i>{self._words(name)} <b data-part="{part}-word">off</b>'
        return f'<span class="pin bulb bulb-{tone.value}" role="img" data-part="{part}">{words}</span>'

    def _words(self, name: str) -> str:
        note = self._notes.get(name, "")
        told = f' <span class="quiet">{escape(note)}</span>' if note and note != title_of(name, self._lamps) else ""
        return f"<span>{escape(title_of(name, self._lamps))}{told}</span>"


def lamps_of(controller: Controller) -> dict[str, Lamp]:
    """Return the lamps of the front panel that show terminals."""
    lamps = (item for group in controller.product.front for item in group.items if isinstance(item, Lamp))
    return {lamp.source: lamp for lamp in lamps if lamp.source in controller.pins}


def title_of(name: str, lamps: Mapping[str, Lamp]) -> str:
    """Return the title of a terminal, e.g. `Output 1`."""
    if name == STOP:
        return "Emergency stop"
    words = spaced(name) if name.startswith("output") or name not in lamps else lamps[name].name
    return words[:1].upper() + words[1:]


def wired_to(controller: Controller) -> dict[str, str]:
    """Return what the scene has connected to a controller's terminals, e.g. {"output1": "to input 1"}."""
    found: dict[str, str] = {}
    for source, sink in controller.bench.wires if controller.bench is not None else ():
        for end, other, word in ((source, sink, "to"), (sink, source, "from")):
            who, _, pin = end.partition(".")
            if who == controller.name:
                own, _, far = other.partition(".")
                far = spaced(far)
                found[pin] = f"{word} {far if own == controller.name else f'{own} {far}'}"
    return found


def spaced(terminal: str) -> str:
    """Return a terminal's name in words: "limit plus", "output 1"."""
    return re.sub(r"(?<=[a-z])(?=\d)", " ", terminal.replace("_", " "))


def on_slides(controller: Controller, *only: str) -> dict[str, str]:
    """Return the limit and home inputs that the axes (or `only` these) show, with their parts in the drawing."""
    product = controller.product
    found: dict[str, str] = {}
    for name, axis in controller.axes.items():
        if travel(axis) and name in (only or (name,)):
            found |= dict(zip(product.limit_pins.get(name, ()), ("minus", "plus"), strict=False))
            if name in product.home_pins and getattr(axis, "home", None) is not None:
                found[product.home_pins[name]] = "home"
    return found


def show_switch(drawing: Drawing, part: str, pin: Pin, free: str = "", *, wired: bool = False) -> None:
    """Show a switch in one word, and its terminal's level in a tooltip; `free`: the word while nobody presses it."""
    word = state_word(pin, wired=wired)
    drawing.put(part, "aria-pressed", "true" if is_pressed(pin) else "false")
    drawing.flag(part, "high", word == "on")
    drawing.write(f"{part}-word", free if free and word in ("off", "released") else word)
    level = "high" if pin.level else "low"
    if f"{part}-level" in drawing.parts:
        drawing.write(f"{part}-level", level)
    else:
        drawing.put(part, "title", f"{pin.name}: {level}")


def state_word(pin: Pin, *, wired: bool) -> str:
    """Return the state of a switch in one word; only a wire (`wired`) makes it "on" without a user."""
    if pin.held:
        return "stuck"
    if is_pressed(pin):
        return "pressed"
    return "output" if pin.is_output and not wired else level_words(pin, wired=wired)[pin.level]


def level_words(pin: Pin, *, wired: bool) -> tuple[str, str]:
    """Return the words for a low and a high level."""
    if pin.name == STOP:
        return "pressed", "released"
    if wired or pin.is_output:
        return "off", "on"
    return ("pressed", "released") if pin.undriven else ("off", "pressed")


def is_pressed(pin: Pin) -> bool:
    """Return True if a user has driven the terminal to another level than the connected part."""
    return pin.driven and pin.level is not pin.undriven


def action(pin: Pin) -> str:
    """Return what a click does: "low" and "high" set the level, "release" opens a pressed switch."""
    if is_pressed(pin):
        return "release"
    return "low" if pin.undriven else "high"
