"""Common elements of views: lamps, keys, readouts and drawers."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from axistwin.controllers.front import Tone
from axistwin.ui.panel.context import Context
from axistwin.ui.panel.outbound import execute
from axistwin.ui.panel.turns import breathe

Thing = TypeVar("Thing", bound=ui.element)
TOGGLE = "dense no-caps unelevated text-color=ink-2 toggle-color=metal toggle-text-color=ink color=transparent"
WRITE = "axistwinState.write(Vue.toRaw(mounted_app.elements), {id}, {text})"
"""JavaScript that writes a text into an element of the page."""


def called(element: Thing, name: str) -> Thing:
    """Name an element, so that tests find it; other tasks run while a page is being built."""
    breathe()
    element.props["data-test"] = name
    element.mark(name)
    return element


class Light(TextElement):
    """A lamp with a label; screen readers can read the state of the lamp."""

    def __init__(self, label: str, name: str, tone: Tone = Tone.PLAIN, tip: str = "") -> None:
        super().__init__(tag="span", text=label)
        self.name, self.lit = name, False
        self.classes(f"lamp lit-{tone.value}")
        self.props["role"] = "img"
        self.props["title"] = tip or name
        self.props["aria-label"] = f"{name}: off"

    def show(self, on: bool) -> None:
        if on is not self.lit:
            self.lit = on
            self.classes(**{"add" if on else "remove": "lit"})
            self.props["aria-label"] = f"{self.name}: {'on' if on else 'off'}"


class Key(TextElement):
    """A small button of a page, which is drawn as pressed while its function is switched on."""

    def __init__(self, text: str, name: str, press: Callable[[], object]) -> None:
        super().__init__(tag="button", text=text)
        self.classes("press")
        self.props.update({"type": "button", "aria-label": name, "aria-pressed": "false"})
        self.on("click", lambda: press(), [])

    def show(self, pressed: bool) -> None:
        word = "true" if pressed else "false"
        if self.props["aria-pressed"] != word:
            self.props["aria-pressed"] = word


class LiveText(TextElement):
    """A text that changes often, e.g. a position; written directly, because updates redraw all elements."""

    def _handle_text_change(self, text: str) -> None:
        self._text_to_model_text(text)
        execute(self.client, WRITE.format(id=self.id, text=json.dumps(text)))


class Readout(LiveText):
    """Page element that shows a text or a number with a label."""

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
        self.text = text
        if tone is not self._tone:
            self.classes(add=f"told-{tone.value}", remove=f"told-{self._tone.value}")
            self._tone = tone


def drawer(context: Context, key: str, title: str) -> ui.expansion:
    """Build a part that the user opens and closes; its state is stored for the user under `key`."""
    settings = context.person.settings
    found = ui.expansion(title, value=bool(settings.get(key)))
    found.on_value_change(lambda: settings.update({key: found.value}))
    return called(found.classes("drawer"), key.replace(" ", "-"))


@contextmanager
def folded(context: Context, key: str, title: str) -> Iterator[None]:
    """Build a part that a narrow screen hides until a button is pressed; its state is stored for the user."""
    settings, setting = context.person.settings, f"open {key}"

    def show() -> None:
        is_open = bool(settings.get(setting))
        box.classes(**{"add" if is_open else "remove": "open"})
        button.props["aria-expanded"] = "true" if is_open else "false"

    def press() -> None:
        settings[setting] = not settings.get(setting)
        show()

    with ui.element("div").classes("fold") as box:
        button = TextElement(tag="button", text=title).classes("fold-title")
        button.props["type"] = "button"
        button.on("click", press, [])
        called(button, f"fold-{key.replace(' ', '-')}")
        show()
        with ui.element("div").classes("fold-body"):
            yield
