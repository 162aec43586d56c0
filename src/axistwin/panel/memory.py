"""Memory of pages.

A page has some 30,000 Python objects.  A search through them for garbage would keep hosts waiting for a tenth of a
second, again and again.  So pages are taken out of these searches when they are built (`keep`), and when they are left
the cycles of references in them are cut (`release`): what nobody refers to is freed at once.
"""

import asyncio
import gc
import weakref
from collections.abc import Iterable

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from axistwin.bench import Bench
from axistwin.sessions.session import Session

AT_A_TIME = 50
"""Number of elements released between two turns of the loop: less than 1 ms."""


class Memory:
    """What a session's pages take."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._kept: weakref.ref[Bench] | None = None

    def keep(self) -> None:
        """Leave what there is now out of Python's searches for garbage.

        A bench that has been replaced since the last time is freed first: only a whole search finds it.
        """
        bench = self._session.bench
        if self._kept is None or self._kept() is not bench:
            gc.unfreeze()
            gc.collect()
            self._kept = weakref.ref(bench)
        gc.collect(1)  # what was made for a moment only; the older ones are collected by themselves
        gc.freeze()


async def release(elements: Iterable[ui.element]) -> None:
    """Free elements that have been removed from their page, a few at a time."""
    left = list(elements)
    while left:
        for element in left[-AT_A_TIME:]:
            _cut(element)
        del left[-AT_A_TIME:], element
        await asyncio.sleep(0)


def _cut(element: ui.element) -> None:
    """Let it refer to nothing that refers to it; whoever still holds it may set and read its properties."""
    for part in (element._classes, element._style, element._props):
        part._change_handlers.clear()
    if isinstance(element, ValueElement):
        element._change_handlers.clear()
    element._event_listeners.clear()
    element.slots.clear()
    element.parent_slot = None
