"""A drawing as an element of the page."""

import json
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from axistwin.ui.drawings.drawing import Change, Drawing
from axistwin.ui.panel.outbound import execute


class Picture(Element, component="picture.js"):
    """Page element that shows a drawing of a machine."""

    def __init__(self, drawing: Drawing) -> None:
        super().__init__()
        self.drawing = drawing
        self._props["art"] = drawing.art
        self.classes(drawing.kind).mark(drawing.name)
        self.on("ready", self._begin_again, [])
        if drawing.acts:
            self.on("act", self._clicked)

    def send(self) -> None:
        self._show(self.drawing.take())

    def _show(self, changes: list[Change]) -> None:
        if changes and not self.is_deleted:
            execute(self.client, f'runMethod({self.id},"show",[{json.dumps(changes)}])')

    def _clicked(self, event: GenericEventArguments) -> None:
        if isinstance(event.args, str):
            self.drawing.click(event.args)

    def _begin_again(self) -> None:
        self._show(self.drawing.everything())

    def _displayed_contents(self, *, only_visible: bool) -> list[Any]:
        texts = (value for (_, what), value in self.drawing.shown.items() if what == "text")
        return [*super()._displayed_contents(only_visible=only_visible), *texts]
