"""A drawing, made of SVG and HTML once, whose parts follow the machine."""

import re
from typing import Any

from nicegui.element import Element

_MOVE = "move"
_PART = re.compile(r'data-part="([^"]+)"')


class Drawing(Element, component="drawing.js"):
    """`art` names its parts by `data-part`.  What has been asked for goes to the browser with `send`, if it is new."""

    def __init__(self, art: str) -> None:
        super().__init__()
        self._props["art"] = art
        self.parts = frozenset(_PART.findall(art))
        """The names of all parts."""
        self.shown: dict[tuple[str, str], Any] = {}
        """What the browser shows, or is going to: by part, and what of it."""
        self._changes: list[tuple[str, str, Any]] = []
        self.on("ready", self._begin_again, [])

    def place(self, part: str, transform: str, *, smooth: bool = True) -> None:
        """Move a part to a place, a CSS transform; not `smooth`: with no time on the way."""
        if self.shown.get((part, _MOVE)) != transform:
            self.shown[part, _MOVE] = transform
            self._changes.append((part, _MOVE if smooth else "jump", transform))

    def write(self, part: str, text: str) -> None:
        """Write on a part."""
        self._show(part, "text", text)

    def flag(self, part: str, kind: str, on: bool) -> None:
        """Let a part be of a class, or not."""
        self._show(part, f".{kind}", on)

    def put(self, part: str, attribute: str, value: str) -> None:
        """Give a part's attribute a value."""
        self._show(part, attribute, value)

    def send(self) -> None:
        """Have the browser show it."""
        if self._changes:
            changes, self._changes = self._changes, []
            self.run_method("show", changes)

    def _show(self, part: str, what: str, value: object) -> None:
        if self.shown.get((part, what)) != value:
            self.shown[part, what] = value
            self._changes.append((part, what, value))

    def _begin_again(self) -> None:
        """The browser has just put it on the page: all that should be seen there goes to it once more."""
        self._changes = [(part, "jump" if what == _MOVE else what, value) for (part, what), value in self.shown.items()]
        self.send()

    def _displayed_contents(self, *, only_visible: bool) -> list[Any]:
        texts = (value for (_, what), value in self.shown.items() if what == "text")
        return [*super()._displayed_contents(only_visible=only_visible), *texts]
