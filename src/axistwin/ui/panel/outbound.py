"""Messages to the browser: JavaScript without an answer, and a new page such that the browser draws the page once.

A browser draws the whole page again at each update.  Therefore the elements inside the new views are sent first, which
the browser only stores, and then the elements that contain the views.
"""

import asyncio
from typing import Any, Self

from nicegui import Client, ui

ELEMENTS_AT_A_TIME = 60  # Number of elements in one message; the server needs about a millisecond for them.


def execute(client: Client, code: str) -> None:
    """Execute JavaScript without an answer; `run_javascript` would create a task, lest one be awaited."""
    if not client.is_deleted:
        client.outbox.enqueue_message("run_javascript", {"code": code}, client.id)


class Outbound:
    """Holds back all messages to the browser in a `with` block, which builds views; `send` sends them afterwards."""

    def __init__(self, client: Client) -> None:
        self._client, self._outbox = client, client.outbox
        self._before = set(client.elements)
        self._messages: list[tuple[Any, ...]] = []

    def __enter__(self) -> Self:
        self._outbox.enqueue_update = lambda element: None  # type: ignore[method-assign]
        self._outbox.enqueue_message = lambda *message: self._messages.append(message)  # type: ignore[method-assign]
        return self

    def __exit__(self, *_: object) -> None:
        del self._outbox.enqueue_update, self._outbox.enqueue_message

    async def send(self) -> None:
        """Send new elements first, then the older ones that contain them, then the messages held back."""
        there = list(self._client.elements.values())
        inside = [each for each in there if each.id not in self._before]
        for at in range(0, len(inside), ELEMENTS_AT_A_TIME):
            await self._send(inside[at : at + ELEMENTS_AT_A_TIME])
        await self._send([each for each in there if each.id in self._before])
        for message in self._messages:
            self._outbox.enqueue_message(*message)

    async def _send(self, elements: list[ui.element]) -> None:
        for element in elements:
            self._outbox.enqueue_update(element)
        while self._outbox.updates and self._client.has_socket_connection and not self._client.is_deleted:
            await asyncio.sleep(0)
