"""Chapter 5: the static brake, its signals on pins C and G, and the mode torque brake."""

import pytest

from axistwin import Bench
from axistwin.bench import Controller

from .talking import SAMPLE_NS, advance, ask, clear, send, wired

MOVE = "A=65536 V=100*65536 P=20 G"  # a move of 1+2+3+4+4+3+2+1 = 20 counts in eight samples
FOR_EVER = "A=65536 V=65536*4 MV G"


def state(bench: Bench, motor: Controller) -> tuple[str, str, str, bool]:
    """Return mode, Bo, Bt, and the internal brake's signal."""
    mode, off, busy = send(bench, motor, "RMODE RBo RBt").decode().split()
    return mode, off, busy, motor.pins["brake"].level


def changes(bench: Bench, motor: Controller, name: str) -> list[tuple[int, bool]]:
    """Return a list that records every change of a pin, with the time in ns from now."""
    found: list[tuple[int, bool]] = []
    start = bench.now
    motor.pins[name].subscribe(lambda pin: found.append((bench.now - start, pin.level)))
    return found


# The static brake: BRKSRV, BRKTRJ, BRKRLS, BRKENG


def test_at_power_up_the_brake_is_engaged_and_mtb_is_active(bench, motor):
    """5.2: "4.76 defaults to BRKSRV being the active state, as a result, MTB is active on power-up"."""
    assert state(bench, motor) == ("B", "1", "0", True)


def test_the_brake_is_engaged_from_the_first_moment(bench):
    """2.0 item 2, 5.1: the fail-safe brake is engaged at power-up, before any command."""
    motor = bench.add("smartmotor", line="instant")
    assert motor.pins["brake"].level is True
    assert send(bench, motor, "RMODE") == b"B\r"


def test_brksrv_releases_while_the_servo_is_on(bench, motor):
    """5.2, BRKSRV: "When Status bit Bo (motor-off) is 0, MTB will be disabled.  When Bo is 1, MTB will be active"."""
    send(bench, motor, MOVE, 0.1)
    assert state(bench, motor) == ("P", "0", "0", False)
    send(bench, motor, "OFF")
    assert state(bench, motor) == ("B", "1", "0", True)


def test_brksrv_takes_effect_in_the_moment_of_g_and_of_off(bench, motor):
    """5.2: the brake changes at the same time as Bo."""
    found = changes(bench, motor, "brake")
    send(bench, motor, MOVE, 0)
    advance(bench, 20)
    send(bench, motor, "OFF", 0)
    advance(bench, 20)
    assert found == [(0, False), (20 * SAMPLE_NS, True)]


