"""Clearing fault conditions: emergency stop, drive faults, clear-on-read, the LED, output 5 as fault output."""

import pytest

from axistwin.units import MS, S

from .talking import (
    ask,
    command,
    edges,
    gaps,
    number,
    play,
    positions,
    ready,
    scripts,
    send,
    status,
    status_word,
    times,
    until_idle,
    write,
)

DRIVE_FAULTS = ("x_fault", "y_fault")


def break_drive(controller, name: str) -> None:
    """Raise a drive fault: drive the pin to the level opposite to normal."""
    controller.pins[name].drive(not controller.pins[name].level)


@scripts(
    {
        'Clearing: "32 <CR>"; once removed again "32 <CR>" "but this time the fault bit will be cleared"':
        "estop low; 0.1 s; K: 32; K: 32; estop released; 0.1 s; K: 32; K: 0",
        'Clearing: "will reset the relevant fault bit provided the fault is no longer present"':
        "estop low; 0.01 s; estop released; 1 s; K: 32; K: 0; K: 0",
        'Emergency stop: "can be used to inhibit all movement"':
        "estop low; 0.1 s; K?; X100@400$; X-100@400$; 1 s; K?; X100@400$; X-100@400$; 1 s; K?; X100@400$; "
        "X-100@400$; 1 s; at 0 0 0",
        "Optional fault output: the link must be transferred first":
        "estop low; 0.1 s; led is high; output5 is low; S5$; 0.1 s; output5 is high",
        "Report-back at any time: a K in motion clears what may be cleared and changes nothing else":
        "X400@400$; K: 3; K: 3; K: 3; K: 3; K: 3; idle; X moves 400",
    }
)  # fmt: skip
def test_emergency_stop_and_led(bench, if1, script):
    play(bench, if1, script)


def test_quick_status_clears_as_motion_status_does(bench):
    """Clearing: "using either the Motion Status ("K") or Quick Status ("Q") commands"."""
    if1 = ready(bench, "U31")
    if1.pins["estop"].drive(False)
    bench.run(0.1)
    assert ask(bench, if1, "Q") == b"\x20"
    if1.pins["estop"].release()
    bench.run(0.1)
    assert [ask(bench, if1, letter) for letter in "QQK"] == [b"\x20", b"\0", b"0\r"]


@pytest.mark.parametrize("letter", "FIOEN")
def test_no_other_request_clears_a_fault(bench, if1, letter):
    """Clearing: only a motion or quick status request clears a fault, no other request."""
    if1.pins["estop"].drive(False)
    bench.run(0.1)
    if1.pins["estop"].release()
    bench.run(0.1)
    status(bench, if1, letter)
    status(bench, if1, letter)
    assert status_word(bench, if1) == 32


def test_an_emergency_stop_brings_motion_to_rest_along_the_ramp(bench, if1):
    """Clearing: "any axis in motion will stop"; motion status 41: with deceleration."""
    command(bench, if1, "X9000@1000$", seconds=2.0)
    at_ns, stood = bench.now, positions(if1)[0]
    if1.pins["estop"].drive(False)
    bench.run(1.0)
    # from 1000 to 400 in levels of 10 ms: 9 + 8 + 7 + 6 + 5 + 4 = 39 steps in 60 ms
    assert positions(if1)[0] - stood in (39, 40)
    assert 57 * MS <= times(if1.axes["X"])[-1] - at_ns <= 61 * MS


def test_no_movement_before_the_emergency_stop_has_been_read(bench, if1):
    """Emergency stop: "a Motion Status request must be made before the system can be restarted"."""
    if1.pins["estop"].drive(False)
    bench.run(0.1)
    if1.pins["estop"].release()
    for text in ("X100@400$", "Y-100$", "X@200G$", ":Z10:$"):
        write(if1, text)
    bench.run(2.0)
    assert (positions(if1), status_word(bench, if1)) == ((0, 0, 0), 32)
    bench.run(2.0)
    assert positions(if1) == (0, 0, 0)  # the refused moves are not made later
    write(if1, "X100$")
    until_idle(bench, if1)
    assert positions(if1) == (100, 0, 0)


