"""Memory management of pages.

A page has some 30,000 Python objects.  Each garbage collection of them would delay hosts by a tenth of a second.
Therefore `keep` excludes a page from garbage collection after it is built, and `release` cuts the reference cycles of a
deleted page, so that its objects are freed at once.
"""

import asyncio
import gc
import weakref
from collections.abc import Iterable

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from axistwin.bench import Bench
from axistwin.scenes.sessions.session import Session

AT_A_TIME = 50  # Number of elements freed in one pass of the event loop; this takes less than 1 ms.


class Memory:
    """Memory management of the pages of a session."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._kept: weakref.ref[Bench] | None = None

    def keep(self) -> None:
        """Exempt all present objects from garbage collection; collect first if the bench was replaced."""
        bench = self._session.bench
        if self._kept is None or self._kept() is not bench:
            gc.unfreeze()
            gc.collect()
            self._kept = weakref.ref(bench)
        # A garbage collection of generation 1 is fast, because only recently created objects are examined.
        gc.collect(1)
        gc.freeze()


async def release(elements: Iterable[ui.element]) -> None:
    """Free the memory of removed elements, a few in each pass of the event loop."""
    left = list(elements)
    while left:
        for element in left[-AT_A_TIME:]:
            _cut(element)
        del left[-AT_A_TIME:], element
        await asyncio.sleep(0)


def _cut(element: ui.element) -> None:
    for part in (element._classes, element._style, element._props):
        part._change_handlers.clear()
    if isinstance(element, ValueElement):
        element._change_handlers.clear()
    element._event_listeners.clear()
    element.slots.clear()
    element.parent_slot = None
