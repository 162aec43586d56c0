"""Users of the panel, and the driver among them."""

import asyncio
from functools import partial

import pytest

from axistwin import Session
from axistwin.ui.panel import page as page_module
from axistwin.ui.panel import people
from axistwin.ui.panel.context import Common, Context
from axistwin.ui.panel.page import Visits, build_page
from axistwin.ui.panel.people import People

from .showing import bench_of, stage


@pytest.fixture
def now(monkeypatch):
    """Return a list with the time, which the test sets."""
    now = [0.0]
    monkeypatch.setattr(people, "monotonic", lambda: now[0])
    return now


def test_the_first_to_come_drives_and_comes_back_as_the_driver():
    those = People()
    first, second = those["a"], those["b"]
    assert those.driver is first and those["a"] is first
    assert [first.name, second.name] == ["visitor 1", "visitor 2"]


def test_taking_over_is_told_to_everybody_once():
    those, told = People(), []
    _, second = those["a"], those["b"]
    end = those.subscribe(told.append)
    those.take_over(second)
    those.take_over(second)
    end()
    those.take_over(those["a"])
    assert told == ["visitor 2 drives now"] and those.driver is those["a"]


def test_a_driver_who_has_gone_for_long_is_replaced_by_who_comes(now):
    those = People()
    first = those["a"]
    first.came()
    now[0] = 1000.0
    assert those["b"].name == "visitor 2"
    assert those.driver is first  # the first user's page is still connected
    first.left()
    now[0] = 1000.0 + people.GONE_S
    assert those["b"] is not those.driver
    now[0] += 0.1
    assert those["b"] is those.driver


def test_a_reload_within_that_time_keeps_the_wheel(now):
    those = People()
    first = those["a"]
    first.came()
    first.left()
    now[0] = 5.0
    assert those["a"] is first
    first.came()
    now[0] = 500.0
    those["b"].came()
    assert those.driver is first and [person.name for person in those.there] == ["visitor 1", "visitor 2"]


def test_names_can_be_changed_but_not_to_nothing():
    those = People()
    person = those["a"]
    those.rename(person, "  Anna   Berg ")
    assert person.name == "Anna Berg"
    those.rename(person, "   ")
    assert person.name == "Anna Berg"
    those.rename(person, "x" * 200)
    assert len(person.name) == people.LONGEST_NAME


def test_people_who_left_are_forgotten(now):
    those = People()
    first, second = those["a"], those["b"]
    second.came()
    first.left_s = 0.0
    now[0] = people.FORGOTTEN_S + 1
    assert [those["c"].name, those["b"].name, those["a"].name] == ["visitor 3", "visitor 2", "visitor 4"]
    assert those["a"] is not first and those["b"] is second


def test_of_very_many_who_left_the_latest_are_remembered(now):
    those = People()
    for number in range(people.REMEMBERED + 50):
        now[0] = 0.1 * number
        those[str(number)].left_s = now[0]
    now[0] += people.GONE_S + 1
    _ = those["new"]
    assert list(those._all) == [*map(str, range(50, people.REMEMBERED + 50)), "new"]


class Visited:
    """Build pages, one for each visit, for the users with these keys."""

    def __init__(self, keys):
        self.session, self.people, self._keys = Session(bench_of("if1"), None), People(), iter(keys)
        self.common, self.entered = Common(self.session), 0

    def enter(self):
        self.entered += 1
        return Context(self.common, self.people, self.people[next(self._keys)])

    async def until(self, came_true):
        for _ in range(2000):
            if came_true():
                return
            await asyncio.sleep(0)
        raise AssertionError("it never came true")


async def disconnect(client):
    (socket,) = client._socket_to_document_id
    client.handle_disconnect(socket)


def test_somebody_is_there_as_long_as_a_page_is_connected():
    """A disconnected page is kept for a while, but its user counts as absent at once."""
    visited = Visited("a")

    async def play(user):
        await user.open("/")
        await visited.until(lambda: visited.people.there)
        there = visited.people["a"].pages
        await disconnect(user.client)
        return there, visited.people["a"].pages

    assert stage.play(partial(build_page, visited.enter), play) == (1, 0)


def test_who_only_fetches_the_page_is_nobody_and_does_not_drive():
    visited = Visited("a")

    async def play(user):
        answer = await user.http_client.get("/")
        for _ in range(100):
            await asyncio.sleep(0)
        return answer.status_code, visited.entered, visited.people.driver

    assert stage.play(partial(build_page, visited.enter), play) == (200, 0, None)


@pytest.mark.slow
def test_of_many_pages_that_are_left_the_latest_are_kept_whole(monkeypatch):
    monkeypatch.setattr(page_module, "KEPT_PAGES", 2)
    visited = Visited("aaaa")

    async def play(user):
        left = []
        for number in range(4):
            await user.open("/")
            await visited.until(lambda number=number: visited.people["a"].pages and len(user.client.elements) > 100)
            left.append(user.client)
            async with visited.common(Visits).building:  # wait until the page is built
                await disconnect(user.client)
        return [len(client.elements) > 100 for client in left]

    assert stage.play(partial(build_page, visited.enter), play) == [False, False, True, True]
