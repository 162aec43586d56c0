"""The state of a machine in words: a row for each line of the table, for each family, and for devices of others."""

import asyncio
from pathlib import Path

import pytest

from axistwin import Bench, Session
from axistwin.bench import product
from axistwin.controllers.product import Awaited, Listing
from axistwin.scenes.scene import Scene
from axistwin.scenes.sessions.buttons import perform
from axistwin.scenes.sessions.condition import Kind, condition, condition_of
from axistwin.ui.conversation.first import first_steps

from ..benches import bench_of

EXAMPLES = Path(__file__).parents[2] / "examples"
CYCLE = "Switch the power off and on, then press Start"
BOTH = "Both limit inputs are active (Bp, Bm): wire pins C and D to ground, or make them inputs, and clear the fault"
START = "The {} is on. Press Initialise, or begin with the lessons"


def told(state):
    """Return words, tone and next step of a state, and its buttons: the filled one has a star."""
    return state.words, str(state.tone), state.next, [each.label + "*" * each.filled for each in state.buttons]


def session_of(scene):
    found = Scene.load(EXAMPLES / scene / "scene.toml")
    return Session(found.build, scene=found)


async def press(session, label):
    """Press a button of the present state."""
    state = condition(session)
    (button,) = (each for each in state.buttons if each.label == label)
    await perform(session, button, state.controller)


async def test_the_drill_from_its_first_visitor_to_its_second_pass():
    session = session_of("drill")
    session.wait()
    assert condition(session).words == "Paused at 0 s until a browser or a host connects"
    session.run()
    await session.advance_to(1)
    assert told(condition(session)) == ("Running", "grey", "The host sends its program", [])
    await session.advance_to(5)
    waiting = ("Waiting for input 2 (Start)", "blue", "Press Start", [])
    assert told(condition(session)) == waiting
    assert condition(session).pin == "table.input2"
    await session.advance_to(6.5)
    off = ("Power off", "grey", "Script: power on at 8 s", ["Power on*", "Go there"])
    assert told(condition(session)) == off
    await press(session, "Go there")
    assert session.seconds == 8
    await session.advance_to(11.2)
    assert told(condition(session)) == ("Running", "grey", "X moves to 20 mm, step 2 of 14: X1600", [])
    session.pause()
    assert told(condition(session)) == ("Paused", "grey", "Press Run. X moves to 20 mm, step 2 of 14: X1600", ["Run*"])
    await press(session, "Run")
    await session.advance_to(20.15)
    session.do("table", "estop", "low")
    stopped = ("Stopped: emergency stop pressed", "red", f"Release it, {CYCLE[0].lower()}{CYCLE[1:]}")
    stopped += (["Release Emergency stop*"],)
    assert told(condition(session)) == stopped
    session.pause()
    assert condition(session).words == "Stopped: emergency stop pressed (paused)"
    session.run()
    await press(session, "Release Emergency stop")
    assert told(condition(session)) == ("Stopped after an emergency stop", "red", CYCLE, ["Power off and on*"])
    await press(session, "Power off and on")
    assert told(condition(session)) == ("Starting", "grey", "The self-test takes about a second", [])
    await session.advance_to(session.seconds + 3)
    assert told(condition(session))[:2] == waiting[:2]
    session.do("table", "input2", "high")
    await session.advance_to(session.seconds + 0.3)
    assert condition(session).kind is Kind.RUNNING
    session.do("table", "input2", "low")
    await session.advance_to(120)  # its sequence is endless: the scene's script has ended long ago
    assert told(condition(session)) == waiting


async def test_a_sequence_that_begins_displaced_says_where_the_axes_stand():
    session = session_of("drill")
    await session.advance_to(13)  # X rests at the second hole of the first row.
    here = ": the sequence begins at X 40 mm, not at 0"
    session.do("table", "estop", "low")
    assert condition_of(session, "table").next.endswith(f"then press Start{here}"), "as soon as it is known"
    for target, value in (("estop", "high"), ("power", "off"), ("power", "on")):
        session.do("table", target, value)
    await session.advance_to(16)
    state = ("Waiting for input 2 (Start)", "blue", f"Press Start{here}", [])
    assert told(condition(session, running=True)) == state
    session.do("table", "input2", "high")
    assert condition(session).next == "Press Run. X moves to 60 mm, step 2 of 14: X1600", "displaced, as it says"