def test_an_emergency_stop_there_at_power_up_inhibits_movement(bench):
    """Emergency stop inputs "must remain connected to +24v for the interface to run"."""
    if1 = bench.add("if1")
    if1.pins["estop"].drive(False)
    bench.run(1.5)
    send(bench, if1, "(U61", seconds=1.5)
    command(bench, if1, "X100$", seconds=1.0)
    assert (positions(if1), status_word(bench, if1)) == ((0, 0, 0), 32)
    if1.pins["estop"].drive(True)
    bench.run(0.1)
    assert status_word(bench, if1) == 32
    write(if1, "X100$")
    until_idle(bench, if1)
    assert positions(if1) == (100, 0, 0)


@pytest.mark.parametrize("name", DRIVE_FAULTS)
def test_a_drive_fault_stops_without_deceleration(bench, if1, name):
    """Position report-back: "as a result of a drive fault, no deceleration occurs on that axis"."""
    axis = name[0].upper()
    command(bench, if1, f"{axis}9000@5000$", seconds=1.0)
    at_ns = bench.now
    break_drive(if1, name)
    bench.run(2.0)
    assert times(if1.axes[axis])[-1] <= at_ns + 1 * MS
    assert (status(bench, if1, "E"), status_word(bench, if1)) == ("F", 16)


def test_a_drive_fault_is_cleared_by_a_request_once_the_drive_is_well(bench, if1):
    """Clearing: a request clears the bit "provided the fault is no longer present"."""
    break_drive(if1, "x_fault")
    bench.run(0.1)
    assert ([status_word(bench, if1) for _ in range(3)], number(bench, if1, "I")) == ([16, 16, 16], 202)
    if1.pins["x_fault"].release()
    bench.run(0.1)
    assert [status_word(bench, if1) for _ in range(3)] == [16, 0, 0]


def test_a_missing_fault_link_is_a_drive_fault_for_ever(bench):
    """Fault disable links: "requires to see a logic low ... even if no drive is connected"."""
    if1 = bench.add("if1")
    break_drive(if1, "y_fault")
    bench.run(1.5)
    send(bench, if1, "(U61", seconds=1.5)
    for text in ("X100$", "Z100$"):
        assert status_word(bench, if1) == 16
        command(bench, if1, text, seconds=1.0)
    assert positions(if1) == (0, 0, 0)
    assert if1.pins["led"].level


def test_the_other_axes_of_a_move_stop_too(bench, if1):
    """Clearing: "any axis in motion will stop"."""
    command(bench, if1, "XYZ90000@5000$", seconds=2.0)
    break_drive(if1, "x_fault")
    bench.run(2.0)
    stands = positions(if1)
    assert stands[0] < stands[1] == stands[2] < 20000
    bench.run(2.0)
    assert positions(if1) == stands


def test_a_drive_fault_of_an_axis_at_rest_halts_the_interface(bench, if1):
    """Fault disable links: they "will halt the interface in the event of a drive fault", also of an axis at rest."""
    command(bench, if1, "X90000@1000$", seconds=2.0)
    break_drive(if1, "y_fault")
    bench.run(1.0)
    stands = positions(if1)
    assert stands[0] < 2200
    bench.run(1.0)
    assert positions(if1) == stands
    assert status_word(bench, if1) == 16


def test_two_faults_at_once_are_cleared_each_by_its_own_rule(bench, if1):
    """Clearing: "reset the relevant fault bit provided the fault is no longer present"."""
    if1.pins["estop"].drive(False)
    break_drive(if1, "x_fault")
    command(bench, if1, "!", seconds=0.1)
    assert status_word(bench, if1) == 16 + 32 + 128
    if1.pins["estop"].release()
    bench.run(0.1)
    assert status_word(bench, if1) == 16 + 32 + 128
    assert status_word(bench, if1) == 16 + 128
    assert (number(bench, if1, "F"), status_word(bench, if1)) == (8, 16)
    command(bench, if1, "X100$", seconds=0.5)
    assert positions(if1) == (0, 0, 0)
    if1.pins["x_fault"].release()
    bench.run(0.1)
    assert (status_word(bench, if1), status_word(bench, if1)) == (16, 0)


