"""A drawing in SVG and HTML whose parts move with the machine."""

import re
from collections.abc import Callable
from typing import Any

_MOVE = "move"
_PART = re.compile(r'data-part="([^"]+)"')
_ACT = re.compile(r'data-act="([^"]+)"')

Change = tuple[str, str, Any]  # A changed property: its part, its name and the new value, as `parts.js` applies it.


class Drawing:
    """A drawing that a page shows once; after that, the page receives the changes.

    `art`: SVG and HTML, in which the attribute `data-part` names each movable part.  `kind`: CSS classes.  `act` is
    called with the value of the attribute `data-act` of a part that the user has clicked.
    """

    def __init__(self, name: str, kind: str, art: str, act: Callable[[str], None] = lambda name: None) -> None:
        self.name, self.kind, self.art = name, f"drawing {kind}", art
        self.parts = frozenset(_PART.findall(art))
        self.acts = frozenset(_ACT.findall(art))
        self._act = act
        self.shown: dict[tuple[str, str], Any] = {}  # Values of all properties, by part and property.
        self._changes: list[Change] = []

    def place(self, part: str, transform: str, *, smooth: bool = True) -> None:
        """Move a part of the drawing by a CSS transform, smoothly or at once."""
        if self.shown.get((part, _MOVE)) != transform:
            self.shown[part, _MOVE] = transform
            self._changes.append((part, _MOVE if smooth else "jump", transform))

    def write(self, part: str, text: str) -> None:
        self.put(part, "text", text)

    def flag(self, part: str, kind: str, on: bool) -> None:
        """Add a CSS class to an element of the drawing if `on` is True; remove the class if `on` is False."""
        self.put(part, f".{kind}", on)

    def put(self, part: str, attribute: str, value: object) -> None:
        if self.shown.get((part, attribute)) != value:
            self.shown[part, attribute] = value
            self._changes.append((part, attribute, value))

    def take(self) -> list[Change]:
        changes, self._changes = self._changes, []
        return changes

    def everything(self) -> list[Change]:
        self._changes = []
        return [(part, "jump" if what == _MOVE else what, value) for (part, what), value in self.shown.items()]

    def click(self, name: str) -> None:
        if name in self.acts:
            self._act(name)
