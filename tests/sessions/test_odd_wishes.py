"""Impossible requests are refused with a message; possible requests are recorded and replayed."""

import asyncio
import shutil

import pytest

from axistwin import Session
from axistwin.core.errors import AxistwinError, UsageError

from ..benches import bench_of
from .driving import Traced, run_saved

two = bench_of("if1 a", "1811 board")


@pytest.mark.parametrize("acts", [
    [("a", "fault", 'lose 2 name="a gap"'), ("a", "mend", "a gap")],
    [("a", "fault", 'lose 2 "name=a gap"'), ("a", "mend", "'a gap'")],
    [("a", "fault", "lose 2"), ("a", "fault", "lose 3"), ("a", "mend", "lose-2")],
    [
        ("a", "fault", 'lose 2 when="a hears X" name=gap'),
        ("a", "fault", 'flip mask=1 when="gap begins" name=noise'),
        ("a", "mend", "noise"),
    ]])  # fmt: skip
async def test_a_fault_is_mended_by_its_name_in_the_saved_scene_too(acts, tmp_path):
    session = Session(two)
    traced = Traced(session, tmp_path)
    session.run()
    for act in acts:
        await asyncio.sleep(0.5)
        session.do(*act)
    session.pause()
    assert run_saved(session.save(), tmp_path, session.seconds) == traced.rows()


async def test_a_fault_begun_together_with_something_else_is_mended_by_its_name_later(tmp_path):
    session = Session(two)
    traced = Traced(session, tmp_path)
    session.say("a", b"(")
    session.do("a", "fault", "lose 200 name=gap")
    session.run()
    await asyncio.sleep(0.5)
    session.do("a", "mend", "gap")
    session.pause()
    assert run_saved(session.save(), tmp_path, session.seconds) == traced.rows()


@pytest.mark.parametrize(("said", "why"), [(b"", "the command is missing"), (b"\x84" * 17, "at most 16 bytes")])
def test_to_a_board_only_commands_are_said(said, why):
    session = Session(two)
    with pytest.raises(AxistwinError, match=why):
        session.say("board", said)
    assert session.save().keys() == {"scene.toml"}


def test_a_program_that_nobody_has_given_is_not_loaded():
    with pytest.raises(UsageError, match=r"unknown program x\.if1"):
        Session(two).do("a", "load", "x.if1")


@pytest.mark.parametrize("speed", [0, -1, float("inf"), float("nan")])
def test_what_is_no_speed_is_refused(speed):
    session = Session(two, 2.0)
    with pytest.raises(UsageError, match="invalid speed"):
        session.speed = speed
    assert session.speed == 2


def test_a_break_can_be_removed_twice():
    session = Session(two)
    added, other = session.add_break("a.input1 rises"), session.add_break("a.input1 rises")
    session.remove_break(added)
    session.remove_break(added)
    assert session.breaks == [other]


async def test_on_the_way_nothing_is_forgotten_and_no_break_is_added():
    session = Session(two, 1000.0)
    session.run()
    await asyncio.sleep(1)
    session.say("a", b"(")
    session.pause()
    recorded_s = session.recorded_seconds
    on_the_way = asyncio.ensure_future(session.go_to(recorded_s / 2))
    await asyncio.sleep(0)
    for wish in (session.forget_rest, lambda: session.add_break("a.input1 rises")):
        with pytest.raises(UsageError, match="wait until the method `step`"):
            wish()
    await on_the_way
    assert session.repeating and session.recorded_seconds == recorded_s


async def test_who_gives_up_on_the_way_finds_the_breaks_armed():
    session = Session(two, 1000.0)
    session.run()
    await asyncio.sleep(1)
    added = session.add_break("a.input1 rises")
    on_the_way = asyncio.ensure_future(session.go_to(1))
    await asyncio.sleep(0)
    on_the_way.cancel()
    with pytest.raises(asyncio.CancelledError):
        await on_the_way
    session.do("a", "input1", "high")
    assert added.hits == 1


async def test_where_memory_cannot_be_put_back_hosts_are_heard_as_before(tmp_path):
    session = Session(bench_of("if2", state=tmp_path / "state"))
    server = session.serve()
    session.run()
    await asyncio.sleep(1)
    shutil.rmtree(tmp_path / "state")
    (tmp_path / "state").write_text("no directory any more")
    with pytest.raises(AxistwinError, match=r"cannot remove .*if2\.json: not a directory"):
        await session.go_to(0)
    assert not server.gate.closed and not session.busy