async def test_a_journey_a_replay_a_break_and_the_end():
    session = session_of("winder")
    session.run()
    session.add_break("traverse.motor passes 1000")
    journey = asyncio.ensure_future(session.advance_to(40))
    await asyncio.sleep(0)
    assert told(condition(session)) == ("Going to 40 s", "grey", "", ["Stop"])
    await journey
    assert condition(session).words == "Paused: break: traverse.motor passes 1000"
    session.remove_break(session.breaks[0])
    session.run()
    await session.advance_to(40)
    assert told(condition(session)) == ("The scene has ended", "grey", "Restart, or operate by hand", ["Restart"])
    await session.go_to(12.4)
    words = "Live from here ends the replay, and the machine can be operated"
    assert told(condition(session)) == ("Replay at 12.4 s", "blue", words, ["Live from here"])
    await press(session, "Live from here")
    assert told(condition(session))[0::2] == ("Paused", "Press Run. The host sends its program")
    await session.advance_to(40)
    session.run()
    await press(session, "Restart")
    assert (session.seconds, condition(session).kind) == (0, Kind.RUNNING)


async def test_of_several_controllers_the_state_names_the_one_that_it_is_about():
    session = Session(bench_of("if1 feeder", "smartmotor knife"))
    session.run()
    await session.advance_to(2)
    assert told(condition(session))[:2] == ("feeder: waiting for a command", "blue")
    session.do("knife", "power", "off")
    assert condition(session).words == "knife: power off"
    session.do("feeder", "estop", "low")
    session.do("knife", "power", "on")
    assert condition(session).words == "feeder: stopped: emergency stop pressed"


# One row for each family and state: model, options, what is done, and what the state says


def said(*lines):
    return [line if isinstance(line, tuple) else (line, 0.3) for line in lines]


