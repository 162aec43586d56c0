"""Sending basic move instructions: Backlash correction."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import ask, command, moves, moving, play, ready, since_start, write


def pause_ns(axis) -> int:
    """Return the time from the last pulse of one move to the beginning of the next."""
    before, after = list(axis.train.moves)[-2:]
    last = int(axis.pulse_times(before.start_ns, after.start_ns)[-1])
    return after.start_ns - last


@scripts({
    'Backlash: "the motor will run 120 steps in the positive direction, then reverse and move back 20"':
    "B - 20; X 100 B $; until X at 120; X 120 pulses at 400; 2 s; X at 100; X moves 120 -20; X 20 pulses at 400",
    'Backlash: "In this case there will be no correction applied if the index is negative"':
    "B-20; X-100B$; 2 s; X moves -100",
    'Backlash: "to set a positive backlash correction of 50 steps, send "B + 50 <CR>""':
    "B + 50; Y-400B$; Y400B$; 5 s; Y moves -450 50 400",
    "Backlash: the index command itself carries the B": "B-20; X100$; 2 s; X moves 100",
    'Acceleration: "will remember any programmed data unless it is overwritten"':
    "B-20; X100B$; X$; XB$; 5 s; X moves 120 -20 100 120 -20; X at 300",
    "Backlash: it is overwritten like any other data": "B-20; B-0; X100B$; 2 s; X moves 100",
    'Backlash: "up to 255 steps"': "B-255; X10B$; 3 s; X moves 265 -255",
    "Acceleration: parameters may share a message": "@500 B-20 ^20; X100B$; 3 s; X moves 120 -20",
    'Backlash: "A pause of at least 3mS will occur before the motor reverses"':
    "B-20; X100B$; 2 s; X moves 120 -20; X begins 3 to 5 ms after X",
    'Backlash: "The correction will be applied at the programmed start/stop speed"; the index has its own ramp':
    "B-20; <3; X100B@1000$; until X at 120; X 120 pulses from 300 to 1000 by 100 at 10000; 3 s; X 20 pulses at 300",
    "Start/stop: a start/stop speed of 300 becomes 288 in range 4; the correction runs at 288":
    ">4<3B-20; X100B@1000$; 3 s; X 20 pulses at 288; X at 100",
    "R26: for an index below the start/stop speed, the correction still runs at the start/stop speed":
    "B-20; X100B@100$; until X at 120; X 120 pulses at 100; 3 s; X 20 pulses at 400",
    'Backlash: "the directions must all be the same"; then all axes end at their targets':
    "B-20; XYZ100B$; 2 s; X moves 120 -20; Y moves 120 -20; Z moves 120 -20",
    # the first axis decides: X makes 120 and -20, and Y -120 and -20
    'Backlash: "otherwise a position error will be introduced", which is neither prevented nor reported':
    "B-20; X+Y-100B$; 2 s; X moves 120 -20; Y moves -120 -20; K: 0; F: 0",
    'Index mode: cancel stops "any axis in motion", and no correction follows':
    "B-20; X400B$; 0.5 s; #; 2 s; X between 1 399; N: X; E: C",
    'Index mode: cancel stops "any axis in motion", also the correction; 220 pulses take 550 ms':
    "B-200; X20B$; 0.7 s; X runs at -400; #; 0.1 s; still; X between 21 219",
    'Backlash: "any index" is corrected; a run, which has no end, is made without a correction':
    "B-20; XGB$; 1 s; #; 1 s; still; X moves; E: F",
    'Backlash: "the backlash direction must ALWAYS be specified, even if it is positive" (1)':
    "B-20; B{20||-|+|+-5|*5}; K: 128; F: 8; X100B$; 2 s; X moves 120 -20",
    'Backlash: "the backlash direction must ALWAYS be specified, even if it is positive" (2)':
    "B-20; B 50; K: 128; F: 8; X100B$; 2 s; X moves 120 -20",
    "R25: a backlash above 255 is out of range, and the previous value is kept":
    "B-20; B{-256|+999|-1000000000000}; K: 128; F: 16; X100B$; 2 s; X moves 120 -20",
    'Backlash correction: "any index" is corrected, but neither an interpolated move nor a run':
    "X{100/Y50B|BG|GB}$; K: 128; F: 8; X at 0",
    'Clearing faults: "any axis in motion will stop", "further movement is inhibited", also the correction':
    "B-20; X400B$; 0.5 s; {estop|limit_plus|x_fault} low; 2 s; X between 1 419; N: X",
})  # fmt: skip
def test_backlash_corrections(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("question", ["K", "N", "E", "I"])
def test_the_pause_may_be_extended_by_interrogation_but_never_shortened(bench, if1, question):
    """Backlash: "this may be extended if the interface is being interrogated at the time"."""
    write(if1, "B-20", "X100B$")
    for _ in range(100):
        write(if1, question)
        bench.run(0.006)
    bench.run(1)
    if1.serial.read()
    play(bench, if1, "X moves 120 -20; X begins 3 to 100 ms after X; K: 0")


def test_it_is_busy_from_the_first_pulse_to_the_last(bench, if1):
    """Busy status: the interface is "occupied" from the first pulse to the last, the pause included."""
    command(bench, if1, "B-20", "X100B$", seconds=0.02)
    answers = b""
    for _ in range(60):  # 300 ms out, a pause of 3 ms and 50 ms back
        answers += ask(bench, if1, "E", 0.008)
    lead = answers.index(b"C")
    assert answers[:lead] == b"E\r" * (lead // 2) and answers[lead:] == b"C\r" * (len(answers[lead:]) // 2)
    assert lead // 2 >= (0.353 - 0.03) / 0.008


@settings(max_examples=40)
@given(st.integers(1, 600), st.sampled_from("+-"), st.integers(0, 255), st.sampled_from("+-"), st.integers(1, 25_000))
def test_the_net_distance_is_always_the_one_asked_for(distance, direction, correction, backlash, speed):
    """Backlash: "finish any index with a fixed number of steps in a specified direction"."""
    bench = Bench()
    if1 = ready(bench)
    command(bench, if1, f"B{backlash}{correction}", f"Z{direction}{distance}B@{speed}$", seconds=200)
    sign = int(direction + "1")
    if direction == backlash or not correction:
        assert moves(if1.axes["Z"]) == [sign * distance]
    else:
        assert moves(if1.axes["Z"]) == [sign * (distance + correction), -sign * correction]
        assert since_start(if1.axes["Z"])[-1] == int(Fraction(correction * S, 400))
        assert pause_ns(if1.axes["Z"]) >= 3 * MS


def test_cancel_in_the_pause_leaves_the_correction_out(bench, if1):
    """Index mode: the cancel code ends the index, also during the pause before the correction."""
    write(if1, "B-20", "X100B$")
    bench.run_until(lambda: moving(if1), 1)
    begin = bench.now
    write(if1, "#", end="")
    bench.run((300 * MS + begin - bench.now) / S - 10 / 9600)  # CR arrives with the last pulse, before the reversal
    command(bench, if1, "", seconds=1)
    assert moves(if1.axes["X"]) in ([120], [119])