def test_an_emergency_stop_during_the_deceleration_of_a_cancel(bench, if1):
    """An emergency stop does not change a deceleration in progress."""
    command(bench, if1, "^1 @5000", seconds=1.2)
    command(bench, if1, "X90000$", seconds=6.0)
    command(bench, if1, "#", seconds=1.0)
    if1.pins["estop"].drive(False)
    bench.run(0.1)
    assert status_word(bench, if1) == 41
    if1.pins["estop"].release()
    bench.run(5.0)
    x = times(if1.axes["X"])
    # 12190 steps up, 12190 down at this ramp, and the last at 400
    assert (x[-1] - x[-2], status_word(bench, if1), status_word(bench, if1)) == (2_500_000, 32, 0)


def test_a_drive_fault_during_a_deceleration_ends_it(bench, if1):
    """Position report-back: "no deceleration occurs on that axis"."""
    command(bench, if1, "^1 @5000", seconds=1.2)
    command(bench, if1, "X90000$", seconds=6.0)
    if1.pins["estop"].drive(False)
    bench.run(1.0)
    at_ns = bench.now
    break_drive(if1, "x_fault")
    bench.run(5.0)
    assert times(if1.axes["X"])[-1] <= at_ns + 1 * MS
    assert status_word(bench, if1) == 48


@pytest.mark.parametrize("wait_s", [0.0, 0.2, 0.249, 0.2515, 0.2535, 0.26, 0.3])
def test_an_emergency_stop_at_any_moment_of_a_backlash_correction(bench, if1, wait_s):
    """Backlash and emergency stop: the motion ends, whether in the move, in the pause of 3 ms or in the correction."""
    write(if1, "B-20", "X80B$")  # 100 steps at 400 take 250 ms, then the pause follows
    bench.run_until(lambda: if1.axes["X"].moving, 1.0)
    bench.run(wait_s)
    stood = positions(if1)[0]
    if1.pins["estop"].drive(False)
    bench.run(1.0)
    assert abs(positions(if1)[0] - stood) <= 1
    if1.pins["estop"].release()
    bench.run(1.0)
    assert abs(positions(if1)[0] - stood) <= 1
    assert status_word(bench, if1) == (32)
    assert (status_word(bench, if1), status(bench, if1, "E")) == (0, "C")


def test_an_emergency_stop_ends_a_pulse_or_lets_it_end_but_nothing_follows(bench, if1):
    """R22: a sequence is "ended, outputs as they are": a pulse may still end, but no further step follows."""
    out = edges(if1.pins["output1"])
    command(bench, if1, ":P1,50:X100@400:$")
    if1.pins["estop"].drive(False)
    bench.run(2.0)
    assert positions(if1) == (0, 0, 0)
    assert len(out) in (1, 2)
    if1.pins["estop"].release()
    assert status_word(bench, if1) == 32
    bench.run(2.0)
    assert positions(if1) == (0, 0, 0) and status(bench, if1, "E") == "C"


def test_a_fault_ends_a_sequence_and_it_can_be_run_again(bench, if1):
    """R22: a sequence is "ended, outputs as they are, rerun with `:$`"."""
    command(bench, if1, ":S1:X400@400:R1:Y50:$", seconds=0.5)
    if1.pins["estop"].drive(False)
    bench.run(0.5)
    if1.pins["estop"].release()
    assert status_word(bench, if1) == 32
    bench.run(3.0)
    x, y, _ = positions(if1)
    assert x < 250 and y == 0 and if1.pins["output1"].level
    write(if1, ":$")
    until_idle(bench, if1)
    assert positions(if1) == (x + 400, 50, 0) and not if1.pins["output1"].level


