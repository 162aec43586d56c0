"""Faults of machines: switches, encoders, motors, drives, supplies."""

import pytest

from axistwin import Bench
from axistwin.bench.faults.kinds import KINDS
from axistwin.core.errors import UsageError

from ..told import raises


@pytest.fixture
def bench():
    bench = Bench()
    bench.add("if1", X={"encoder": {}, "motor": {"torque": [[0, 1.0], [5000, 1.0]]}, "load": {"torque": 0.2}})
    bench.run(1.5)
    for words in (b"(", b"U61\r"):
        bench["if1"].serial.write(words)
        bench.run(1.2)
    bench["if1"].serial.read()
    return bench


@pytest.fixture
def motor():
    bench = Bench()
    motor = bench.add("smartmotor", shaft={"motor": "frame23"})
    motor.serial.write(b"UCI UDI ZS MP A=100 V=100000 ")
    bench.run(0.5)
    return motor


def says(controller, words, seconds=0.2):
    controller.serial.write(words)
    controller.bench.run(seconds)
    return controller.serial.read()


# Terminals


def test_a_stuck_switch_keeps_its_level(bench):
    pin = bench["if1"].pins["input1"]
    fault = bench.faults.add("stuck", "if1.input1", level="high")
    assert pin.level
    pin.drive(False)
    assert pin.level
    fault.mend()
    assert not pin.level


def test_a_stuck_terminal_with_a_voltage(motor):
    pin = motor.pins["A"]
    fault = motor.bench.faults.add("stuck", "smartmotor.A", level=False)
    pin.drive(3.1)
    assert (pin.volts, pin.level) == (0.0, False)
    assert says(motor, b"UAI a=UAI Ra ") == b"0\r"
    fault.mend()
    assert pin.volts == 3.1 and says(motor, b"a=UAI Ra ") == b"1\r"


def test_a_stuck_output_of_the_pulse_generator():
    bench = Bench()
    board = bench.add("1811")
    bench.faults.add("stuck", "1811.step", level="high")
    assert board.pins["step"].level


def test_a_bouncing_switch_changes_several_times(bench):
    edges, pin = [], bench["if1"].pins["input2"]
    pin.subscribe(lambda pin: edges.append((bench.now, pin.level)))
    bench.faults.add("bounce", "if1.input2", ms=4, count=2)
    began = bench.now
    pin.drive(True)
    bench.run(0.1)
    assert edges == [(began + ms * 1_000_000, ms % 2 == 0) for ms in range(5)]
    pin.drive(False)
    bench.run(0.1)
    assert [level for _, level in edges[5:]] == [False, True, False, True, False]


def test_a_random_bounce_follows_from_its_seed(bench):
    def edges(seed):
        found, pin = [], bench["if1"].pins["input3"]
        unwatch = pin.subscribe(lambda pin: found.append(bench.now - began))
        fault = bench.faults.add("bounce", "if1.input3", ms=10, count=4, seed=seed)
        began = bench.now
        pin.drive(True)
        bench.run(0.1)
        fault.mend()
        pin.drive(False)
        unwatch()
        return found[:-1]

    assert edges(5) == edges(5) != edges(6)


def test_a_contact_that_changes_while_it_bounces_ends_at_its_last_level(bench):
    pin = bench["if1"].pins["input2"]
    bench.faults.add("bounce", "if1.input2", ms=10, count=3)
    pin.drive(True)
    bench.run(0.004)
    pin.drive(False)
    bench.run(0.1)
    assert not pin.level


@pytest.mark.parametrize("model", ["if1", "1811", "smartmotor"])
def test_an_open_limit_switch(model):
    bench = Bench()
    controller = bench.add(model)
    [(minus, plus), *_] = controller.product.limit_pins.values()
    if model == "smartmotor":
        controller.pins["C"].drive(False)
        controller.pins["D"].drive(False)
    closed = controller.product.closed_level
    fault = bench.faults.add("open_limit", model, side="plus")
    assert controller.pins[plus].level is not closed and controller.pins[minus].level is closed
    fault.mend()
    assert controller.pins[plus].level is closed


# Encoders