def test_brktrj_releases_for_the_trajectory_only(bench, motor):
    """5.2, BRKTRJ: "When Bt is 1, MTB will be disabled.  When Bt is 0, MTB will be active"; a move of 8 samples."""
    send(bench, motor, "BRKTRJ")
    bench.clock.run_to(-(-bench.now // SAMPLE_NS) * SAMPLE_NS)
    found = changes(bench, motor, "brake")
    send(bench, motor, MOVE, 0)
    assert send(bench, motor, "RMODE RBt", 0) == b"P\r1\r"
    advance(bench, 20)
    assert found == [(0, False), (8 * SAMPLE_NS, True)]
    assert ask(bench, motor, "RMODE") == "B"
    assert motor.axes["shaft"].position == 20


def test_brktrj_while_holding_engages_at_once(bench, motor):
    """5.2: BRKTRJ engages the brake at once while the motor holds, because Bt is 0."""
    send(bench, motor, MOVE, 0.1)
    assert motor.pins["brake"].level is False
    send(bench, motor, "BRKTRJ")
    assert motor.pins["brake"].level is True
    assert ask(bench, motor, "RMODE") == "B"


def test_brktrj_and_a_second_move(bench, motor):
    """5.2 note 1: G "will turn off MTB and switch to the associated mode", each time."""
    send(bench, motor, f"BRKTRJ {MOVE}", 0.1)
    assert motor.pins["brake"].level is True
    send(bench, motor, "P=0 G", 0)
    assert send(bench, motor, "RMODE RBt", 0) == b"P\r1\r"
    assert motor.pins["brake"].level is False
    advance(bench, 20)
    assert motor.axes["shaft"].position == 0
    assert motor.pins["brake"].level is True


@pytest.mark.parametrize("ending", ["S", "X", "OFF", "MTB"])
def test_brktrj_engages_when_a_trajectory_is_ended_early(bench, motor, ending):
    """5.2: the brake engages whenever Bt becomes 0, whatever ended the trajectory."""
    send(bench, motor, f"BRKTRJ {FOR_EVER}", 0.1)
    assert motor.pins["brake"].level is False
    send(bench, motor, ending, 0.1)
    assert ask(bench, motor, "RBt") == "0"
    assert motor.pins["brake"].level is True


def test_brkrls_and_brkeng_ignore_servo_and_trajectory(bench, motor):
    """Base 14: BRKRLS releases and BRKENG engages; the servo and trajectories have no effect on the brake."""
    brake = motor.pins["brake"]
    send(bench, motor, "BRKRLS")
    assert brake.level is False
    send(bench, motor, MOVE, 0.1)
    assert brake.level is False
    send(bench, motor, "OFF", 0.1)
    assert brake.level is False
    send(bench, motor, "BRKENG")
    assert brake.level is True
    send(bench, motor, "BRKRLS BRKRLS BRKENG BRKENG")
    assert brake.level is True
    assert ask(bench, motor, "RBs") == "0"


@pytest.mark.parametrize(("command", "engaged"), [("BRKSRV", False), ("BRKTRJ", True)])
def test_coming_back_to_automatic_control_acts_at_once(bench, motor, command, engaged):
    """5.2: while the servo holds and no trajectory is in progress, BRKSRV releases and BRKTRJ engages at once."""
    send(bench, motor, MOVE, 0.1)
    send(bench, motor, "BRKENG" if not engaged else "BRKRLS")
    assert motor.pins["brake"].level is not engaged
    send(bench, motor, command)
    assert motor.pins["brake"].level is engaged


# The signals on pins C and G


@pytest.mark.parametrize(("command", "name"), [("BRKG", "G"), ("BRKC", "C")])
def test_the_signal_is_5_volts_while_engaged_and_0_while_released(bench, motor, command, name):
    """5.1: "The signal is 0 Vdc when brake is released ... 5 Vdc when brake engaged", besides the internal brake."""
    pin, brake = motor.pins[name], motor.pins["brake"]
    send(bench, motor, f"U{name}O {command}")
    assert (pin.level, pin.volts, brake.level) == (True, 5.0, True)
    send(bench, motor, MOVE, 0.1)
    assert (pin.level, pin.volts, brake.level) == (False, 0.0, False)
    send(bench, motor, "OFF")
    assert (pin.level, pin.volts, brake.level) == (True, 5.0, True)


@pytest.mark.parametrize(("command", "name"), [("BRKG", "G"), ("BRKC", "C")])
def test_with_brktrj_the_pin_is_a_busy_trajectory_output(bench, motor, command, name):
    """5.1 notes 4, BRKTRJ: "Driven low while trajectory bit is 1"."""
    send(bench, motor, f"U{name}O {command} BRKTRJ")
    bench.clock.run_to(-(-bench.now // SAMPLE_NS) * SAMPLE_NS)
    found = changes(bench, motor, name)
    send(bench, motor, MOVE, 0)
    advance(bench, 20)
    assert found == [(0, False), (8 * SAMPLE_NS, True)]


@pytest.mark.parametrize(("command", "name"), [("BRKG", "G"), ("BRKC", "C")])
def test_with_brksrv_the_pin_is_a_motor_fault_output(bench, motor, command, name):
    """5.1 notes 3, BRKSRV: "Driven low when not faulted"; the fault in this test is a position error."""
    send(bench, motor, f"U{name}O {command} E=50 {FOR_EVER}", 0.01)
    assert motor.pins[name].level is False
    motor.axes["shaft"].jam(True)
    bench.run(0.1)
    assert ask(bench, motor, "RBe") == "1"
    assert motor.pins[name].level is True


@pytest.mark.parametrize(("command", "name"), [("BRKG", "G"), ("BRKC", "C")])
def test_without_uxo_the_pin_is_not_driven(bench, motor, command, name):
    """5.1 notes 1: UGO (UCO) "must be issued to assign Port G as an Output before the BRKG command is issued"."""
    send(bench, motor, f"U{name}I {command} {MOVE}", 0.1)
    assert motor.pins["brake"].level is False
    assert motor.pins[name].level is True  # the pull-up sets the level


def test_brki_is_the_default_and_leaves_c_and_g_alone(bench, motor):
    """5.1: the signal is on the internal brake pin only."""
    send(bench, motor, "UCO UGO UC=1 UG=1")
    found = changes(bench, motor, "C"), changes(bench, motor, "G")
    send(bench, motor, MOVE, 0.1)
    assert motor.pins["brake"].level is False
    assert found == ([], [])
    assert motor.pins["C"].level is motor.pins["G"].level is True


def test_brki_brkc_and_brkg_are_mutually_exclusive(bench, motor):
    """1.2, note: BRKI, BRKC and BRKG exclude each other; the last of them is in force."""
    send(bench, motor, "UCO UGO UC=0 UG=0 BRKC")
    assert motor.pins["C"].level is True
    send(bench, motor, "BRKG")
    assert motor.pins["G"].level is True
    before = motor.pins["C"].level
    found = changes(bench, motor, "C")
    send(bench, motor, MOVE, 0.1)
    assert motor.pins["G"].level is False
    send(bench, motor, "OFF")
    assert motor.pins["G"].level is True
    assert (motor.pins["C"].level, found) == (before, [])
    send(bench, motor, "BRKI")
    found = changes(bench, motor, "G")
    send(bench, motor, "G", 0.1)
    assert motor.pins["brake"].level is False
    assert found == []


@pytest.mark.parametrize("command", ["BRKI", "BRKC", "BRKG"])
def test_the_internal_brake_works_with_each_routing(bench, motor, command):
    """5.1: BRKC and BRKG send the signal to a pin "in addition to controlling the internal brake"."""
    send(bench, motor, f"UCO UGO {command} {MOVE}", 0.1)
    assert motor.pins["brake"].level is False
    send(bench, motor, "BRKENG")
    assert motor.pins["brake"].level is True


def test_brkc_takes_pin_c_from_the_limit(bench):
    """5.1: BRKC makes pin C an output with 5 V while engaged; this level is not taken for a limit."""
    motor = wired(bench)
    motor.pins["C"].release()
    send(bench, motor, "UCO BRKC ZS", 0.01)
    assert motor.pins["C"].level is True
    assert send(bench, motor, "RBr RBp") == b"0\r0\r"


def test_the_routing_and_the_mode_are_forgotten_at_power_off(bench, motor):
    """5.1, 5.2: after a power cycle the defaults BRKI and BRKSRV are in force again."""
    send(bench, motor, "UGO BRKG BRKTRJ BRKRLS OFF")
    motor.power(False)
    bench.run(0.1)
    motor.power(True)
    clear(bench, motor)
    assert state(bench, motor) == ("B", "1", "0", True)
    send(bench, motor, f"UGO UG=1 {MOVE}", 0.1)
    assert state(bench, motor) == ("P", "0", "0", False)
    assert motor.pins["G"].level is True


def test_a_brake_without_power_is_engaged(bench, motor):
    """5.0: the fail-safe brake is engaged while the motor has no power."""
    send(bench, motor, "BRKRLS OFF")
    motor.power(False)
    assert motor.pins["brake"].level is True


# MTB


def test_mtb_at_once(bench, motor):
    """1.2, MTB: "Immediately set mode torque brake"."""
    send(bench, motor, FOR_EVER, 0.1)
    send(bench, motor, "MTB", 0)
    assert send(bench, motor, "RMODE RBo RBt RV", 0) == b"B\r1\r0\r0\r"
    at = motor.axes["shaft"].position
    advance(bench, 40)
    assert motor.axes["shaft"].position == at


@pytest.mark.parametrize(
    ("command", "letter"), [("G", "P"), ("MT", "T"), ("MF1", "F"), ("MF2", "F"), ("MF4", "F"), ("MS", "S")]
)
def test_commands_that_turn_off_mtb(bench, motor, command, letter):
    """5.2 note 1: they "will turn off MTB and switch to the associated mode"; with BRKSRV the brake follows Bo."""
    send(bench, motor, f"MTB {command}")
    mode, off, _, brake = state(bench, motor)
    assert (mode, off, brake) == (letter, "0", False)


@pytest.mark.parametrize(
    "command", ["MP", "MV", "MFR", "MC", "MD", "BRKSRV", "BRKTRJ", "BRKENG", "P=100", "A=1", "OFF", "S", "X"]
)
def test_commands_that_leave_mtb(bench, motor, command):
    """5.2 note 1 does not name these commands, so MTB stays; a buffered mode begins with G."""
    send(bench, motor, f"BASE=1000 SIZE=10 MTB {command}")
    assert state(bench, motor)[:3] == ("B", "1", "0")


def test_brkrls_and_then_off_end_mtb(bench, motor):
    """5.2: "To turn off the dynamic brake (MTB) function issue BRKRLS and then OFF"."""
    send(bench, motor, "BRKRLS")
    assert ask(bench, motor, "RMODE") == "B"
    send(bench, motor, "OFF")
    assert ask(bench, motor, "RMODE") == "O"


def test_off_and_then_brkrls_does_not_end_mtb(bench, motor):
    """3.2: "by issuing commands BRKRLS and OFF in this sequence"."""
    send(bench, motor, "OFF BRKRLS")
    assert ask(bench, motor, "RMODE") == "B"


@pytest.mark.parametrize("between", ["BRKENG", "BRKSRV", "BRKTRJ"])
def test_mtb_stays_inactive_until_mtb(bench, motor, between):
    """5.2, BRKRLS: "stay inactive until the command MTB is issued.  Issuing BRKENG will not activate MTB"."""
    send(bench, motor, f"BRKRLS OFF {between}")
    assert ask(bench, motor, "RMODE") == "O"
    send(bench, motor, MOVE, 0.1)
    send(bench, motor, "OFF")
    assert ask(bench, motor, "RMODE") == "O"
    send(bench, motor, "MTB")
    assert ask(bench, motor, "RMODE") == "B"
    send(bench, motor, "BRKSRV G OFF")
    assert ask(bench, motor, "RMODE") == "B"


@pytest.mark.parametrize(("disable", "letter"), [("", "B"), ("BRKRLS OFF", "O")])
def test_a_limit_applies_mtb_unless_it_is_disabled(bench, disable, letter):
    """3.2 note 3.1, 5.2: BRKRLS OFF "also prevents MTB from automatically being issued upon any shaft fault"."""
    motor = wired(bench)
    send(bench, motor, f"{disable} {FOR_EVER}", 0.05)
    motor.pins["C"].drive(True)
    bench.run(0.01)
    mode, off, busy, brake = state(bench, motor)
    assert (mode, off, busy) == (letter, "1", "0")
    assert brake is (letter == "B")


def test_a_position_error_applies_mtb(bench, motor):
    """5.2 note 1C: a position error applies MTB."""
    send(bench, motor, f"E=50 {FOR_EVER}", 0.05)
    motor.axes["shaft"].jam(True)
    bench.run(0.05)
    assert send(bench, motor, "RBe RMODE RBo") == b"1\rB\r1\r"


def test_overheat_applies_mtb(bench, motor):
    """5.2 note 1B: overheat applies MTB."""
    send(bench, motor, f"THD=100 {FOR_EVER}", 0.05)
    motor.ambient = 90
    send(bench, motor, "TH=30", 0.1)
    assert send(bench, motor, "RBh RMODE RBo") == b"1\rB\r1\r"


# The pins of the signal when they change their function (5.1, 1.2)


PINS = [("BRKC", "C"), ("BRKG", "G")]


HOLD = "MP D=0 G"


def test_a_limit_role_takes_the_pin_from_the_brake(bench, motor):
    """5.1: "These commands will change the function of the I/O pin C": UCP and UCI; UCO makes an ordinary output."""
    send(bench, motor, "UC=0 UCO BRKC")
    assert motor.pins["C"].volts == 5.0
    send(bench, motor, "UCP", 0.01)
    assert ask(bench, motor, "RBp") == "1"  # Bp is 1: nothing is wired to the limit
    send(bench, motor, "UCO ZS", 0.01)
    assert motor.pins["C"].volts == 0.0
    send(bench, motor, "BRKC")
    assert motor.pins["C"].volts == 5.0


@pytest.mark.parametrize(("brake", "name"), PINS)
def test_an_output_given_again_or_late_shows_the_signal_at_once(bench, motor, brake, name):
    """5.1: "The I/O pin is set to 5 Vdc when brake engaged": no pulse of 0 V when UGO (UCO) is repeated."""
    pin = motor.pins[name]
    send(bench, motor, f"U{name}=0 {brake} U{name}O")
    assert pin.volts == 5.0
    found = changes(bench, motor, name)
    send(bench, motor, f"U{name}O")
    assert found == []
    send(bench, motor, HOLD)
    send(bench, motor, f"U{name}=1 {brake} OFF U{name}O {HOLD}")
    assert [level for _, level in found] == [False, True, False, True, False]  # HOLD, UG=1, BRKG, OFF, HOLD


@pytest.mark.parametrize(("brake", "name"), PINS)
@pytest.mark.parametrize("engaged", [True, False])
def test_the_pin_that_loses_the_signal_keeps_its_level(bench, motor, brake, name, engaged):
    """1.2: "BRKG, BRKC, and BRKI are mutually exclusive"; the pin that loses the signal keeps its level."""
    send(bench, motor, f"U{name}={0 if engaged else 1} U{name}O {brake}" + ("" if engaged else f" {HOLD}"))
    found = changes(bench, motor, name)
    send(bench, motor, "BRKI BRKENG BRKRLS BRKSRV")
    assert (motor.pins[name].level, found) == (engaged, [])
    send(bench, motor, f"U{name}O")
    assert motor.pins[name].level is not engaged  # the level of the pin's output latch
