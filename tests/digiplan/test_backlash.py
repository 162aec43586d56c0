"""Sending basic move instructions: Backlash correction."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.units import MS, S

from .helpers import strokes
from .talking import ask, constant, faults, moving, pulse_times_of, ramped, ready, since_start, tell


def pause_ns(axis) -> int:
    """From the last pulse of one stroke to the beginning of the next."""
    before, after = list(axis.train.moves)[-2:]
    last = int(axis.pulse_times(before.start_ns, after.start_ns)[-1])
    return after.start_ns - last


def test_an_index_against_the_backlash_direction_overshoots_and_returns(bench, if1):
    """Backlash: "the motor will run 120 steps in the positive direction, then reverse and move back 20"."""
    tell(if1, "B - 20")
    tell(if1, "X 100 B $")
    bench.run(2)
    axis = if1.axes["X"]
    assert axis.position == 100
    assert strokes(axis) == [120, -20]
    assert since_start(axis, -2) == constant(400, 120) and since_start(axis) == constant(400, 20)


def test_no_correction_if_the_index_is_negative(bench, if1):
    """Backlash: "In this case there will be no correction applied if the index is negative"."""
    tell(if1, "B-20")
    tell(if1, "X-100B$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [-100]


def test_a_positive_backlash_direction(bench, if1):
    """Backlash: "to set a positive backlash correction of 50 steps, send "B + 50 <CR>""."""
    tell(if1, "B + 50")
    tell(if1, "Y-400B$")
    tell(if1, "Y400B$")
    bench.run(5)
    assert strokes(if1.axes["Y"]) == [-450, 50, 400]


def test_the_motor_pauses_at_least_3_ms_before_it_reverses(bench, if1):
    """Backlash: "A pause of at least 3mS will occur before the motor reverses"."""
    tell(if1, "B-20")
    tell(if1, "X100B$")
    bench.run(2)
    assert 3 * MS <= pause_ns(if1.axes["X"]) <= 5 * MS


@pytest.mark.parametrize("question", ["K", "N", "E", "I"])
def test_the_pause_may_be_extended_by_interrogation_but_never_shortened(bench, if1, question):
    """Backlash: "this may be extended if the interface is being interrogated at the time"."""
    tell(if1, "B-20")
    tell(if1, "X100B$")
    for _ in range(100):
        tell(if1, question)
        bench.run(0.006)
    bench.run(1)
    assert strokes(if1.axes["X"]) == [120, -20]
    assert 3 * MS <= pause_ns(if1.axes["X"]) <= 100 * MS
    if1.serial.read()
    assert ask(bench, if1, "K") == b"0\r"


def test_the_correction_is_made_at_the_start_stop_speed(bench, if1):
    """Backlash: "The correction will be applied at the programmed start/stop speed"; the index itself has its ramp."""
    tell(if1, "B-20")
    tell(if1, "<3")
    tell(if1, "X100B@1000$")
    bench.run(3)
    axis = if1.axes["X"]
    assert since_start(axis, -2) == pulse_times_of(ramped(120, 300, 1000, 100, 10_000))
    assert since_start(axis) == constant(300, 20)


def test_the_correction_is_made_at_the_start_stop_speed_that_the_range_can_set(bench, if1):
    """Start/stop: 300 is 288 in range 4."""
    tell(if1, ">4<3B-20")
    tell(if1, "X100B@1000$")
    bench.run(3)
    assert since_start(if1.axes["X"]) == constant(288, 20)
    assert if1.axes["X"].position == 100


def test_the_correction_is_at_start_stop_even_below_it(bench, if1):
    """R26: speed below start/stop: the correction still at start/stop."""
    tell(if1, "B-20")
    tell(if1, "X100B@100$")
    bench.run(3)
    axis = if1.axes["X"]
    assert since_start(axis, -2) == constant(100, 120) and since_start(axis) == constant(400, 20)


def test_without_b_in_the_index_there_is_no_correction(bench, if1):
    """Backlash: the index command itself carries the B."""
    tell(if1, "B-20")
    tell(if1, "X100$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [100]


def test_the_default_correction_is_nothing(bench, if1):
    """Default values: "Backlash correction 0 steps"."""
    tell(if1, "X100B$")
    tell(if1, "X-100B$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [100, -100]


def test_it_is_remembered(bench, if1):
    """Acceleration: "will remember any programmed data unless it is overwritten"."""
    tell(if1, "B-20")
    tell(if1, "X100B$")
    tell(if1, "X$")
    tell(if1, "XB$")
    bench.run(5)
    assert strokes(if1.axes["X"]) == [120, -20, 100, 120, -20]
    assert if1.axes["X"].position == 300


def test_a_correction_of_0_takes_it_away(bench, if1):
    """Backlash: it is overwritten like any other data."""
    tell(if1, "B-20")
    tell(if1, "B-0")
    tell(if1, "X100B$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [100]


@pytest.mark.parametrize("message", ["B20", "B", "B-", "B+", "B+-5", "B 50", "B*5"])
def test_the_direction_must_always_be_specified(bench, if1, message):
    """Backlash: "the backlash direction must ALWAYS be specified, even if it is positive"."""
    tell(if1, "B-20")
    tell(if1, message)
    assert faults(bench, if1) == (b"128\r", b"8\r")
    tell(if1, "X100B$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [120, -20]


def test_up_to_255_steps(bench, if1):
    """Backlash: "up to 255 steps"."""
    tell(if1, "B-255")
    tell(if1, "X10B$")
    bench.run(3)
    assert strokes(if1.axes["X"]) == [265, -255]


@pytest.mark.parametrize("message", ["B-256", "B+999", "B-1000000000000"])
def test_more_than_255_steps_are_out_of_range(bench, if1, message):
    """R25: out of range, and not taken."""
    tell(if1, "B-20")
    tell(if1, message)
    assert faults(bench, if1) == (b"128\r", b"16\r")
    tell(if1, "X100B$")
    bench.run(2)
    assert strokes(if1.axes["X"]) == [120, -20]


def test_several_axes_in_the_same_direction(bench, if1):
    """Backlash: "the directions must all be the same": then all end in their place."""
    tell(if1, "B-20")
    tell(if1, "XYZ100B$")
    bench.run(2)
    for axis in if1.axes.values():
        assert strokes(axis) == [120, -20]


def test_several_axes_in_different_directions_introduce_a_position_error(bench, if1):
    """Backlash: "otherwise a position error will be introduced": nothing prevents it, nothing reports it."""
    tell(if1, "B-20")
    tell(if1, "X+Y-100B$")
    bench.run(2)
    assert (if1.axes["X"].position, if1.axes["Y"].position) != (100, -100)
    assert faults(bench, if1) == (b"0\r", b"0\r")


def test_it_is_busy_from_the_first_pulse_to_the_last(bench, if1):
    """Busy status: "occupied", the pause included."""
    tell(if1, "B-20")
    tell(if1, "X100B$")
    bench.run(0.02)
    answers = b""
    for _ in range(60):  # 300 ms, 3 ms and 50 ms in all
        answers += ask(bench, if1, "E", 0.008)
    lead = answers.index(b"C")
    assert answers[:lead] == b"E\r" * (lead // 2)
    assert answers[lead:] == b"C\r" * (len(answers[lead:]) // 2)
    assert lead // 2 >= (0.353 - 0.03) / 0.008


def test_cancel_during_the_index_leaves_the_correction_out(bench, if1):
    """Index mode: cancel stops "any axis in motion", and the rest is lost."""
    tell(if1, "B-20")
    tell(if1, "X400B$")
    bench.run(0.5)
    tell(if1, "#")
    bench.run(2)
    assert len(strokes(if1.axes["X"])) == 1
    assert ask(bench, if1, "E") == b"C\r"


def test_cancel_during_the_correction_stops_it(bench, if1):
    """Index mode: cancel stops "any axis in motion"."""
    tell(if1, "B-200")
    tell(if1, "X20B$")
    bench.run(0.7)  # 220 pulses take 550 ms
    assert if1.axes["X"].velocity == -400
    tell(if1, "#")
    bench.run(0.1)
    assert not moving(if1)
    assert 20 < if1.axes["X"].position < 220


def test_it_may_be_stored_in_the_message_with_other_parameters(bench, if1):
    """Acceleration: parameters may share a message."""
    tell(if1, "@500 B-20 ^20")
    tell(if1, "X100B$")
    bench.run(3)
    assert strokes(if1.axes["X"]) == [120, -20]


@settings(max_examples=40, deadline=None)
@given(
    st.integers(1, 600),
    st.sampled_from("+-"),
    st.integers(0, 255),
    st.sampled_from("+-"),
    st.integers(1, 25_000),
)
def test_the_net_distance_is_always_the_one_asked_for(distance, direction, correction, backlash, speed):
    """Backlash: "finish any index with a fixed number of steps in a specified direction"."""
    bench = Bench()
    if1 = ready(bench)
    tell(if1, f"B{backlash}{correction}")
    tell(if1, f"Z{direction}{distance}B@{speed}$")
    bench.run(200)
    sign = int(direction + "1")
    if direction == backlash or not correction:
        assert strokes(if1.axes["Z"]) == [sign * distance]
    else:
        assert strokes(if1.axes["Z"]) == [sign * (distance + correction), -sign * correction]
        assert since_start(if1.axes["Z"])[-1] == int(Fraction(correction * S, 400))
        assert pause_ns(if1.axes["Z"]) >= 3 * MS


@pytest.mark.parametrize("message", ["X100/Y50B$", "XBG$", "XGB$"])
def test_no_correction_of_an_interpolated_move_or_a_run(bench, if1, message):
    """Backlash correction speaks of "any index"; neither an interpolated move nor a run can come back by it."""
    tell(if1, message)
    assert faults(bench, if1) == (b"128\r", b"8\r")
    assert if1.axes["X"].position == 0


def test_cancel_in_the_pause_leaves_the_correction_out(bench, if1):
    """Index mode: the cancel code ends what is going on, and a pause is a part of it."""
    tell(if1, "B-20")
    tell(if1, "X100B$")
    bench.run_until(lambda: moving(if1), 1)
    begin = bench.now
    tell(if1, "#", "")
    bench.run((300 * MS + begin - bench.now) / S - 10 / 9600)  # CR arrives with the last pulse, before the reversal
    tell(if1, "")
    bench.run(1)
    assert strokes(if1.axes["X"]) in ([120], [119])


@pytest.mark.parametrize("pin", ["estop", "limit_plus", "x_fault"])
def test_a_fault_during_the_index_leaves_the_correction_out(bench, if1, pin):
    """Clearing faults: "any axis in motion will stop", "further movement is inhibited"."""
    tell(if1, "B-20")
    tell(if1, "X400B$")
    bench.run(0.5)
    if1.pins[pin].drive(False)
    bench.run(2)
    assert len(strokes(if1.axes["X"])) == 1
    assert if1.axes["X"].position < 420


def test_backlash_in_a_run_does_nothing_worse_than_nothing(bench, if1):
    """Backlash: it finishes "any index"; a run has no end to correct."""
    tell(if1, "B-20")
    tell(if1, "XGB$")
    bench.run(1)
    tell(if1, "#")
    bench.run(1)
    assert not moving(if1) and len(strokes(if1.axes["X"])) <= 1
    assert ask(bench, if1, "E") in (b"C\r", b"F\r")
