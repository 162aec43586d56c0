"""What views are put together from: a lamp, a key, a part of the page that can be opened."""

from collections.abc import Callable
from typing import TypeVar

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from axistwin.controllers.front import Tone
from axistwin.panel.look import Look
from axistwin.panel.turns import breathe

Thing = TypeVar("Thing", bound=ui.element)


def called(element: Thing, name: str) -> Thing:
    """Let tests find it, with a browser and without; here the page may pause while it is built."""
    breathe()
    element.props["data-test"] = name
    element.mark(name)
    return element


class Light(TextElement):
    """A lamp with its label.  It is filled while lit, and says so to those who cannot see it."""

    def __init__(self, label: str, name: str, tone: Tone = Tone.PLAIN, tip: str = "") -> None:
        super().__init__(tag="span", text=label)
        self.name, self.lit = name, False
        self.classes(f"lamp lit-{tone.value}")
        self.props["role"] = "img"
        self.props["title"] = tip or name
        self.props["aria-label"] = f"{name}: off"

    def show(self, on: bool) -> None:
        """Lit or not."""
        if on is not self.lit:
            self.lit = on
            self.classes(**{"add" if on else "remove": "lit"})
            self.props["aria-label"] = f"{self.name}: {'on' if on else 'off'}"


class Key(TextElement):
    """A small button that stays pressed while what it does holds."""

    def __init__(self, text: str, name: str, press: Callable[[], object]) -> None:
        super().__init__(tag="button", text=text)
        self.classes("press")
        self.props.update({"type": "button", "aria-label": name, "aria-pressed": "false"})
        self.on("click", lambda: press(), [])

    def show(self, pressed: bool) -> None:
        """Pressed or not."""
        word = "true" if pressed else "false"
        if self.props["aria-pressed"] != word:
            self.props["aria-pressed"] = word


class Told(TextElement):
    """A value in words or figures, with what it is."""

    def __init__(self, label: str, name: str, unit: str = "", tip: str = "") -> None:
        with ui.element("span").classes("told") as told:
            told.props["title"] = tip or name
            ui.label(label or name).classes("told-label")
            super().__init__(tag="output", text="")
            self.classes("told-value")
            self.props["aria-label"] = name
            self._tone = Tone.PLAIN
            if unit:
                ui.label(unit).classes("told-unit")

    def show(self, text: str, tone: Tone = Tone.PLAIN) -> None:
        """This, in the colour of `tone`."""
        if text != self.text:
            self.text = text
        if tone is not self._tone:
            self.classes(add=f"told-{tone.value}", remove=f"told-{self._tone.value}")
            self._tone = tone


def drawer(look: Look, key: str, title: str, *, opened: bool = False) -> ui.expansion:
    """A part of the page that can be opened; whether it is, is known again for this person."""
    settings = look.person.settings

    def turned() -> None:
        settings[key] = found.value

    found = ui.expansion(title, value=bool(settings.get(key, opened)), on_value_change=turned)
    return called(found.classes("drawer"), key.replace(" ", "-"))
