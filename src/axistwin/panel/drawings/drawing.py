"""A drawing in SVG and HTML whose parts move with the machine."""

import re
from collections.abc import Callable
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

_MOVE = "move"
_PART = re.compile(r'data-part="([^"]+)"')
_ACT = re.compile(r'data-act="([^"]+)"')


class Drawing(Element, component="drawing.js"):
    """A drawing on the page.  `art`: SVG and HTML, in which the attribute `data-part` names each movable part.

    `act` is called with the value of the attribute `data-act` of a part that the user has clicked.
    """

    def __init__(self, art: str, act: Callable[[str], None] = lambda name: None) -> None:
        super().__init__()
        self._props["art"] = art
        self.acts = frozenset(_ACT.findall(art))
        self._act = act
        self.parts = frozenset(_PART.findall(art))
        self.shown: dict[tuple[str, str], Any] = {}
        """Values of all properties by part and name; the next `send` transfers new values to the browser."""
        self._changes: list[tuple[str, str, Any]] = []
        self.on("ready", self._begin_again, [])
        if self.acts:
            self.on("act", self._clicked)

    def place(self, part: str, transform: str, *, smooth: bool = True) -> None:
        """Move a part of the drawing by a CSS transform, smoothly or at once."""
        if self.shown.get((part, _MOVE)) != transform:
            self.shown[part, _MOVE] = transform
            self._changes.append((part, _MOVE if smooth else "jump", transform))

    def write(self, part: str, text: str) -> None:
        """Set the text of a part of the drawing."""
        self.put(part, "text", text)

    def flag(self, part: str, kind: str, on: bool) -> None:
        """Add a CSS class to a part of the drawing if `on`, otherwise remove the class."""
        self.put(part, f".{kind}", on)

    def put(self, part: str, attribute: str, value: object) -> None:
        """Set an SVG or HTML attribute of a part of the drawing."""
        if self.shown.get((part, attribute)) != value:
            self.shown[part, attribute] = value
            self._changes.append((part, attribute, value))

    def send(self) -> None:
        """Send the collected changes to the browser."""
        if self._changes:
            changes, self._changes = self._changes, []
            self.run_method("show", changes)

    def _clicked(self, event: GenericEventArguments) -> None:
        if isinstance(event.args, str) and event.args in self.acts:
            self._act(event.args)

    def _begin_again(self) -> None:
        """Send the values of all properties after the browser has added the drawing to the page."""
        self._changes = [(part, "jump" if what == _MOVE else what, value) for (part, what), value in self.shown.items()]
        self.send()

    def _displayed_contents(self, *, only_visible: bool) -> list[Any]:
        texts = (value for (_, what), value in self.shown.items() if what == "text")
        return [*super()._displayed_contents(only_visible=only_visible), *texts]
