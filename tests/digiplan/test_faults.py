"""Clearing fault conditions: emergency stop, drive faults, clear-on-read, the LED, output 5 as fault output."""

import pytest

from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import edges, gaps, play, ready, times, until_idle, write


@scripts({
    'Clearing: "will reset the relevant fault bit provided the fault is no longer present"':
    "estop low; 0.01 s; estop released; 1 s; K: 32; K: 0; K: 0",
    'Emergency stop: "can be used to inhibit all movement"':
    "estop low; 0.1 s; K?; X100@400$; X-100@400$; 1 s; K?; X100@400$; X-100@400$; 1 s; K?; X100@400$; "
    "X-100@400$; 1 s; at 0 0 0",
    "Optional fault output: the link must be transferred first":
    "estop low; 0.1 s; led is high; output5 is low; S5$; 0.1 s; output5 is high",
    "Report-back at any time: a K in motion clears what may be cleared and changes nothing else":
    "X400@400$; K: 3; K: 3; K: 3; K: 3; K: 3; idle; X moves 400",
    "Clearing: only a motion or quick status request clears a fault, no other request":
    "estop low; 0.1 s; estop released; 0.1 s; F?; F?; I?; I?; O?; O?; E?; E?; N?; N?; K: 32",
    'Emergency stop: "a Motion Status request must be made before the system can be restarted": refused, not held':
    "estop low; 0.1 s; estop released; X100@400$; Y-100$; X@200G$; :Z10:$; 2 s; at 0 0 0; K: 32; 2 s; at 0 0 0; "
    "X100$; idle; at 100 0 0",
    'Clearing: a request clears the bit of a drive fault "provided the fault is no longer present"':
    "x_fault low; 0.1 s; K: 16; K: 16; K: 16; I: 202; x_fault released; 0.1 s; K: 16; K: 0; K: 0",
    'Fault disable links: they "will halt the interface in the event of a drive fault", also of an axis at rest':
    "X90000@1000$; 2 s; y_fault low; 1 s; X between 1 2199; still; 1 s; still; K: 16",
    'Clearing: "reset the relevant fault bit provided the fault is no longer present": two, each by its own rule':
    "estop low; x_fault low; !; 0.1 s; K: 176; estop released; 0.1 s; K: 176; K: 144; F: 8; K: 16; "
    "X100$; 0.5 s; at 0 0 0; x_fault released; 0.1 s; K: 16; K: 0",  # 16 + 32 + 128
    'R22: a sequence is "ended, outputs as they are, rerun with `:$`"':
    ":S1:X400@400:R1:Y50:$; 0.5 s; estop low; 0.5 s; estop released; K: 32; 3 s; X between 1 249; Y at 0; "
    "output1 is high; mark; :$; idle; moved 400 50 0; output1 is low",
    "R22: an emergency stop also ends a step without motion":
    "input1 low; :H1:X100@400:$; 0.2 s; estop low; 0.2 s; estop released; 0.2 s; K?; input1 high; 1 s; "
    "at 0 0 0; E: C",
    "R22: a drive fault also ends a step without motion":
    "input1 low; :H1:X100@400:$; 0.2 s; x_fault low; 0.2 s; x_fault released; 0.2 s; K?; input1 high; 1 s; "
    "at 0 0 0; E: C",
    "Emergency stop: even a very short one is stored until the status has been read":
    "X4000@400$; 1 s; estop low; 0.002 s; estop released; 1 s; X between 1 449; K: 32",
    'Limits: "Emergency stop or limit inputs will light the LED", but not without power':
    "power off; estop low; x_fault low; led is low; estop released; x_fault released; power on; 1.05 s; led is low",
    "Clearing: a move that is requested after the status request is held until X is at rest":
    "X@20000G$; 5 s; Y20$; Z7$; 0.05 s; estop low; 0.01 s; estop released; K: 41; Z9@400$; 5 s; Y at 0; Z at 9",
    'Emergency stop: "a Motion Status request must be made before the system can be restarted", by a new command. '
    "X runs at 20,000 steps/s, where a stop takes 1.96 s; a Y move is held, and a Z move waits after it":
    "X@20000G$; 5 s; Y20$; Z7$; 0.05 s; {estop|limit_plus|y_fault} low; 0.01 s; {estop|limit_plus|"
    "y_fault} released; K: {41|73|25}; K: 9; 5 s; Y at 0; Z at 0; still; E: C; Y-3@400$; 0.5 s; Y at -3",
    'Limits: "Emergency stop or limit inputs will light the LED (red) on the interface". Inputs: "It will turn '
    'off after Motion Status has been read and the input removed" (1)':
    "led is low; {estop|x_fault|y_fault} low; 0.1 s; led is high; led is steady; K?; led is high; {estop|x_fault|"
    "y_fault} released; 0.1 s; led is high; K?; led is low",
    'Limits: "Emergency stop or limit inputs will light the LED (red) on the interface". Inputs: "It will turn '
    'off after Motion Status has been read and the input removed" (2)':
    "led is low; limit_{plus|minus} low; 0.1 s; led is high; led is steady; K?; led is high; limit_{plus|"
    "minus} released; 0.1 s; led is low",
    'Limits: "Emergency stop or limit inputs will light the LED (red) on the interface". Inputs: "It will turn '
    'off after Motion Status has been read and the input removed" (3)':
    "X{|-}G$; 0.5 s; led is low; limit_{plus|minus} low; 0.1 s; led is high; led is steady; K?; led is high; "
    "limit_{plus|minus} released; 0.1 s; led is low",
    'Clearing: "The LED will go out when the fault bit has been reset"':
    "{estop|limit_plus|x_fault} low; 0.1 s; {estop|limit_plus|x_fault} released; 5 s; led is high; K?; led is low",
})  # fmt: skip
def test_faults_and_requests(bench, if1, script):
    play(bench, if1, script)


