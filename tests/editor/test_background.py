"""Checks of the language server in the background."""

import asyncio
from threading import Event

import pytest

from axistwin.editor.background import Background


def test_other_work_goes_on_while_a_function_is_executed():
    async def play():
        background, ready, released = Background(), Event(), Event()

        def check():
            ready.set()
            released.wait()
            return "checked"

        checking = asyncio.create_task(background.run(check))
        while not ready.is_set():
            await asyncio.sleep(0)  # the loop continues while the check is running
        assert not checking.done()
        released.set()
        return await checking

    assert asyncio.run(play()) == "checked"


def test_a_function_waits_for_the_one_before_even_if_nobody_wants_its_result():
    async def play():
        background, ready, released, done = Background(), Event(), Event(), []

        def old():
            ready.set()
            released.wait()
            done.append("old")

        first = asyncio.create_task(background.run(old))
        while not ready.is_set():
            await asyncio.sleep(0)
        first.cancel()
        second = asyncio.create_task(background.run(lambda: done.append("new")))
        await asyncio.sleep(0)
        released.set()
        await second
        return done

    assert asyncio.run(play()) == ["old", "new"]


def test_an_error_is_raised_to_the_caller():
    def fail():
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        asyncio.run(Background().run(fail))
