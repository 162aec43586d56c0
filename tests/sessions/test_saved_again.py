"""Scenes with hosts and programs, such as saved sessions: continued and saved again."""

import asyncio
from pathlib import Path

import pytest

from axistwin import Scene, Session
from axistwin.scenes.hosting import rank_of

from ..benches import bench_of
from .driving import Traced, run_saved

SCENE = """\
[[controller]]
model = "if1"
host = "first.if1"

[[script]]
at = 4.0
do = "load next.if1"
"""


MESSAGE_READY = 0x08


board = bench_of("1811")


def scene_in(directory: Path) -> Scene:
    directory.mkdir()
    (directory / "scene.toml").write_text(SCENE)
    (directory / "first.if1").write_text("X10$\n")
    (directory / "next.if1").write_text("X20$\n")
    return Scene.load(directory / "scene.toml")


async def wait(session: Session, seconds: float) -> None:
    session.run()
    await asyncio.sleep(seconds)
    session.pause()


def save(session: Session, directory: Path) -> None:
    directory.mkdir()
    for name, text in session.save().items():
        (directory / name).write_text(text)


async def test_they_are_as_they_were_when_the_session_began(tmp_path):
    scene = scene_in(tmp_path / "scene")
    session = Session(scene.build, scene=scene)
    (tmp_path / "scene" / "first.if1").write_text("Y70$\n")
    (tmp_path / "scene" / "next.if1").unlink()
    traced = Traced(session, tmp_path)
    await wait(session, 8)
    save(session, tmp_path / "saved")
    assert run_saved({}, tmp_path / "saved", session.seconds) == traced.rows()


async def test_what_has_been_saved_is_loaded_into_and_saved_again(tmp_path):
    scene = scene_in(tmp_path / "scene")
    session = Session(scene.build, scene=scene)
    await wait(session, 5)
    session.load("if1", "next.if1", "X30$\n")
    save(session, tmp_path / "once")
    again = Scene.load(tmp_path / "once" / "scene.toml")
    session = Session(again.build, scene=again)
    traced = Traced(session, tmp_path)
    await wait(session, 6)  # the host that sends X30 is still busy
    session.load("if1", "next.if1", "Y40$\n")
    await wait(session, 4)
    save(session, tmp_path / "twice")
    assert run_saved({}, tmp_path / "twice", session.seconds) == traced.rows()
    texts = {path.read_text() for path in (tmp_path / "twice").glob("*.if1")}
    assert texts == {"X10$\n", "X20$\n", "X30$\n", "Y40$\n"}


async def test_a_board_has_one_host_also_when_people_go_on_where_a_saved_one_has_ended(tmp_path):
    session = Session(board)
    await wait(session, 1)
    session.say("1811", b"\x84")
    await wait(session, 0.5)
    save(session, tmp_path / "once")
    again = Scene.load(tmp_path / "once" / "scene.toml")
    session = Session(again.build, scene=again)
    traced = Traced(session, tmp_path)
    await wait(session, 2)
    for act in (("write", "0 84"), ("write", "1 10")):
        session.do("1811", *act)  # direct access to the registers: the message is not read
    await wait(session, 0.5)
    assert session.bench["1811"].bus.status & MESSAGE_READY
    save(session, tmp_path / "twice")
    assert run_saved({}, tmp_path / "twice", session.seconds) == traced.rows()


async def test_what_was_done_later_at_the_same_nanosecond_comes_later_in_what_is_saved_again(tmp_path):
    scene = Scene.given({"controller": [{"model": "if1"}]})
    session = Session(scene.build, scene=scene)
    session.say("if1", b"(")
    session.do("if1", "input1", "high")
    save(session, tmp_path / "once")
    again = Scene.load(tmp_path / "once" / "scene.toml")
    session = Session(again.build, scene=again)
    traced = Traced(session, tmp_path)
    session.do("if1", "input1", "low")
    await wait(session, 1)
    save(session, tmp_path / "twice")
    assert run_saved({}, tmp_path / "twice", session.seconds) == traced.rows()


@pytest.mark.parametrize(("host", "rank"), [
    ("", 0), ("mine", 0), ("outside", 1), ("outside 1", 1), ("outside 2", 2), ("outside 99", 8)])  # fmt: skip
def test_hosts_from_outside_come_one_after_the_other(host, rank):
    assert rank_of(host) == rank
