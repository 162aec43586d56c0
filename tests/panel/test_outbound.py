"""The order in which a new page is sent to the browser."""

import asyncio
from importlib.metadata import version
from inspect import signature
from types import SimpleNamespace
from weakref import WeakValueDictionary

import pytest
from nicegui.outbox import Outbox as NiceGuiOutbox

from axistwin.ui.panel.outbound import ELEMENTS_AT_A_TIME, Outbound

from .showing import bench_of, show


class Outbox:
    """Stand-in for NiceGUI's outbox: it sends what it has when the event loop runs."""

    def __init__(self):
        self.updates, self.sent = {}, []

    def enqueue_update(self, element):
        self.updates[element.id] = element
        if len(self.updates) == 1:
            asyncio.get_running_loop().call_soon(self.flush)

    def enqueue_message(self, kind, data, target):
        self.sent.append((kind, data, target))

    def flush(self):
        self.sent.append(list(self.updates))
        self.updates.clear()


def client_of(**state):
    page = SimpleNamespace(id=0)
    return SimpleNamespace(
        elements={0: page}, outbox=Outbox(), **{"has_socket_connection": True, "is_deleted": False, **state}
    )


def built(client, count):
    """Build a page with new elements; the first has a message of its own."""
    with Outbound(client) as outbound:
        for number in range(1, count + 1):
            client.elements[number] = element = SimpleNamespace(id=number)
            client.outbox.enqueue_update(element)
        client.outbox.enqueue_update(client.elements[0])
        client.outbox.enqueue_message("run", {"code": "1"}, "it")
    assert not client.outbox.updates and not client.outbox.sent
    return outbound


def test_elements_are_sent_before_those_that_contain_them_and_messages_last():
    async def play():
        client = client_of()
        await built(client, ELEMENTS_AT_A_TIME + 1).send()
        return client.outbox.sent

    inside = list(range(1, ELEMENTS_AT_A_TIME + 2))
    first, rest = inside[:ELEMENTS_AT_A_TIME], inside[ELEMENTS_AT_A_TIME:]
    assert asyncio.run(play()) == [first, rest, [0], ("run", {"code": "1"}, "it")]


@pytest.mark.parametrize("state", [{"has_socket_connection": False}, {"is_deleted": True}])
def test_a_browser_that_has_gone_is_not_waited_for(state):
    async def play():
        client = client_of(**state)
        client.outbox.flush = lambda: None
        await asyncio.wait_for(built(client, ELEMENTS_AT_A_TIME + 1).send(), 60)
        return client.outbox.updates

    assert 0 in asyncio.run(play())


NICEGUI = "3.18"


def test_the_insides_of_nicegui_on_which_the_panel_relies():
    """`outbound.py` replaces two methods of an outbox while it builds a page, and `memory.py` cuts an element's links.

    After an update of NiceGUI, compare its `outbox.py` and `element.py` with the version named here.
    """
    assert version("nicegui").rpartition(".")[0] == NICEGUI
    assert list(signature(NiceGuiOutbox.enqueue_update).parameters) == ["self", "element"]
    assert list(signature(NiceGuiOutbox.enqueue_message).parameters) == ["self", "message_type", "data", "target_id"]

    def play(visit):
        element = visit.user.client.layout
        found = [type(part._change_handlers) for part in (element._classes, element._style, element._props)]
        assert (found, type(element._event_listeners)) == ([list] * 3, dict)
        assert isinstance(visit.user.client.outbox.updates, WeakValueDictionary)

    show(bench_of("if1"), lambda context: lambda: None, play)