@pytest.mark.parametrize("name", ["estop", "x_fault"])
def test_a_fault_while_a_sequence_waits_for_an_input_ends_it(bench, if1, name):
    """R22: a fault also ends a step without motion."""
    if1.pins["input1"].drive(False)
    command(bench, if1, ":H1:X100@400:$")
    if1.pins[name].drive(not if1.pins[name].level)
    bench.run(0.2)
    if1.pins[name].release()
    bench.run(0.2)
    status_word(bench, if1)
    if1.pins["input1"].drive(True)
    bench.run(1.0)
    assert (positions(if1), status(bench, if1, "E")) == ((0, 0, 0), "C")


def test_a_very_short_emergency_stop_is_seen(bench, if1):
    """Emergency stop: even a very short one is stored until the status has been read."""
    command(bench, if1, "X4000@400$", seconds=1.0)
    if1.pins["estop"].drive(False)
    bench.run(0.002)
    if1.pins["estop"].release()
    bench.run(1.0)
    assert positions(if1)[0] < 450
    assert status_word(bench, if1) == 32


# The LED, and output 5 as fault output


@pytest.mark.parametrize("name", ["estop", "limit_plus", "limit_minus", "x_fault", "y_fault"])
def test_the_led_is_on_until_the_request_and_the_removal(bench, if1, name):
    """Inputs: "It will turn off after Motion Status has been read and the input removed"."""
    led, pin = if1.pins["led"], if1.pins[name]
    assert not led.level
    pin.drive(not pin.level)
    bench.run(0.1)
    assert led.level
    status_word(bench, if1)
    assert led.level
    pin.release()
    bench.run(0.1)
    if not name.startswith("limit"):
        assert led.level  # only the next request clears the bit
        status_word(bench, if1)
    assert not led.level


@pytest.mark.parametrize("name", ["estop", "limit_plus", "x_fault"])
def test_the_led_stays_on_after_the_removal_until_the_request(bench, if1, name):
    """Clearing: "The LED will go out when the fault bit has been reset"."""
    pin = if1.pins[name]
    pin.drive(not pin.level)
    bench.run(0.1)
    pin.release()
    bench.run(5.0)
    assert if1.pins["led"].level
    status_word(bench, if1)
    assert not if1.pins["led"].level


def test_output_5_duplicates_the_led_with_the_link_in_position_b(bench):
    """Optional fault output: "reconfigured to duplicate the function of the LED"."""
    if1 = bench.add("if1", fault_output=True)
    led, output = edges(if1.pins["led"]), edges(if1.pins["output5"])
    assert if1.pins["output5"].level is if1.pins["led"].level is True
    bench.run(1.5)
    if1.serial.write(b"(")
    bench.run(1.0)
    if1.serial.write(b"U61\r")
    bench.run(1.5)
    if1.pins["estop"].drive(False)
    bench.run(0.1)
    assert if1.pins["output5"].level
    status_word(bench, if1)
    if1.pins["estop"].release()
    status_word(bench, if1)
    assert not if1.pins["output5"].level
    assert output == led and len(led) >= 5
    flashing = [at_ns for at_ns, _ in led if 1_500 * MS < at_ns < 2_500 * MS]
    assert set(gaps(flashing)) == {S // 4}  # "flashes twice per second"


@pytest.mark.parametrize("text", ["S5$", "P5,50$", "S15$", "X10@400S5$", ":S5:$"])
def test_the_fault_output_cannot_be_controlled_by_program(bench, text):
    """Optional fault output: "cannot be controlled by program commands with the link in this position"."""
    if1 = ready(bench, fault_output=True)
    output = edges(if1.pins["output5"])
    write(if1, text)
    until_idle(bench, if1)
    assert output == []
    assert if1.pins["output1"].level is ("15" in text)
