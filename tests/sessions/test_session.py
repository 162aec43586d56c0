"""A session is run, paused, stepped, stopped by breakpoints, taken back in time and continued differently."""

import asyncio
import json
import logging

import pytest

from axistwin import Session
from axistwin.core.errors import ProgramError, UsageError
from axistwin.core.units import MS, to_ns
from axistwin.sim.frames import UartFormat
from axistwin.sim.serial_port import Flow

from ..benches import bench_of
from .driving import drive, until

MOVE = b"X100@1000S1$\r"
READY = b"UCI UDI ZS A=100 V=400000 MP O=0 "


if1 = bench_of("if1", X={"limits": (-100, 5000)})


motor = bench_of("smartmotor motor")


async def ready() -> Session:
    session = Session(if1, 1.0)
    session.run()
    await asyncio.sleep(1.5)
    session.say("if1", b"(")
    await asyncio.sleep(0.1)
    session.say("if1", b"U61\r")
    await asyncio.sleep(1.3)
    return session


def position(session):
    return session.bench["if1"].axes["X"].position


async def test_time_passes_while_it_runs_and_at_the_speed_that_is_set():
    session = Session(if1, 1.0)
    session.do("if1", "input1", "high")
    await asyncio.sleep(1)
    assert (session.running, session.seconds) == (False, 0)
    session.run()
    await asyncio.sleep(1)
    session.pause()
    assert session.seconds == pytest.approx(1, abs=0.01)
    session.speed = 0.1
    session.run()
    await asyncio.sleep(1)
    session.pause()
    assert session.seconds == pytest.approx(1.1, abs=0.01)
    assert (session.speed, session.running, session.halted_by) == (0.1, False, "")


async def test_a_break_stops_in_the_middle_of_a_move_on_that_very_pulse():
    session = await ready()
    stop = session.add_break("if1.X passes 30")
    session.say("if1", MOVE)
    await until(lambda: not session.running)
    assert position(session) == 30 and (session.halted_by, stop.hits) == ("break: if1.X passes 30", 1)
    stop.on = False
    session.run()
    await asyncio.sleep(2)
    assert (position(session), session.running, session.halted_by) == (100, True, "")
    session.remove_break(stop)
    assert session.breaks == []


async def test_a_break_stops_at_full_speed_too():
    session = await ready()
    session.add_break("if1.X passes 99")
    session.say("if1", MOVE)
    session.speed = None
    await until(lambda: not session.running)
    assert position(session) == 99


async def test_run_until_is_for_once():
    session = await ready()
    session.say("if1", MOVE)
    session.run_until("if1.X passes 50")
    await until(lambda: not session.running)
    assert (position(session), session.halted_by) == (50, "if1.X passes 50")
    session.say("if1", b"X-100$\r")
    session.run_until("if1.X passes 80")
    session.pause()
    assert session.halted_by == ""
    session.run()
    await asyncio.sleep(2)
    assert session.running
    with pytest.raises(UsageError, match="passes"):
        session.run_until("if1.X comes to 5")
    with pytest.raises(UsageError, match="unknown axis"):
        session.add_break("if1.Q passes 5")


async def test_steps():
    session = await ready()
    session.pause()
    session.say("if1", MOVE)
    began_ns = session.bench.now
    assert not session.bench["if1"].axes["X"].moving and await session.step("move")
    assert session.bench["if1"].axes["X"].moving and began_ns < session.bench.now < began_ns + 100 * MS
    assert await session.step("move") and position(session) == 100
    assert not session.bench["if1"].axes["X"].moving
    session.say("if1", b"E\r")
    levels = []
    session.bench["if1"].serial.subscribe_received(lambda *_: levels.append(session.bench.now))
    assert await session.step("event") and levels in ([], [session.bench.now])
    with pytest.raises(
        UsageError, match="unknown kind of step 'jump': expected one of event, character, statement, move"
    ):
        await session.step("jump")
    assert not session.running