def test_an_encoder_loses_counts_slips_reverses_and_stops(bench):
    if1, encoder = bench["if1"], bench["if1"].axes["X"].encoder
    says(if1, b"X100$\r", 3.0)
    assert encoder.count == 1000
    fault = bench.faults.add("encoder_loses", "if1.X", every=10)
    says(if1, b"X100$\r", 3.0)
    assert encoder.count == 1900
    says(if1, b"X-100$\r", 3.0)
    assert encoder.count == 1000
    fault.mend()
    bench.faults.add("encoder_slips", "if1.X", counts=-7)
    assert encoder.count == 993
    fault = bench.faults.add("encoder_reversed", "if1.X")
    says(if1, b"X10$\r", 3.0)
    assert encoder.count == 893
    bench.faults.add("encoder_dead", "if1.X")
    bench.faults.mend("encoder_reversed")
    assert if1.axes["X"].position == 110, "the position of the motor is correct"


def test_a_servo_follows_its_faulty_encoder(motor):
    axis = motor.axes["shaft"]
    says(motor, b"P=2000 G ", 1.0)
    assert axis.position == pytest.approx(2000, abs=2)
    motor.bench.faults.add("encoder_slips", "smartmotor.shaft", counts=100)
    motor.bench.run(0.5)
    assert axis.position == pytest.approx(1900, abs=2) and int(says(motor, b"RP ")) == pytest.approx(2000, abs=2)
    motor.bench.faults.add("encoder_loses", "smartmotor.shaft", every=2)
    says(motor, b"P=2500 G ", 1.0)
    assert axis.position == pytest.approx(2900, abs=4)


def test_a_servo_with_a_reversed_encoder_has_a_position_error(motor):
    motor.bench.faults.add("encoder_reversed", "smartmotor.shaft")
    assert says(motor, b"P=2000 G ", 1.0) == b"" and says(motor, b"RBe ") == b"1\r"


def test_an_encoder_fault_remains_after_a_power_cycle(motor):
    axis = motor.axes["shaft"]
    motor.bench.faults.add("encoder_dead", "smartmotor.shaft")
    motor.power_cycle()
    motor.serial.write(b"UCI UDI ZS MT T=100 ")
    motor.bench.run(0.5)
    assert axis.position > 1000 and says(motor, b"RP ") == b"0\r"


def test_an_ideal_motor_has_no_encoder_faults():
    bench = Bench()
    bench.add("smartmotor")
    raises(UsageError, "is ideal and cannot have this fault", bench.faults.add, "encoder_dead", "smartmotor.shaft")
    bench.add("if1")
    raises(UsageError, "no encoder", bench.faults.add, "encoder_dead", "if1.X")


# Motors


def test_a_jam_at_the_exact_pulse(bench):
    if1, axis = bench["if1"], bench["if1"].axes["X"]
    fault = bench.faults.add("jam", "if1.X", when="if1.X passes 300")
    says(if1, b"X1000$\r", 5.0)
    assert axis.pulses == 1000
    assert axis.position == pytest.approx(300, abs=4), "to the nearest rotor tooth"
    (began,) = {fault.began_ns}
    assert began == axis.pulse_times()[299]


def test_a_motor_with_reduced_torque_stalls(bench):
    if1, axis = bench["if1"], bench["if1"].axes["X"]
    fault = bench.faults.add("stall", "if1.X")
    says(if1, b"X100$\r", 3.0)
    assert (axis.pulses, abs(axis.position) <= 4) == (100, True)
    fault.mend()
    bench.faults.add("stall", "if1.X", left=0.5)
    says(if1, b"X100$\r", 3.0)
    assert axis.position == pytest.approx(100, abs=4), "half of the torque is enough for this load"
    bench.faults.add("stall", "if1.X", left=0.1)
    says(if1, b"X100$\r", 3.0)
    assert axis.position == pytest.approx(100, abs=8), "a tenth of the torque is not enough"


def test_a_load_step(motor):
    axis = motor.axes["shaft"]
    fault = motor.bench.faults.add("load", "smartmotor.shaft", torque=0.05)
    assert axis.outside_torque == 0.05
    motor.bench.faults.add("load", "smartmotor.shaft", torque=-0.02)
    assert not fault.on, "the second load replaces the first"
    assert axis.outside_torque == pytest.approx(-0.02)
    motor.bench.faults.mend("all")
    assert axis.outside_torque == pytest.approx(0)


