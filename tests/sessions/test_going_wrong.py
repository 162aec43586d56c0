"""A planned act fails at its time: the session is paused and gives the reason."""

import asyncio

import pytest

from axistwin import Scene, Session

SCENE = {
    "controller": [{"model": "if1"}],
    "script": [
        {"at": 1.0, "do": "fault lose 2 name=gap"},
        {"at": 2.0, "do": ["fault lose 3 name=gap", "input1 high"]},
        {"at": 3.0, "do": "input2 high"},
    ],
}
WHY = "there is a fault 'gap' already"


def pins(session):
    return [session.bench["if1"].pins[name].level for name in ("input1", "input2")]


@pytest.mark.parametrize("speed", [1.0, None])
async def test_it_stands_there_says_why_and_can_go_on(speed, caplog):
    session = Session(Scene.given(SCENE).build, speed)
    session.run()
    await asyncio.sleep(5)
    assert (session.running, session.seconds) == (False, 2) and WHY in session.halted_by
    assert WHY in caplog.text
    session.run()
    await asyncio.sleep(2)
    session.pause()
    assert session.seconds >= 3
    assert pins(session) == [False, True]  # the later part of the same act was not performed


async def test_on_the_way_to_another_moment_it_is_only_told(caplog):
    session = Session(Scene.given(SCENE).build)
    for _ in range(2):
        session.run()
        await asyncio.sleep(4)
    session.pause()
    await session.go_to(0.5)
    caplog.clear()
    await session.go_to(3.5)
    assert session.seconds == 3.5 and session.halted_by == ""
    assert WHY in caplog.text and pins(session) == [False, True]


async def test_a_step_ends_there():
    session = Session(Scene.given(SCENE).build)
    session.run()
    await asyncio.sleep(1.5)
    assert not await session.step("move") and session.seconds == 2
    assert WHY in session.halted_by


async def test_a_program_whose_act_cannot_be_done_does_not_end_the_session():
    session = Session(Scene.given({"controller": [{"model": "if1"}]}).build)
    session.run()
    await asyncio.sleep(0.5)
    session.load("if1", "wrong.if1", "X1$\n! mend gap\nX2$\n")
    await asyncio.sleep(8)
    assert not session.running and "unknown fault 'gap'" in session.halted_by