LIMITED = {"axes": ("X", {"limits": [-100, 500]})}
READY = (("(", 0.5), ("U61\r", 2))
ROWS = [
    ("if1", {}, [], ("Waiting for a command", "blue", START.format("IF1"), ["Initialise*", "Lessons"])),
    ("if1", {}, READY, (
        "Waiting for a command", "blue", "Type X1000$: index X by 1000 steps", ["Send X1000$*", "Lessons"])),
    ("if1", {}, (*READY, ("X5000$\r", 0.5)), ("Running", "grey", "X moves to 5000 pulses", [])),
    ("if1", {"X": {"limits": [-100, 500]}}, (*READY, ("X5000$\r", 3)), (
        "Stopped: X at the plus limit", "red", "X stands on the switch: move away in minus: type K, then type X-101$",
        ["Send K*"])),
    ("if1", {"X": {"limits": [-100, 500]}}, (*READY, ("X5000$\r", 3), ("K\r", 1)), (
        "Stopped: X at the plus limit", "red", "X stands on the switch: move away in minus: type X-101$",
        ["Send X-101$*"])),
    ("if1", {}, (*READY, "! limit_minus low"), (
        "Cannot move: minus limit active", "red", "Click the switch limit_minus again, then type K",
        ["Release limit minus*"])),
    ("if1", {}, (*READY, "! limit_minus low", "! limit_minus release"), (
        "Cannot move: limit fault", "red", "Type K", ["Send K*"])),
    ("if1", {}, (*READY, "! x_fault low"), (
        "Cannot move: the drive of X reports a fault", "red", "Click the switch x_fault again, then type K",
        ["Release x fault*"])),
    ("if1", {}, (*READY, "! estop low"), ("Stopped: emergency stop pressed", "red", "Release it", ["Release estop*"])),
    ("if1", {}, (*READY, "! estop low", "! estop release"), (
        "Stopped after an emergency stop", "red", "Type K", ["Send K*"])),
    ("if1", {}, (*READY, (":H2:X10:$\r", 2)), (
        "Waiting for input 2 high (step 1)", "blue", "Click the switch input2", ["Set input2 high*"])),
    ("if1", {}, (*READY, ("Xfoo$\r", 1)), ("A message was refused", "amber", "Type F", ["Send F*", "Lessons"])),
    ("if1", {}, ("! power off",), ("Power off", "grey", "Switch the power on", ["Power on*"])),
    ("if2", {}, (*READY, (":X400:$\r", 3), ("[\r", 1)), (
        "The stored sequence has ended", "grey", "Switch the power off and on", ["Power off and on"])),
    ("1811", {}, [], ("Waiting for a command", "blue",
        ("A move needs velocity and acceleration: 31h has not been given: "
        "type default_velocity_and_acceleration 00 25000 250000"), ["Send it*", "Lessons"])),
    ("1811", {}, ("default_velocity_and_acceleration 00 25000 250000",), ("Waiting for a command", "blue",
        "Type go_relative 25000: one revolution of a 25000 step motor (33h)", ["Send go_relative 25000*", "Lessons"])),
    ("1811", {}, ("default_velocity_and_acceleration 00 25000 250000", ("go_relative 100000", 0.5)), (
        "Running", "grey", "Motor moves to 100000 pulses", [])),
    ("1811", {}, ("! cw_limit high",), (
        "Cannot move: plus limit active", "red", "Click the switch cw_limit again", ["Release cw limit*"])),
    ("1811", {}, ("D9 01", "2C 02 00", "D8", "41 01"),
        ("Waiting for trigger 2 low (step 1)", "blue", "Click the switch trigger2", ["Set trigger2 low*"])),
    ("smartmotor", {}, [], ("Waiting for a command: both limit inputs active", "blue",
        START.format("SmartMotor"), ["Initialise*", "Lessons"])),
    ("smartmotor", {}, ("P=100 G ",), ("Cannot move: both limit inputs active", "red",
        f"{BOTH}: type UCI UDI ZS", ["Send UCI UDI ZS*"])),
    ("smartmotor", {}, ("UDI ZS P=100 G ",), ("Cannot move: plus limit active", "red",
        "The plus limit is active (Bp): wire pin C to ground, or make it an input, and clear the fault: type UCI ZS",
        ["Send UCI ZS*"])),
    ("smartmotor", {}, ("UCI UDI ZS ",), (
        "Waiting for a command", "blue", "No acceleration has been given: type A=100", ["Send A=100*", "Lessons"])),
    ("smartmotor", {}, ("UCI UDI ZS A=100 V=100000 MV G ",), ("Running", "grey", "Shaft moves in plus", [])),
    ("smartmotor", {}, ("SLEEP ",), ("Waiting for a command", "blue",
        "Asleep, so that it ignores all commands but WAKE: type WAKE", ["Send WAKE*", "Lessons"])),
]  # fmt: skip


@pytest.mark.parametrize(("model", "options", "lines", "state"), ROWS)
def test_a_state_of_a_family(model, options, lines, state):
    bench = Bench()
    controller = bench.add(model, "it", **options)
    session = Session(lambda: bench, None)
    bench.run(1.5)
    for line, seconds in said(*lines):
        if line.startswith("! "):
            session.do("it", *line[2:].split())
        elif controller.product.language is not None:
            session.say("it", controller.product.language.read(line))
        else:
            session.say("it", line.encode())
        bench.run(seconds)
    assert told(condition_of(session, "it")) == state


def other(**abilities):
    """Return a session with a device that is none of ours: an IF1's terminals, and these abilities alone."""
    ours = product("if1")

    def build(*given):
        device = ours.build(*given)
        own = device.abilities
        device.abilities = type(own)(uart=own.uart, handshake=own.handshake, **abilities)
        return device

    bench = Bench()
    bench.add(ours._replace(model="lift", title="A lift", family="", build=build, check=None), "it")
    return Session(lambda: bench, None)


