"""Execute a computation in pieces; the event loop runs between two pieces."""

import asyncio
from types import SimpleNamespace

import pytest
from nicegui import ui

from axistwin.controllers.registry import OURS
from axistwin.ui.panel import turns
from axistwin.ui.panel.context import careful, together
from axistwin.ui.panel.page import build_views
from axistwin.ui.panel.turns import breathe, in_turns

from .showing import bench_of, show


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]

    def read():
        now[0] += 0.001
        return now[0]

    monkeypatch.setattr(turns, "perf_counter", read)
    monkeypatch.setattr(turns, "TURN_S", 0.003)
    return now


def run(compute):
    """Return the result of `in_turns`, and the number of passes of the event loop during the computation."""

    async def counted():
        had = 0

        async def count():
            nonlocal had
            while True:
                had += 1
                await asyncio.sleep(0)

        counting = asyncio.create_task(count())
        await asyncio.sleep(0)
        had = 0
        try:
            return await in_turns(compute), had
        finally:
            counting.cancel()

    return asyncio.run(counted())


def test_the_loop_has_its_turn_whenever_the_time_is_over(clock):
    """A piece ends when the clock has been read three times, that is after 3 ms."""
    order = []

    def compute():
        for number in range(9):
            order.append(number)
            breathe()
        return "done"

    assert run(compute) == ("done", 3) and order == list(range(9))


def test_outside_it_does_nothing():
    breathe()


def test_what_is_raised_is_raised():
    def compute():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run(compute)


def test_it_is_in_the_task_that_waits_for_it():
    """NiceGUI finds the page of a new element by the present task, so the computation stays in its task."""

    async def compare():
        return await in_turns(asyncio.current_task) is asyncio.current_task()

    assert asyncio.run(compare())


def test_given_up_it_ends_where_it_is(clock):
    ended, loops = [], []

    def compute():
        try:
            while True:
                breathe()
                loops.append(1)
        finally:
            ended.append(True)

    async def give_up():
        task = asyncio.create_task(in_turns(compute))
        for _ in range(5):
            await asyncio.sleep(0)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(give_up())
    assert ended == [True] and loops


MOST_ELEMENTS = 15


def counted(client, compute, monkeypatch):
    """Return the result of `compute()`, and the numbers of elements that it makes between two pauses."""
    made, before = [], client.next_element_id

    def count():
        nonlocal before
        made.append(client.next_element_id - before)
        before = client.next_element_id

    with monkeypatch.context() as patch:
        patch.setattr(turns._here, "work", SimpleNamespace(breathe=count), raising=False)
        found = compute()
    count()
    return found, made


@pytest.mark.parametrize("model", OURS)
def test_a_page_and_its_tabs_are_built_apart_from_the_frames_and_pause_every_few_elements(model, monkeypatch):
    """An element takes at most 0.2 ms: the work after 1.5 ms, before the piece ends, takes at most 3 ms."""

    def build(context):
        def views_with_pauses():
            for view in build_views(context):
                breathe()
                yield view

        views, made = counted(ui.context.client, lambda: list(views_with_pauses()), monkeypatch)
        assert sum(made) > 200 and max(made) <= MOST_ELEMENTS
        return together(*views)

    def play(visit):
        client = visit.user.client
        for tab in ("Pins", "Program", "Terminal"):
            visit.user.find(tab).click()
            with client:
                before = client.next_element_id
                visit._refresh()
                (build,) = visit.context.unbuilt or [lambda: None]
                visit.context.unbuilt.clear()
                assert client.next_element_id == before
                _, made = counted(client, build, monkeypatch)
            assert max(made) <= MOST_ELEMENTS, tab
            visit.run(0.5)
        assert visit.found("clock").text == "1.500000 s"

    show(bench_of(model), build, play)


def test_a_defect_in_a_view_is_reported_once_and_is_no_end_for_others(caplog):
    shown, failing = [], [True]

    def view():
        if failing[0]:
            raise ZeroDivisionError
        shown.append(True)

    refresh = careful(view)
    refresh()
    refresh()
    assert [record.exc_info[0] for record in caplog.records] == [ZeroDivisionError]
    failing[0] = False
    refresh()
    assert shown == [True]
