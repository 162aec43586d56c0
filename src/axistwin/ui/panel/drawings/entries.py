"""The list of a conversation as an element of the page."""

import json
from collections.abc import Callable
from itertools import islice
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from axistwin.ui.conversation.log import Log
from axistwin.ui.panel.outbound import execute

SHOWN = 1000  # Largest number of entries that a newly opened list shows.


class Entries(Element, component="entries.js"):
    """Shows the list of an endpoint; `typed(text)` is called for keys that are pressed on the list."""

    def __init__(self, log: Log, name: str, typed: Callable[[str], None]) -> None:
        super().__init__()
        self._log, self._name = log, name
        self._generation, self._count = -1, 0
        self.spoken = False  # True if the list has a message or a question.
        self.on("ready", self._begin_again, [])
        self.on("keys", lambda event: self._keys(event, typed))

    def send(self) -> None:
        """Send the entries that are new or have changed."""
        if self._log.generation != self._generation:
            self._generation = self._log.generation
            self._begin_again()
            return
        self._count, entries = self._log.since(self._name, self._count)
        self.spoken = self.spoken or any(each.who in "><?" for each in entries)
        shown = [each.shown() for each in islice(entries, max(0, len(entries) - SHOWN), None)]
        if shown and not self.is_deleted:
            execute(self.client, f'runMethod({self.id},"add",[{json.dumps(shown)}])')

    def _begin_again(self) -> None:
        self._count, self.spoken = 0, False
        if not self.is_deleted:
            execute(self.client, f'runMethod({self.id},"clear",[])')
        self.send()

    @staticmethod
    def _keys(event: GenericEventArguments, typed: Callable[[str], None]) -> None:
        if isinstance(event.args, str):
            typed(event.args)

    def _displayed_contents(self, *, only_visible: bool) -> list[Any]:
        entries = self._log.since(self._name, 0)[1]
        texts = [text for each in entries for text in (each.text, *each.notes)]
        return [*super()._displayed_contents(only_visible=only_visible), *texts]
