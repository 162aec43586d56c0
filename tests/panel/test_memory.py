"""Memory management: deleted pages are freed without garbage collection, which skips open pages."""

import asyncio
import gc
import weakref
from functools import partial

import pytest

from axistwin import Session
from axistwin.ui.panel.context import Common, Context
from axistwin.ui.panel.memory import AT_A_TIME, Memory, release
from axistwin.ui.panel.page import Visits, build_page, build_views
from axistwin.ui.panel.people import People

from .showing import bench_of, show, stage


@pytest.mark.slow
def test_a_page_that_is_deleted_is_freed_by_counting_references():
    """Garbage collection is switched off in this test."""
    people, common = People(), Common(Session(bench_of("if1"), None))
    left = []

    async def play(user):
        await user.open("/")
        while len(user.client.elements) < 300 or common(Visits).building.locked():
            await asyncio.sleep(0)
        left.extend(weakref.ref(element) for element in user.client.elements.values())
        user.client.delete()
        user.client = None
        for _ in range(100):
            await asyncio.sleep(0)

    gc.disable()
    try:
        stage.play(partial(build_page, lambda: Context(common, people, people["a"])), play)
        assert len(left) > 300
        assert sum(each() is not None for each in left) <= 10  # NiceGUI itself keeps references to a few elements
    finally:
        gc.enable()


def test_the_loop_has_its_turn_between_a_few_elements():
    def play(visit):
        elements = list(visit.user.client.elements.values())
        visit.user.client.layout.clear()
        turns = 0
        for step in iter(partial(next, release(elements).__await__(), "end"), "end"):
            assert step is None
            turns += 1
        assert turns == -(-len(elements) // AT_A_TIME)

    def whole(context):
        made = list(build_views(context))
        return lambda: [view() for view in made]

    show(bench_of("if1"), whole, play)


@pytest.mark.slow
def test_what_is_kept_is_no_longer_searched_and_a_replaced_bench_is_freed_first():
    session = Session(bench_of("if1"), None)
    memory = Memory(session)
    try:
        memory.keep()
        assert gc.get_freeze_count() > 0
        marked = [["a page"]]
        assert any(each is marked for each in gc.get_objects())
        memory.keep()
        assert not any(each is marked for each in gc.get_objects())
        old = weakref.ref(session.bench)
        memory._session = Session(bench_of("if1"), None)
        del session
        memory.keep()
        assert old() is None
    finally:
        gc.unfreeze()