def test_a_message_is_one_event_and_its_characters_are_steps():
    async def steps_of(kind):
        session = await ready()
        session.pause()
        session.say("if1", b"N\r")
        heard, steps = bytearray(), 0
        session.bench["if1"].serial.subscribe_received(lambda byte, _: heard.append(byte))
        while not heard.endswith(b"\r"):
            assert await session.step(kind)
            steps += bool(heard)
        return bytes(heard), steps

    assert drive(steps_of("character")) == (b"0\r", 2) and drive(steps_of("event")) == (b"0\r", 1)


async def test_a_restart_begins_again_and_can_be_undone():
    session = await ready()
    session.say("if1", MOVE)
    await asyncio.sleep(2)
    assert position(session) == 100
    session.pause()
    end_ns, journal = session.bench.now, list(session.journal)
    session.restart()
    assert (session.running, session.seconds, list(session.journal)) == (True, 0.0, [])
    await asyncio.sleep(0.5)
    assert session.undo_seconds > 0
    await session.undo()
    assert (session.running, session.repeating, session.seconds) == (False, True, 0.0)
    assert (to_ns(session.recorded_seconds), list(session.journal)) == (end_ns, journal)
    await session.go_to(session.recorded_seconds)
    assert (position(session), session.undo_seconds) == (100, 0)
    with pytest.raises(
        UsageError, match="cannot undo a deletion: no part of the recording has been deleted since the last undo"
    ):
        await session.undo()


async def test_an_act_in_a_replay_can_be_undone():
    session = await ready()
    session.say("if1", MOVE)
    await asyncio.sleep(2)
    session.pause()
    end_s = session.recorded_seconds
    await session.go_to(0.5)
    session.do("if1", "input1", "high")
    assert session.recorded_seconds == 0.5
    await session.undo()
    assert (session.seconds, session.recorded_seconds) == (0.5, end_s) and not session.bench["if1"].pins["input1"].level


@pytest.mark.parametrize("running", [False, True])
async def test_a_later_time_is_reached_at_full_speed(running):
    session = await ready()
    if not running:
        session.pause()
    session.say("if1", MOVE)
    await session.advance_to(1000)
    assert (position(session), session.running) == (100, running) and session.seconds == 1000
    with pytest.raises(UsageError, match=r"999 s has already passed: expected a time after 1000.000 s"):
        await session.advance_to(999)


async def test_a_breakpoint_ends_the_way_to_a_later_time():
    session = await ready()
    session.say("if1", MOVE)
    session.add_break("if1.X passes 50")
    await session.advance_to(1000)
    assert (position(session), session.running, session.halted_by) == (50, False, "break: if1.X passes 50")


async def test_virtual_time_waits_for_the_first_visitor():
    session = Session(if1, 1.0)
    session.wait()
    await asyncio.sleep(1)
    assert (session.seconds, session.running, session.waiting) == (0, False, True)
    session.welcome()
    assert (session.running, session.waiting) == (True, False)
    session.pause()
    session.welcome()
    assert not session.running, "only the first visitor starts virtual time"


async def test_a_step_where_nothing_happens_tells_so():
    session = Session(if1, 1.0)
    session.speed = None
    session.run()
    await asyncio.sleep(0.1)
    assert not await session.step("move") and session.seconds < 61


async def test_who_is_on_the_way_may_give_up_and_stands_where_he_has_come_to(monkeypatch):
    session = await ready()
    session.pause()
    end_s = session.recorded_seconds
    monkeypatch.setattr("axistwin.links.pacing.SLICE_S", 0.0)
    going = asyncio.ensure_future(session.go_to(2.0))
    while not session.seconds < end_s:
        await asyncio.sleep(0)
    session.give_up()
    await going
    assert (session.busy, session.progress, session.repeating) == (False, None, True) and session.seconds < 2.0
    monkeypatch.undo()
    await session.go_to(end_s)
    assert (session.seconds, position(session)) == (end_s, 0)
    session.give_up()  # no step or go_to is active
    assert await session.step("event") is False