@pytest.mark.parametrize(("abilities", "acts", "state"), [
    ({}, (), ("Waiting for a command", "blue", "Type a command, or let a host send one", [])),
    ({}, (("power", "off"),), ("Power off", "grey", "Switch the power on", ["Power on*"])),
    ({}, (("estop", "low"),), ("Stopped: emergency stop pressed", "red", "Release it", ["Release estop*"])),
    ({}, (("limit_plus", "low"),), (
        "Cannot move: plus limit active", "red", "Click the switch limit_plus again", ["Release limit plus*"])),
    ({}, (("y_fault", "low"),), (
        "Cannot move: the drive of Y reports a fault", "red", "Click the switch y_fault again", ["Release y fault*"])),
    ({"hint": lambda: "the door is open: close it"}, (), ("Cannot move: the door is open", "red", "Close it", [])),
    ({"awaited": lambda: Awaited("step 3 of the sequence", "input1", "high")}, (), (
        "Waiting for input 1 high (step 3)", "blue", "Click the switch input1", ["Set input1 high*"])),
    ({"programs": lambda: {"p": Listing("the program", ("up", "down"), 1)}}, (), (
        "Running", "grey", "Step 2 of 2: down", [])),
    ({"programs": lambda: {"p": Listing("the program", ("up",), None, ended_by="a jam")}}, (), (
        "Stopped: a jam has ended the program", "red", "", [])),
    ({"ignoring": lambda: "it is in local mode"}, (), (
        "Waiting for a command", "blue", "The device ignores commands: it is in local mode", [])),
    ({"busy": lambda: True}, (), ("Running", "grey", "", [])),
])  # fmt: skip
def test_a_state_of_a_device_of_others(abilities, acts, state):
    session = other(**abilities)
    for target, value in acts:
        session.do("it", target, value)
    assert told(condition_of(session, "it")) == state


def test_a_limit_input_of_one_axis_names_the_axis():
    ours = product("if1")
    bench = Bench()
    bench.add(ours._replace(model="lift", family="", check=None, limit_pins={"2": ("limit_minus", "limit_plus")}), "it")
    session = Session(lambda: bench, None)
    session.do("it", "limit_minus", "low")
    assert condition_of(session, "it").words == "Cannot move: axis 2 at the minus limit"


async def test_the_buttons_make_an_if1_ready_and_clear_its_fault():
    session = Session(bench_of("if1"))
    session.run()
    await session.advance_to(2)
    await press(session, "Initialise")
    await session.advance_to(session.seconds + 2)
    assert condition(session).next == "Type X1000$: index X by 1000 steps"
    session.do("if1", "estop", "low")
    await press(session, "Release estop")
    await press(session, "Send K")
    await session.advance_to(session.seconds + 1)
    assert condition(session).words == "Waiting for a command"


async def test_the_next_line_of_a_smartmotor_asks_for_what_is_missing():
    session = Session(bench_of("smartmotor"))
    session.run()
    await session.advance_to(1)
    await press(session, "Initialise")
    for line, says in (
        ("A=100", "No acceleration has been given: type A=100"),
        ("V=100000", "No velocity has been given: type V=100000"),
        ("P=4000", "Type P=4000: go to position 4000"), ("G", "Type G: start the move"),
    ):  # fmt: skip
        state = condition(session)
        assert told(state) == ("Waiting for a command", "blue", says, [f"Send {line}*", "Lessons"])
        await press(session, f"Send {line}")
        await session.advance_to(session.seconds + 0.2)
    assert told(condition(session))[0] == "Running"
    await session.advance_to(session.seconds + 3)
    done = ("Waiting for a command", "blue", "Type a command, or let a host send one", ["Lessons"])
    assert told(condition(session)) == done
    session.say("smartmotor", b"P=9000 ")
    await session.advance_to(session.seconds + 0.2)
    assert told(condition(session))[2:] == ("Type G: start the move", ["Send G*", "Lessons"])


async def test_the_next_line_of_an_if1_asks_for_nothing_after_its_first_move():
    session = Session(bench_of("if1"))
    session.run()
    await session.advance_to(2)
    await press(session, "Initialise")
    await session.advance_to(session.seconds + 1)
    await press(session, "Send X1000$")
    await session.advance_to(session.seconds + 5)
    assert (session.bench["if1"].axes["X"].position, condition(session).next) == (
        1000,
        "Type a command, or let a host send one",
    )


@pytest.mark.parametrize(("model", "line"), [("if1", "X1000$"), ("smartmotor", "A=100 V=100000 P=4000 G")])
def test_the_card_of_first_steps_names_the_same_first_move_as_the_next_line(model, line):
    bench = Bench()
    assert f"Type  {line}  below" in first_steps(bench.add(model, "it"))[-1].words
