"""Who drives."""

import asyncio
from functools import partial

from nicegui.testing.user_simulation import user_simulation

from axistwin.apps.panel import people
from axistwin.apps.panel.look import Common, Look
from axistwin.apps.panel.page import page
from axistwin.apps.panel.people import People
from axistwin.apps.sessions.session import Session

from .showing import bench_of


def test_the_first_to_come_drives_and_comes_back_as_the_driver():
    those = People()
    first, second = those["a"], those["b"]
    assert those.driver is first
    assert those["a"] is first
    assert [first.name, second.name] == ["visitor 1", "visitor 2"]


def test_taking_over_is_told_to_everybody_once():
    those, told = People(), []
    _, second = those["a"], those["b"]
    end = those.listen(told.append)
    those.take_over(second)
    those.take_over(second)
    end()
    those.take_over(those["a"])
    assert told == ["visitor 2 drives now"]
    assert those.driver is those["a"]


def test_a_driver_who_has_gone_for_long_is_replaced_by_who_comes(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(people, "monotonic", lambda: now[0])
    those = People()
    first = those["a"]
    first.came()
    now[0] = 1000.0
    assert those["b"].name == "visitor 2"
    assert those.driver is first  # who is looking on
    first.left()
    now[0] = 1000.0 + people.GONE_S
    assert those["b"] is not those.driver
    now[0] += 0.1
    assert those["b"] is those.driver


def test_a_reload_within_that_time_keeps_the_wheel(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(people, "monotonic", lambda: now[0])
    those = People()
    first = those["a"]
    first.came()
    first.left()
    now[0] = 5.0
    assert those["a"] is first
    first.came()
    now[0] = 500.0
    those["b"].came()
    assert those.driver is first
    assert [person.name for person in those.there] == ["visitor 1", "visitor 2"]


def test_names_can_be_changed_but_not_to_nothing():
    those = People()
    person = those["a"]
    those.rename(person, "  Anna   Berg ")
    assert person.name == "Anna Berg"
    those.rename(person, "   ")
    assert person.name == "Anna Berg"
    those.rename(person, "x" * 200)
    assert len(person.name) == people.LONGEST_NAME


def test_somebody_is_there_as_long_as_a_page_is_connected():
    """A page that has lost its connection waits for it for a while; its visitor is away at once."""

    async def visited():
        session, those = Session(bench_of("if1"), None), People()
        async with user_simulation(partial(page, Look(Common(session), those, those["a"]))) as user:
            await user.open("/")
            there = [those["a"].pages]
            client = user.client
            (socket,) = client._socket_to_document_id
            client.handle_disconnect(socket)
            return [*there, those["a"].pages]

    assert asyncio.run(visited()) == [1, 0]
