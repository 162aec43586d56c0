"""A session is saved as a scene that repeats the session: from a scene, or from a single model."""

import asyncio
from pathlib import Path

import pytest

from axistwin import Scene, Session
from axistwin.core.errors import SceneError

from ..benches import bench_of
from .driving import Traced, run_saved

EXAMPLES = Path(__file__).parents[2] / "examples"
MOTORS = """\
# Two motors on one line.
title = "Two"

[[controller]]  # the first
model = "smartmotor"
name = "left"
program = "../shared/left.sms"

[[controller]]
model = "smartmotor"
name = "right"
state = "memory"

[[chain]]
motors = ["left", "right"]
"""


async def session_of(scene: Scene, **options) -> Session:
    session = Session(lambda: scene.build(served=options.get("served", False)), None, scene=scene, **options)
    session.run()
    await asyncio.sleep(0.01)
    session.pause()
    return session


@pytest.mark.parametrize("name", ["drill", "winder"])
async def test_what_is_done_to_an_example_is_repeated_by_the_saved_scene(name, tmp_path):
    path = EXAMPLES / name / "scene.toml"
    scene = Scene.load(path)
    session = Session(scene.build, 20.0, scene=scene)
    traced = Traced(session, tmp_path)
    session.run()
    await asyncio.sleep(0.1)
    controller = next(iter(session.bench.controllers))
    session.do(controller, "fault", f"jam {next(iter(session.bench[controller].axes))} duration=0.1")
    await asyncio.sleep(0.02)
    session.do(controller, "power", "off")
    session.pause()
    session.do(controller, "power", "on")
    await session.step("event")
    session.run()
    await asyncio.sleep(0.01)
    session.pause()
    files = session.save()
    assert files["scene.toml"].startswith(path.read_text().rstrip())
    assert run_saved(files, tmp_path / "saved", session.seconds) == traced.rows()


async def test_the_text_stays_as_it_is_but_for_hosts_programs_and_what_has_been_done(tmp_path):
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared" / "left.sms").write_text("a=1\nEND\n")
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "two.toml").write_text(MOTORS)
    session = await session_of(Scene.load(tmp_path / "here" / "two.toml"))
    session.say("chain", b"ECHO ")
    session.say("right.rs485", b"RP ")
    session.do("left", "A", "2.5V")
    session.run()
    await asyncio.sleep(0.1)
    session.do("left", "A", "release")
    session.pause()
    files = session.save()
    assert sorted(files) == ["chain.talk", "left.sms", "scene.toml"]
    assert files["scene.toml"].startswith(
        '# Two motors on one line.\ntitle = "Two"\n\n[[controller]]  # the first\nmodel = "smartmotor"\n'
        'name = "left"\nprogram = "left.sms"\n'
    )
    assert '[[chain]]\nhost = ["chain.talk"]\nmotors = ["left", "right"]\n' in files["scene.toml"]
    assert 'do = "A release"' in files["scene.toml"]
    assert "> ECHO\\x20\nright.rs485: > RP\\x20\nleft: ! A 2.5V\n" in files["chain.talk"]
    run_saved(files, tmp_path / "saved", session.seconds)


async def test_hosts_that_stayed_away_are_left_out(tmp_path):
    (tmp_path / "moves.if1").write_text("X100$\n")
    (tmp_path / "s.toml").write_text(
        '[[controller]]\nmodel = "if1"\nhost = "moves.if1"\nports = ["tcp://127.0.0.1:0"]\n'
    )
    scene = Scene.load(tmp_path / "s.toml")
    session = await session_of(scene, served=True)
    session.say("if1", b"(")
    files = session.save()
    assert sorted(files) == ["if1.talk", "scene.toml"] and 'host = ["if1.talk"]' in files["scene.toml"]
    session = await session_of(scene)
    session.say("if1", b"(")
    assert 'host = ["moves.if1", "if1.talk"]' in session.save()["scene.toml"]