@pytest.mark.parametrize("name", ["if1", "smartmotor"])
def test_the_end_of_a_fault_keeps_the_loads_and_jams_of_the_user(name, bench, motor):
    """The user changes load and jam during a fault; the end of the fault removes only the fault's effect."""
    controller = {"if1": bench["if1"], "smartmotor": motor}[name]
    ((axis_name, axis), *_), faults = controller.axes.items(), controller.bench.faults
    load = faults.add("load", f"{name}.{axis_name}", torque=0.3)
    axis.load(0.0)
    assert axis.outside_torque == 0.3, "the load of the fault remains"
    axis.load(0.1)
    assert axis.outside_torque == pytest.approx(0.4)
    load.mend()
    assert axis.outside_torque == 0.1
    jam = faults.add("jam", f"{name}.{axis_name}")
    axis.jam(False)
    assert axis.jammed, "the jam of the fault remains"
    axis.jam(True)
    jam.mend()
    assert axis.jammed
    axis.jam(False)
    assert not axis.jammed


def test_an_ambient_temperature_set_during_a_fault_applies_after_it(motor):
    hot = motor.bench.faults.add("overheat", "smartmotor", celsius=90)
    motor.ambient = 40.0
    assert motor.ambient == 90
    hot.mend()
    assert motor.ambient == 40


def test_a_push(bench):
    bench.faults.add("push", "if1.X", counts=25)
    assert bench["if1"].axes["X"].encoder.count == 25


def test_a_servo_with_less_torque_or_voltage_is_slower(motor):
    def distance():
        before = motor.axes["shaft"].position
        says(motor, b"MT T=500 ", 0.5)
        says(motor, b"OFF ", 2.0)
        return motor.axes["shaft"].position - before

    whole = distance()
    motor.bench.faults.add("supply_dip", "smartmotor", left=0.5)
    assert distance() < 0.7 * whole
    motor.bench.faults.mend("supply_dip")
    motor.bench.faults.add("stall", "smartmotor.shaft")
    assert distance() == 0
    motor.bench.faults.mend("stall")
    assert distance() == pytest.approx(whole, rel=0.05)


def test_a_high_ambient_temperature_stops_a_motor(motor):
    motor.bench.faults.add("overheat", "smartmotor", celsius=120, when="smartmotor.shaft passes 500")
    fault = motor.bench.faults.add("stuck", "smartmotor.A", level=False, when="smartmotor raises Bh")
    says(motor, b"P=1000 G ", 1.0)
    assert motor.ambient == 120
    motor.bench.run(1000)
    assert fault.on and says(motor, b"RBh ") == b"1\r"


# Drives and supplies


@pytest.mark.parametrize(("axis", "pin"), [("X", "x_fault"), ("Y", "y_fault")])
def test_a_drive_fault_sets_its_input_and_removes_the_torque(bench, axis, pin):
    if1 = bench["if1"]
    if1.serial.write(f"{axis}1000$\r".encode())
    bench.faults.add("drive_fault", f"if1.{axis}", when=f"{axis} passes 200", here="if1")
    bench.run(5.0)
    assert not if1.pins[pin].level and if1.axes[axis].position in range(196, 206)
    assert says(if1, b"K\r") == b"16\r"


def test_a_drive_fault_of_an_1811(bench):
    board = bench.add("1811")
    bench.faults.add("drive_fault", "1811.motor", duration=0.5)
    assert not board.pins["shutdown_in"].level
    bench.run(1)
    assert board.pins["shutdown_in"].level
    raises(UsageError, "if1 has no drive fault input for axis Z", bench.faults.add, "drive_fault", "if1.Z")


@pytest.mark.parametrize("kind", ["power_cut", "supply_dip"])
def test_the_power_fails_during_a_character_of_the_answer(bench, kind):
    if1 = bench["if1"]
    bench.faults.add(kind, "if1", when="if1 says 0", duration=0.02)
    assert says(if1, b"N\r", 0.5) == b"0"
    assert says(if1, b"N\r", 0.5) == b"", "the interface must be initialised again"
    bench.run(1)
    assert says(if1, b"(", 0.5) == b"U\r"


