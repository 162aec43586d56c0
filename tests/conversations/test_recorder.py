"""A replay of a recording is identical to the nanosecond."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.bench import Do, Expect, Hear
from axistwin.bench.talk.conversation import Conversation, parse, write
from axistwin.bench.talk.player import play
from axistwin.bench.talk.recorder import recording
from axistwin.core.errors import UsageError
from axistwin.scenes.hosting import loader
from axistwin.scenes.scene import Scene
from axistwin.sim.manual_actions import by_itself
from axistwin.sim.serial_port import Flow


def replayed(conversation: Conversation) -> object:
    bench = Bench()
    bench.add("if1")
    return play(parse(write(conversation.acts)), bench)


def recorded(*doings) -> Conversation:
    bench = Bench()
    if1 = bench.add("if1")
    with recording(bench) as recorder:
        bench.run(1.5)
        for doing in doings:
            doing(if1)
            bench.run(0.5)
    return recorder.conversation()


def write_bytes(data: bytes):
    return lambda if1: if1.serial.write(data)


READY = (write_bytes(b"("), write_bytes(b"U61\r"), lambda _: None, lambda _: None)


def test_a_session():
    conversation = recorded(*READY, write_bytes(b"X100$\r"), write_bytes(b"E\r"))
    assert write(conversation.acts) == (
        "; model: if1\n"
        "+1.5\n"
        "> (\n"
        "< U\\r\n"
        "= clock 1.503229167\n"
        "+0.496770833\n"
        "> U61\\r\n"
        "+1.5\n"
        "> X100$\\r\n"
        "+0.5\n"
        "> E\\r\n"
        "< C\\r\n"
        "= clock 4.005187500\n"
        "+0.4948125\n"
        "= X.position 100\n"
    )
    assert replayed(conversation) is None


def test_a_replay_notices_a_nanosecond():
    text = write(recorded(write_bytes(b"(")).acts).replace("1.503229167", "1.503229168")
    bench = Bench()
    bench.add("if1")
    assert "clock is different" in str(play(parse(text), bench))


def test_pins_that_somebody_drives_are_acts_and_those_the_controller_sets_are_not():
    conversation = recorded(
        *READY,
        lambda if1: if1.pins["input1"].drive(True),
        write_bytes(b"S1$\r"),
        lambda if1: if1.pins["input1"].release(),
    )
    assert [act for act in conversation.acts if isinstance(act, Do)] == [Do("input1", "high"), Do("input1", "release")]
    assert replayed(conversation) is None


def test_the_hosts_lines_and_its_format_are_acts():
    def changed(if1):
        if1.serial.host.baudrate = 1200
        if1.serial.host.rts = False

    conversation = recorded(changed, write_bytes(b"("), lambda if1: if1.serial.host.rts_line.set(True))
    assert [act for act in conversation.acts if isinstance(act, Do)] == [
        Do("rts", "low"), Do("line", "1200 8N2"), Do("rts", "high"),
    ]  # fmt: skip
    assert replayed(conversation) is None


def test_a_break_is_an_act():
    conversation = recorded(*READY, lambda if1: if1.serial.send_break(0.25), write_bytes(b"F\r"))
    assert [act for act in conversation.acts if isinstance(act, Do)] == [Do("break", "0.250000000")]
    assert replayed(conversation) is None


def test_a_long_silence_before_an_answer_is_told():
    bench = Bench()
    if1 = bench.add("if1")
    with recording(bench) as recorder:
        for text, seconds in (("", 1.5), ("(", 0.5), ("U61\r", 1.5), (":P0,99:=29,1:%:$\r", 40.0)):
            if1.serial.write(text.encode())
            bench.run(seconds)
    text = write(recorder.conversation().acts)
    assert "\n+28\n< %\\r\n" in text and replayed(recorder.conversation()) is None


def test_with_two_controllers_each_line_says_which():
    bench = Bench()
    for name in ("left", "right"):
        bench.add("if1", name)
    with recording(bench) as recorder:
        bench.run(1.5)
        bench["left"].serial.write(b"(")
        bench["right"].serial.write(b"(")
        bench.run(0.1)
    heard = [act for act in recorder.conversation().acts if isinstance(act, Hear)]
    assert {(act.controller) for act in heard} == {"left", "right"}
    assert all(not act.controller for act in recorder.conversation().acts if isinstance(act, Expect))
    again = Bench()
    for name in ("left", "right"):
        again.add("if1", name)
    assert play(recorder.conversation(), again) is None


@settings(max_examples=25, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=12), st.sampled_from([b"X50$\r", b"E\r", b"#\r", b"N\r"])), max_size=6))
def test_whatever_a_host_says_can_be_replayed(messages):
    assert replayed(recorded(*READY, *map(write_bytes, messages))) is None


def of_a_machine(made, *doings):
    """Record these actions on `made(bench)`, half a second apart; replay the recording, and return it."""
    bench, again = Bench(), Bench()
    controller = made(bench)
    made(again)
    with recording(bench) as recorder:
        for doing in doings:
            bench.run(0.5)
            doing(controller)
        bench.run(0.5)
    assert play(parse(write(recorder.conversation().acts)), again) is None and again.now == bench.now
    return [f"{act.target} {act.value}" for act in recorder.conversation().acts if isinstance(act, Do)], bench, again


def test_power_is_recorded():
    acts, _bench, again = of_a_machine(
        lambda bench: bench.add("if1"),
        lambda if1: if1.power(False),
        lambda if1: if1.power(True),
        lambda if1: if1.power_cycle(),
    )
    assert acts == ["power low", "power high", "power low", "power high"]
    assert again["if1"].powered


def test_what_is_done_to_a_stepper_is_recorded():
    axis = {"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 400}}
    acts, bench, again = of_a_machine(
        lambda bench: bench.add("if1", X=axis),
        lambda if1: if1.axes["X"].jam(True),
        lambda if1: if1.axes["X"].jam(False),
        lambda if1: if1.axes["X"].load(0.0001),
        lambda if1: if1.axes["X"].encoder.displace(-40),
    )
    assert acts == ["X.jam high", "X.jam low", "X.load 0.0001", "X.push -40"]
    assert again["if1"].axes["X"].encoder.count == bench["if1"].axes["X"].encoder.count == -40
    assert again["if1"].axes["X"].outside_torque == 0.0001


def test_what_is_done_to_a_motor_is_recorded():
    acts, bench, again = of_a_machine(
        lambda bench: bench.add("smartmotor", shaft={"motor": "frame23"}),
        lambda motor: motor.axes["shaft"].load(0.25),
        lambda motor: motor.axes["shaft"].encoder.displace(12),
        lambda motor: motor.axes["shaft"].jam(),
        lambda motor: setattr(motor, "ambient", 41.5),
        lambda motor: motor.master.move(-4000, 0.25),
        lambda motor: motor.pins["A"].drive(2.5),
        lambda motor: motor.pins["index"].drive(True),
    )
    assert acts == [
        "shaft.load 0.25", "shaft.push 12", "shaft.jam high", "ambient 41.5", "master -4000 in 0.25", "A 2.5V",
        "index high",
    ]  # fmt: skip
    for one in (bench, again):
        motor = one["smartmotor"]
        assert (motor.ambient, motor.master.count, motor.axes["shaft"].jammed) == (41.5, -4000, True)
    assert again["smartmotor"].axes["shaft"].position == bench["smartmotor"].axes["shaft"].position


def test_a_joystick_is_recorded():
    acts, _bench, _again = of_a_machine(
        lambda bench: bench.add("1811"),
        lambda board: board.joystick.deflect(-100),
        lambda board: board.joystick.deflect(0),
    )
    assert acts == ["joystick -100", "joystick 0"]


def test_a_lead_that_changes_nothing_yet_is_recorded():
    """A test lead that has no effect at first holds the level of the input later."""
    acts, _bench, _again = of_a_machine(
        lambda bench: bench.add("if1"),
        lambda if1: if1.pins["input1"].drive(False),
        lambda if1: if1.pins["input1"].drive(False),
        lambda if1: if1.pins["input1"].set(True),
        lambda if1: if1.pins["input1"].release(),
    )
    assert acts == ["input1 low", "input1 release"]


def test_what_a_fault_does_is_told_as_the_fault_only():
    axis = {"encoder": {"counts_per_rev": 4000, "pulses_per_rev": 400}}
    acts, _bench, again = of_a_machine(
        lambda bench: bench.add("if1", X=axis),
        lambda if1: if1.bench.faults.add("push", "if1.X", counts=7),
        lambda if1: if1.bench.faults.add("power_cut", "if1"),
        lambda if1: if1.bench.faults.mend("power_cut"),
    )
    assert [act.split()[0] for act in acts] == ["fault", "fault", "mend"]
    assert again["if1"].axes["X"].encoder.count == 7 and again["if1"].powered


def test_what_a_scene_does_by_itself_is_left_to_the_scene():
    scene = {
        "controller": [{"model": "if1", "axes": {"X": {"encoder": {}}}}],
        "script": [{"at": 0.5, "on": "if1", "do": ["X.push 40", "power off", "power on", "input1 high"]}],
    }
    bench, again = (Scene.given(scene).build() for _ in range(2))
    with recording(bench) as recorder:
        bench.run(1)
    assert not [act for act in recorder.conversation().acts if isinstance(act, Do) and act.target != "input1"]
    assert play(parse(write(recorder.conversation().acts)), again) is None
    assert again["if1"].axes["X"].encoder.count == 40


# Actions at the host's end of a line, and at encoders


def _again(recorder, models):
    bench = Bench()
    for name, model in models.items():
        bench.add(model, name)
    assert play(parse(write(recorder.acts, recorder.codec), "again.talk"), bench) is None
    return bench


def test_an_encoder_put_on_an_axis_by_hand_sits_there_again():
    motors = {"a": "smartmotor", "b": "smartmotor"}
    bench = Bench()
    for name, model in motors.items():
        bench.add(model, name)
    with recording(bench) as recorder:
        bench.run(0.5)
        bench["a"].serial.write(b"UCI UDI ZS A=100 V=400000 MP P=4000 G ")
        bench["b"].serial.write(b"UCI UDI ZS MF4 ")
        bench.run(0.1)
        bench["b"].master.follow(bench["a"].axes["shaft"], Fraction(3, 2))
        bench.run(1)
    assert Do("master", "on a.shaft times 3/2", controller="b") in recorder.acts
    again = _again(recorder, motors)
    assert again.now == bench.now and again["b"].master.count == bench["b"].master.count != 0
    assert again["b"].axes["shaft"].position == bench["b"].axes["shaft"].position != 0


def test_a_program_loaded_while_recording_is_loaded_again():
    bench = Bench()
    motor = bench.add("smartmotor", "motor")
    with recording(bench) as recorder:
        bench.run(0.5)
        loader(bench, lambda file: "a=1 WHILE a<5 a=a+1 LOOP PRINT(a,#13) END\n")("motor", "count.sms")()
        bench.run(0.1)
        assert motor.serial.read().endswith(b"5\r")
    again = _again(recorder, {"motor": "smartmotor"})
    assert again.now == bench.now and again["motor"].programs == bench["motor"].programs


@pytest.mark.parametrize(("settle", "written"), [
    (lambda port: port.drop_pending(), "drop pending"), (lambda port: setattr(port, "held", True), "hold high"),
    (lambda port: setattr(port, "flow", Flow.X_ON_X_OFF), "flow xon"),
    (lambda port: setattr(port, "instant", True), "instant high")])  # fmt: skip
def test_what_a_host_sets_up_is_recorded_at_its_time(settle, written):
    bench = Bench()
    motor = bench.add("smartmotor", "motor")
    with recording(bench) as recorder:
        bench.run(0.5)
        motor.serial.write(b"Ra Ra Ra Ra ")
        bench.run(0.004)
        settle(motor.serial)
        bench.run(0.1)
        said = motor.serial.read()
    assert f"\n! {written}\n" in write(recorder.acts, recorder.codec)
    assert _again(recorder, {"motor": "smartmotor"})["motor"].serial.read() == said


def test_what_a_scene_s_host_sets_up_is_not_recorded():
    bench = Bench()
    motor = bench.add("smartmotor", "motor")
    with recording(bench) as recorder, by_itself(bench.clock):
        motor.serial.held = True
    assert not any(isinstance(act, Do) for act in recorder.acts)


@pytest.mark.parametrize("model", ["if1", "smartmotor"])
def test_what_is_refused_is_neither_done_nor_recorded(model):
    bench = Bench()
    controller = bench.add(model)
    (axis, *_) = controller.axes.values()
    with recording(bench) as recorder:
        for torque in (float("nan"), float("inf"), -1001.0):
            with pytest.raises(UsageError, match="expected -1000 to 1000 N·m"):
                axis.load(torque)
        with pytest.raises(UsageError):
            axis.encoder.displace(10**30)
        controller.power_cycle()
        bench.run(1)
    assert {act.target for act in recorder.acts if isinstance(act, Do)} == {"power"}