async def test_a_scene_that_is_written_in_another_manner_is_written_anew(tmp_path):
    (tmp_path / "s.toml").write_text(
        'title = "T"\ncontroller = [{ model = "if1" }]\nscript = [{ at = 1.0, do = "led high" }]\n'
    )
    session = await session_of(Scene.load(tmp_path / "s.toml"))
    session.say("if1", b"(")
    session.run()
    await asyncio.sleep(0.1)
    session.do("if1", "input1", "high")
    files = session.save()
    assert 'title = "T"\n' in files["scene.toml"]
    assert '[[controller]]\nmodel = "if1"\nhost = ["if1.talk"]\n' in files["scene.toml"]
    assert files["scene.toml"].count("[[script]]") == 2
    run_saved(files, tmp_path / "saved", session.seconds)


async def test_programs_that_were_loaded_are_loaded_again(tmp_path):
    session = Session(bench_of("smartmotor motor", "if1"), 1.0)
    traced = Traced(session, tmp_path)
    session.run()
    await asyncio.sleep(1)
    session.load("if1", "moves.if1", "X100$\n")
    session.load("motor", "a b.sms", "a=1\nEND\n")
    await asyncio.sleep(0.5)
    session.load("motor", "a b.sms", "a=2\nEND\n")
    await asyncio.sleep(3)
    session.pause()
    assert session.bench["motor"].registers["Ra"].read() == 2
    files = session.save()
    assert {"a_b.sms", "a_b-2.sms", "moves.if1"} < set(files)
    assert run_saved(files, tmp_path / "saved", session.seconds) == traced.rows()


async def test_what_is_kept_without_power_goes_with_it(tmp_path):
    build = bench_of("smartmotor motor", state=tmp_path / "memory")
    session = Session(build, 1.0)
    session.run()
    await asyncio.sleep(1)
    session.load("motor", "a.sms", "a=1\nEND\n")
    session.do("motor", "power", "off")
    assert "state" in session.save()["scene.toml"] and "state/motor.json" not in session.save()
    later = Session(build, 1.0)
    assert later.save()["state/motor.json"] == (tmp_path / "memory" / "motor.json").read_text()


def test_a_conversation_in_a_scene_waits_for_what_it_hears(tmp_path):
    (tmp_path / "h.talk").write_text(
        "; patience: 2\n+1.5\n> (\n< U\\r\n! input1 high\n> U61\\r\n< nothing comes\n! input2 high\n"
    )
    (tmp_path / "s.toml").write_text('[[controller]]\nmodel = "if1"\nhost = "h.talk"\n')
    bench = Scene.load(tmp_path / "s.toml").build()
    pins, when = bench["if1"].pins, {}
    for name in ("input1", "input2"):
        pins[name].subscribe(lambda pin, name=name: when.setdefault(name, bench.seconds))
    heard = []
    bench["if1"].serial.subscribe_received(lambda byte, _: heard.append(bench.seconds))
    bench.run(5)
    assert when["input1"] == heard[1] and when["input2"] == pytest.approx(when["input1"] + 2)


@pytest.mark.parametrize(("talk", "message"), [
    ("> X\nother: > Y\n", r"h\.talk:2: no controller 'other' in the scene: expected one of if1"),
    ("! input9 high\n", r"h\.talk:1: unknown name 'input9'"),
    ("! load x.if1\n", r"x\.if1 cannot be read"),
    ("! load x.exe\n", "x.exe cannot be loaded: expected a file whose name ends in .sms"),
    ("! write 0\n", "unknown name 'write'"),
    ("! flow maybe\n", "invalid flow control 'maybe': expected one of none, dtr, xon"),
    (
        "! drop it\n",
        "invalid value 'it' of the action `drop`: expected `! drop pending`, to discard unsent characters",
    )])  # fmt: skip
def test_what_a_host_cannot_do_is_told_with_its_place(talk, message, tmp_path):
    (tmp_path / "h.talk").write_text(talk)
    (tmp_path / "s.toml").write_text('[[controller]]\nmodel = "if1"\nhost = ["h.talk"]\n')
    with pytest.raises(SceneError, match=rf"s\.toml:3:\d+: .*{message}"):
        Scene.load(tmp_path / "s.toml").build()