async def test_statements_of_a_stored_program_are_stepped():
    session = Session(motor, 1.0)
    session.run()
    await asyncio.sleep(1)
    session.load("motor", "count.sms", "WAIT=400\na=1\na=2\nb=3\nEND\n")
    found = []
    for _ in range(4):
        assert await session.step("statement")
        registers = session.bench["motor"].registers
        found.append((registers["Ra"].read(), registers["Rb"].read()))
    assert found == [(0, 0), (1, 0), (2, 0), (2, 3)]


async def test_a_step_stops_at_a_break():
    session = await ready()
    session.say("if1", MOVE)
    assert await session.step("move")
    session.add_break("if1.X passes 10")
    assert not await session.step("move") and (position(session), session.halted_by) == (10, "break: if1.X passes 10")


async def test_a_servo_is_stepped_to_the_end_of_its_motion():
    session = Session(motor, None)
    session.say("motor", READY + b"P=300 G ")
    assert await session.step("move") and await session.step("move")
    axis = session.bench["motor"].axes["shaft"]
    assert (axis.position, axis.moving) == (300, False)


async def test_back_in_time_and_on_into_the_recorded_future():
    session = await ready()
    session.say("if1", MOVE)
    await asyncio.sleep(2)
    session.pause()
    first, end_s = session.bench, session.seconds
    stop, seen = session.add_break("if1.X passes 50"), []
    session.each_bench(seen.append)
    await session.go_to(2.0)
    assert session.bench is not first and seen == [first, session.bench]
    assert (session.seconds, session.repeating, session.progress, session.running) == (2.0, True, None, False)
    assert session.recorded_seconds == end_s and position(session) == 0
    assert stop.hits == 0
    session.run()
    await until(lambda: not session.running)
    assert (position(session), stop.hits, session.repeating) == (50, 1, True)
    stop.on = False
    session.run()
    await until(lambda: not session.repeating)
    assert position(session) == 100 and session.running


async def test_who_does_something_in_the_past_begins_another_future():
    session = await ready()
    session.say("if1", MOVE)
    await asyncio.sleep(1)
    await session.go_to(session.seconds - 1.5)
    here_s = session.seconds
    with pytest.raises(ProgramError, match="unknown name 'input9'"):
        session.do("if1", "input9", "high")
    assert session.repeating
    session.do("if1", "input1", "high")
    assert (session.repeating, session.recorded_seconds) == (False, here_s)
    session.run()
    await asyncio.sleep(2)
    assert position(session) == 0


async def test_the_rest_can_be_forgotten_by_hand():
    session = await ready()
    session.say("if1", MOVE)
    await session.go_to(1.0)
    session.forget_rest()
    assert (session.repeating, session.recorded_seconds) == (False, 1.0) and list(session.journal) == []


async def test_what_has_not_been_recorded_cannot_be_gone_to():
    session = await ready()
    for seconds in (-1, 1000):
        with pytest.raises(UsageError, match="is not recorded: expected 0 to"):
            await session.go_to(seconds)


async def test_nobody_does_anything_while_it_is_on_its_way():
    session = await ready()
    going = asyncio.ensure_future(session.go_to(1.0))
    await asyncio.sleep(0)
    with pytest.raises(UsageError, match="wait until the method `step` or `go_to` has returned"):
        session.do("if1", "input1", "high")
    with pytest.raises(UsageError, match="wait until the method `step` or `go_to` has returned"):
        session.run()
    await going
    session.do("if1", "input1", "high")
    assert session.seconds == 1.0


async def test_hosts_and_faults_of_the_bench_itself_are_not_from_outside():
    def build():
        bench = if1()
        bench.faults.add("baud", "if1.serial", baudrate=1200, at=0.5)
        bench.clock.call_later(1, lambda: bench["if1"].serial.write(b"("))
        return bench

    session = Session(build, 1.0)
    session.run()
    await asyncio.sleep(1)
    assert list(session.journal) == []
    session.do("if1", "fault", "baud 300")
    session.pause()
    assert [act.target for moment in session.journal for act in moment.acts] == ["fault"]