@scripts({
    "Emergency stop and limit inputs: the limit that stops nothing cancels nothing that is held":
    "X400@400$; Y20$; 0.1 s; limit_minus low; K?; 2 s; at 400 20 0",
    'Clearing faults: all is inhibited "apart from motion away from a limit switch"; option: it is not stopped':
    "X-G$; 1 s; limit_plus low; 1 s; X runs at -400",
})  # fmt: skip
def test_a_limit_behind_a_motion_does_not_stop_it_where_that_is_asked_for(bench, script):
    play(bench, ready(bench, limits="motion ahead"), script)


def test_an_emergency_stop_during_the_deceleration_of_a_cancel(bench, if1):
    """An emergency stop does not change a deceleration in progress."""
    stopped = "^1 @5000; 1.2 s; X90000$; 6 s; #; 1 s; estop low; 0.1 s; K: 41; estop released; 5 s; K: 32; K: 0"
    play(bench, if1, stopped)
    assert gaps(times(if1.axes["X"]))[-1] == 2_500_000  # 12190 steps up, 12190 down at this ramp, and the last at 400


def test_a_drive_fault_during_a_deceleration_ends_it(bench, if1):
    """Position report-back: "no deceleration occurs on that axis"."""
    play(bench, if1, "^1 @5000; 1.2 s; X90000$; 6 s; estop low; 1 s")
    at_ns = bench.now
    play(bench, if1, "x_fault low; 5 s; K: 48")
    assert times(if1.axes["X"])[-1] <= at_ns + 1 * MS


@pytest.mark.parametrize("wait_s", [0.0, 0.2, 0.249, 0.2515, 0.2535, 0.26, 0.3])
def test_an_emergency_stop_at_any_moment_of_a_backlash_correction(bench, if1, wait_s):
    """Backlash and emergency stop: the motion ends, whether in the move, in the pause of 3 ms or in the correction."""
    write(if1, "B-20", "X80B$")  # 100 steps at 400 take 250 ms, then the pause follows
    bench.run_until(lambda: if1.axes["X"].moving, 1.0)
    bench.run(wait_s)
    stood = if1.axes["X"].position
    stopped = f"X between {stood - 1} {stood + 1}"
    play(bench, if1, f"estop low; 1 s; {stopped}; estop released; 1 s; {stopped}; K: 32; K: 0; E: C")


def test_an_emergency_stop_ends_a_pulse_or_lets_it_end_but_nothing_follows(bench, if1):
    """R22: a sequence is "ended, outputs as they are": a pulse may still end, but no further step follows."""
    out = edges(if1.pins["output1"])
    play(bench, if1, ":P1,50:X100@400:$; 0.2 s; estop low; 2 s; at 0 0 0")
    assert len(out) in (1, 2)
    play(bench, if1, "estop released; K: 32; 2 s; at 0 0 0; E: C")


# The LED, and output 5 as fault output


@pytest.mark.parametrize("pin", ["estop", "x_fault", "limit_plus"])
def test_output_5_duplicates_the_led_with_the_link_in_position_b(bench, pin):
    """Optional fault output: "Output 5 may be reconfigured to duplicate the function of the LED"."""
    if1 = bench.add("if1", fault_output=True)
    led, output = edges(if1.pins["led"]), edges(if1.pins["output5"])
    play(bench, if1, "output5 is high; 1.5 s; sends (; 1 s; receives U<CR>; U61; 1.5 s; XG$; 1 s; output5 is low")
    play(bench, if1, f"{pin} low; 0.1 s; output5 is high; K?; {pin} released; K?; output5 is low")
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
    assert output == [] and if1.pins["output1"].level is ("15" in text)