@pytest.mark.parametrize("act", ["write 2 00", "write 0", "write 0 1", "read 2", "read 0 0", "read 0 9999"])
def test_registers_that_are_none_are_told(act, tmp_path):
    (tmp_path / "s.toml").write_text(f'[[controller]]\nmodel = "1811"\n[[script]]\nat = 0\ndo = "{act}"\n')
    with pytest.raises(SceneError, match=r"s\.toml:5:\d+: "):
        Scene.load(tmp_path / "s.toml").build()


async def test_what_people_do_at_the_very_nanosecond_of_the_scene_s_own_acts_comes_after_them(tmp_path):
    (tmp_path / "own.talk").write_text("+0.5\n+0.5\n! input3 high\n")
    (tmp_path / "s.toml").write_text(
        '[[controller]]\nmodel = "if1"\nline = "instant"\nhost = "own.talk"\n'
        '[[script]]\nat = 0.75\ndo = "input1 high"\n[[script]]\nat = 1.0\ndo = "input1 low"\n'
    )
    session = Session(Scene.load(tmp_path / "s.toml").build, 1.0, scene=Scene.load(tmp_path / "s.toml"))
    traced, order = Traced(session, tmp_path), []
    session.each_bench(lambda bench: watch(bench, order))
    while session.seconds < 1:
        assert await session.step("event")
    session.do("if1", "input2", "high")
    session.say("if1", b"(")
    session.do("if1", "input1", "high")
    first = [*order]
    assert first == ["input1 True", "input3 True", "input1 False", "input2 True", "input1 True"]
    end_ns, found, files = session.bench.now, traced.rows(), session.save()
    order.clear()
    await session.go_to(0)
    await session.go_to(end_ns / 1e9)
    assert order == first
    assert traced.rows() == found and run_saved(files, tmp_path / "saved", end_ns / 1e9) == found


def watch(bench, order):
    for name in ("input1", "input2", "input3"):
        bench["if1"].pins[name].subscribe(lambda pin, name=name: order.append(f"{name} {pin.level}"))


async def test_programs_from_elsewhere_that_a_scene_loads_come_along(tmp_path):
    """Programs loaded by the script and by a host's conversation; another program of the same name is not replaced."""
    for place, far in (("here", 100), ("elsewhere", 250)):
        (tmp_path / place).mkdir()
        (tmp_path / place / "x.if1").write_text(f"X{far}$\n")
    (tmp_path / "elsewhere" / "y.if1").write_text("Y70$\n")
    (tmp_path / "here" / "first.talk").write_text("+4\n! load ../elsewhere/y.if1  ; instead of the first\n")
    (tmp_path / "here" / "s.toml").write_text(
        '[[controller]]\nmodel = "if1"\nname = "a"\nhost = "x.if1"\n\n'
        '[[controller]]\nmodel = "if1"\nname = "b"\nhost = "first.talk"\n\n'
        '[[script]]\nat = 5.0\non = "a"\ndo = "load ../elsewhere/x.if1"\n'
    )
    session = await session_of(Scene.load(tmp_path / "here" / "s.toml"))
    session.run()
    await asyncio.sleep(10)
    session.pause()
    files = session.save()
    assert sorted(files) == ["first.talk", "scene.toml", "x-2.if1", "x.if1", "y.if1"]
    assert 'do = "load x-2.if1"' in files["scene.toml"]
    assert files["first.talk"] == "+4\n! load y.if1  ; instead of the first\n"
    for place in ("here", "elsewhere"):
        (tmp_path / place).rename(tmp_path / f"no longer {place}")
    run_saved(files, tmp_path / "saved", session.seconds)
    again = Scene.load(tmp_path / "saved" / "scene.toml").build()
    again.run(10)
    assert [again["a"].axes["X"].position, again["b"].axes["Y"].position] == [350, 70]