async def test_a_host_s_acts_at_its_line_are_kept_with_their_values():
    session = Session(if1, 1.0)
    session.serve()
    port = session.input.serial("if1")
    port.flow = Flow.X_ON_X_OFF
    port.host.format = UartFormat(1200, 8, "N", 2)
    port.host.dtr = False
    port.held = True
    port.send_break(0.25)
    port.write(b"A; \r")
    port.drop_pending()
    acts = [getattr(act, "data", None) or f"{act.target} {act.value}" for m in session.journal for act in m.acts]
    assert acts == [
        "flow xon", "line 1200 8N2", "dtr low", "hold high", "break 0.250000000", b"A; \r", "drop pending",
    ]  # fmt: skip


async def test_what_is_kept_without_power_is_as_it_was_at_the_beginning(tmp_path):
    build = bench_of("smartmotor motor", state=tmp_path)
    file = tmp_path / "motor.json"
    session = Session(build, 1.0)
    old = session.bench
    session.run()
    await asyncio.sleep(1)
    session.load("motor", "home.sms", SOURCE)
    session.do("motor", "power", "off")
    kept, end_s = file.read_text(), session.seconds
    await session.go_to(0.5)
    assert not file.exists()
    old["motor"].store.save(b"{}")
    assert not file.exists()
    await session.go_to(end_s)
    assert file.read_text() == kept
    json.loads(kept)


async def test_a_full_journal_is_told_and_bounds_how_far_one_can_go(caplog):
    session = Session(if1, 1.0)
    session.journal._max_bytes = 500
    session.run()
    with caplog.at_level(logging.WARNING):
        for n in range(4):
            await asyncio.sleep(0.1)
            session.say("if1", b"%d" % n)
    session.pause()
    assert session.recorded_seconds < 0.4 < session.seconds
    assert caplog.text.count("the journal is full: acts after 0.3") == 1
    await session.go_to(session.recorded_seconds)
    session.run()
    await asyncio.sleep(0.1)
    session.say("if1", b"live")
    assert not session.repeating


SOURCE = "a=1\nP=100\nG TWAIT\na=2\nEND\n"
BROKEN = "a=1\nQQQ=5\nEND\n"


async def test_a_source_is_loaded_into_a_motor_in_the_middle_of_a_motion_and_run():
    session = Session(motor, 1.0)
    session.say("motor", READY + b"MV V=200000 G ")
    session.run()
    await asyncio.sleep(0.3)
    session.say("motor", b"RP " * 20)
    session.load("motor", "home.sms", "UCI UDI ZS A=100 V=400000 MP O=0\n" + SOURCE)
    await asyncio.sleep(2)
    assert session.bench["motor"].registers["Ra"].read() == 2
    session.pause()
    await session.go_to(0.1)
    await session.go_to(session.recorded_seconds)
    assert session.bench["motor"].registers["Ra"].read() == 2


async def test_an_act_that_fails_half_way_leaves_the_pacer_awake(monkeypatch):
    session = Session(motor, None)
    session.run()

    def fail() -> None:
        session.bench.clock.call_later(MS, lambda: None)
        raise UsageError("half-way")

    monkeypatch.setattr(session.input.runner, "prepare", lambda act: fail)
    with pytest.raises(UsageError, match="half-way"):
        session.do("motor", "load", "long.sms")
    await until(lambda: session.bench.clock.quiet)


async def test_command_lines_are_sent_by_a_host_and_what_is_wrong_is_told_with_its_place():
    session = await ready()
    session.load("if1", "moves.if1", "X100$\n")
    await asyncio.sleep(6)
    assert position(session) == 100
    before = len(list(session.journal))
    with pytest.raises(ProgramError, match=r"bad\.if1:2:\d+: "):
        session.load("if1", "bad.if1", "X100$\nX99999999999$\n")
    with pytest.raises(UsageError, match="is a program for smartmotor, not for if1"):
        session.load("if1", "home.sms", SOURCE)
    with pytest.raises(UsageError, match="cannot load"):
        session.load("if1", "moves.talk", "> X")
    assert len(list(session.journal)) == before