def test_the_power_fails_while_an_output_is_switched(bench):
    if1 = bench["if1"]
    bench.faults.add("power_cut", "if1", when="if1.output1 rises")
    says(if1, b"X100S1$\r", 3.0)
    assert not if1.pins["output1"].level


# Several at once


def test_the_end_of_an_encoder_fault_does_not_end_another_one(bench):
    bench.faults.add("encoder_reversed", "if1.X")
    bench.faults.add("encoder_dead", "if1.X", duration=5)
    encoder = bench["if1"].axes["X"].encoder
    says(bench["if1"], b"X40$\r", 2)
    assert encoder.count == 0
    bench.run(4)
    says(bench["if1"], b"X40$\r", 2)
    assert encoder.count == -400
    bench.faults.mend("all")
    says(bench["if1"], b"X40$\r", 2)
    assert encoder.count == 0


def test_the_power_is_off_until_all_power_faults_have_ended(bench):
    bench.faults.add("power_cut", "if1", duration=3)
    bench.faults.add("supply_dip", "if1", duration=1)
    bench.run(2)
    assert says(bench["if1"], b"(") == b""
    bench.run(4)
    assert says(bench["if1"], b"(") == b"U\r"


# All kinds of faults

PLACES = {"LINE": "if1.serial", "PIN": "if1.input1", "AXIS": "if1.X", "CONTROLLER": "if1"}
VALUES = {
    "baud": {"baudrate": 1200}, "drift": {"percent": 1.0}, "delay": {"seconds": 0.1}, "stuck": {"level": True},
    "handshake": {"line": "dtr"}, "encoder_slips": {"counts": 3}, "load": {"torque": 0.1}, "push": {"counts": 3},
}  # fmt: skip
OF_MOTORS = ("overheat",)


@pytest.mark.parametrize("name", KINDS)
def test_the_controller_works_after_each_kind_of_fault(bench, name):
    kind = KINDS[name]
    place = PLACES[kind.on.name]
    if name in OF_MOTORS:
        bench.add("smartmotor", shaft={"motor": "frame17"})
        place = "smartmotor"
    fault = bench.faults.add(name, place, at=bench.seconds + 0.5, **VALUES.get(name, {}))
    assert fault.state.value == "waiting"
    bench.run(1.0)
    assert fault.on is not kind.at_once
    fault.mend()
    bench.run(2.0)
    if1 = bench["if1"]
    if name in ("power_cut", "supply_dip"):
        says(if1, b"(", 0.5)
        says(if1, b"U61\r", 1.2)
    says(if1, b"\rK\rF\r", 1.0)
    assert says(if1, b"N\r") == b"0\r"


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_has_descriptions(name):
    kind = KINDS[name]
    assert kind.doc and kind.begin.__doc__
    assert all(parameter.doc for parameter in kind.parameters)


@pytest.mark.parametrize(("model", "pin", "level"), [
    ("if1", "input2", False), ("if1", "estop", False), ("if1", "limit_minus", False), ("1811", "home", True),
    ("1811", "cw_limit", True), ("1811", "trigger3", True), ("smartmotor", "A", True), ("smartmotor", "C", True)
])  # fmt: skip
def test_an_open_wire_gives_an_input_the_level_without_current(model, pin, level):
    bench = Bench()
    controller = bench.add(model)
    controller.pins[pin].drive(not level)
    fault = bench.faults.add("open_wire", f"{controller.name}.{pin}")
    assert controller.pins[pin].level is level
    fault.mend()
    assert controller.pins[pin].level is not level


@pytest.mark.parametrize(("model", "pin", "words"), [
    ("if1", "led", "is an output"), ("1811", "channel_z", "use the fault `stuck`")])  # fmt: skip
def test_an_open_wire_needs_an_input_with_a_known_level(model, pin, words):
    bench = Bench()
    with pytest.raises(UsageError, match=words):
        bench.faults.add("open_wire", f"{bench.add(model).name}.{pin}")
