"""Sending basic move instructions: Speed."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .talking import ask, at_speed, command, constant, faults, ready, since_start, write

RESOLUTION = {1: Fraction(25, 4), 2: Fraction(25, 2), 3: Fraction(25), 4: Fraction(1)}
MAXIMUM = {1: 25_000, 2: 50_000, 3: 99_999, 4: 4_000}


def nearest(speed: int, resolution: Fraction) -> Fraction:
    """Return the multiple of the resolution, other than 0, that is nearest to a speed."""
    return resolution * max(1, (2 * speed + resolution) // (2 * resolution))


@pytest.mark.parametrize(
    ("range_", "asked", "runs"),
    [
        (1, 503, 500),  # "503 steps/sec in range 1 will give a final speed of 500 steps/sec"
        (1, 504, 506.25),  # "504 steps/sec will give 506.25 steps/sec"
        (1, 5400, 5400),  # 864 x 6.25
        (1, 4800, 4800),  # 768 x 6.25
        (1, 25_000, 25_000),
        (1, 24_999, 25_000),
        (1, 24_997, 25_000),  # 3999.52 x 6.25
        (1, 24_996, 24_993.75),  # 3999.36 x 6.25
        (2, 503, 500),
        (2, 504, 500),  # 40.32 x 12.5
        (2, 507, 512.5),  # 40.56 x 12.5
        (2, 50_000, 50_000),
        (3, 99_999, 100_000),  # "this will result in a speed of 100,000 steps/sec due to the 25 s/s resolution"
        (3, 99_987, 99_975),  # 3999.48 x 25
        (3, 99_988, 100_000),  # 3999.52 x 25
        (3, 503, 500),
        (4, 4_000, 4_000),
        (4, 503, 503),  # "allows speeds to be set within 1 step/sec"
        (4, 504, 504),
        (4, 3_999, 3_999),
    ],
)
def test_the_speed_is_set_within_the_resolution_of_the_range(bench, if1, range_, asked, runs):
    """Speed: "up to the final speed within the resolution of that range"."""
    write(if1, f">{range_}", f"X@{asked}G$")
    assert at_speed(bench, if1) == runs


@pytest.mark.parametrize(
    ("asked", "runs"),
    [
        (21, Fraction(75, 4)),  # "21 steps/sec programmed would run at 18.75 steps/sec"
        (22, Fraction(25)),  # "22 programmed would run at 25"
        *((speed, Fraction(25, 4)) for speed in range(1, 10)),  # "between 1 and 8 steps/sec will run at 6.25"
        (10, Fraction(25, 2)),  # 1.6 x 6.25
        (399, Fraction(400)),
        (394, Fraction(1575, 4)),  # 63.04 x 6.25 = 393.75
    ],
)
def test_below_the_start_stop_speed_too(bench, if1, asked, runs):
    """Speed: "Below the start/stop speed, the speed will also be the nearest ... multiple of the speed resolution"."""
    command(bench, if1, f"X20@{asked}$", seconds=5)
    assert since_start(if1.axes["X"]) == constant(runs, 20)


def test_the_default_speed_is_400_in_range_1(bench, if1):
    """Default values: "Speed range 1", "Speed 400 steps/second"."""
    command(bench, if1, "X100$", seconds=1)
    assert since_start(if1.axes["X"]) == [n * 2_500_000 for n in range(1, 101)]
    write(if1, "@503", "XG$")
    assert at_speed(bench, if1) == 500  # 500 in ranges 1 to 3, but 503 in range 4
    command(bench, if1, "#", "@504", "XG$", seconds=1)
    assert at_speed(bench, if1) == 506.25  # possible in range 1 only


def test_the_speed_range_command(bench, if1):
    """Speed: "">2 <CR>" will set up speed range 2"."""
    write(if1, ">2", "X@30000G$")
    assert (at_speed(bench, if1), faults(bench, if1)) == (30_000, (b"3\r", b"0\r"))


@pytest.mark.parametrize(("range_", "speed"), [(1, 25_001), (2, 50_001), (4, 4_001), (1, 99_999), (4, 99_999)])
def test_a_speed_above_the_maximum_is_a_range_error_and_not_taken(bench, if1, range_, speed):
    """Speed: "above the maximum for that range, the interface will indicate a "range error" fault"."""
    command(bench, if1, f">{range_}", seconds=1.1)
    write(if1, "@300", f"@{speed}")
    assert faults(bench, if1) == (b"128\r", b"16\r")
    command(bench, if1, "X30$", seconds=1)
    assert since_start(if1.axes["X"]) == constant(300, 30)


@pytest.mark.parametrize(("range_", "speed"), [(1, 25_000), (2, 50_000), (3, 99_999), (4, 4_000)])
def test_the_maximum_itself_is_no_fault(bench, if1, range_, speed):
    """Speed, table: maximum speeds of the four ranges."""
    command(bench, if1, f">{range_}", f"@{speed}", seconds=1.1)
    assert faults(bench, if1) == (b"0\r", b"0\r")


@pytest.mark.parametrize("speed", ["100000", "123456", "9999999999999999999999"])
def test_more_than_five_digits_are_refused(bench, if1, speed):
    """Speed: "There is a limitation of 5 decades on the programmed speed"."""
    command(bench, if1, ">3", seconds=1.1)
    write(if1, f"@{speed}")
    answer = faults(bench, if1)
    assert answer[0] == b"128\r" and answer[1] in (b"8\r", b"16\r")
    command(bench, if1, "X40$", seconds=1)
    assert since_start(if1.axes["X"]) == constant(400, 40)


def test_speed_0_is_out_of_range(bench, if1):
    """R10: `@0` is out of range, and the speed is kept."""
    write(if1, "@0")
    assert faults(bench, if1) == (b"128\r", b"16\r")
    command(bench, if1, "X0040@00250$", seconds=1)
    assert since_start(if1.axes["X"]) == constant(250, 40)


@pytest.mark.parametrize("range_", ["0", "5", "9", "11", "40"])
def test_there_are_four_ranges(bench, if1, range_):
    """Speed: "the range number 1 to 4"."""
    command(bench, if1, f">{range_}", seconds=1.1)
    assert faults(bench, if1) == (b"128\r", b"16\r")
    write(if1, "X@504G$")
    assert at_speed(bench, if1) == 506.25  # still range 1


@pytest.mark.parametrize("message", [">", "@", "<", "^", ">-1", "@+300", "@3.5", "> <4", "@@300", ">1,2"])
def test_a_missing_number_is_a_data_fault(bench, if1, message):
    """R7: a missing number is a data fault, and the message is ignored."""
    command(bench, if1, message, seconds=0.05)
    assert faults(bench, if1) == (b"128\r", b"8\r")
    command(bench, if1, "X40$", seconds=1)
    assert since_start(if1.axes["X"]) == constant(400, 40)


def test_parameters_before_an_error_in_the_same_message_are_not_taken(bench, if1):
    """R7: "whole message ignored", the parameters before the error included."""
    command(bench, if1, "@200 >1 <9 ?", seconds=0.05)
    assert faults(bench, if1) == (b"128\r", b"8\r")
    command(bench, if1, "X40$", seconds=1)
    assert since_start(if1.axes["X"]) == constant(400, 40)


def test_a_speed_kept_from_a_faster_range_is_out_of_range_when_the_move_is_asked_for(bench, if1):
    """R10: "If a speed is requested which is above the maximum for that range": checked again at `$`."""
    command(bench, if1, "@5000", ">4", seconds=1.2)
    ask(bench, if1, "F")
    command(bench, if1, "X100$", seconds=0.5)
    assert (if1.axes["X"].position, faults(bench, if1)) == (0, (b"128\r", b"16\r"))
    command(bench, if1, "X100@4000$", seconds=1)
    assert if1.axes["X"].position == 100


def test_spaces_are_ignored_anywhere(bench, if1):
    """Move instructions: spaces "may be transmitted ... they will simply be ignored": even in a number."""
    command(bench, if1, " X 1 0  0 @ 2 5 0 $ ", seconds=1)
    assert since_start(if1.axes["X"]) == constant(250, 100)
    write(if1, "   ")
    assert faults(bench, if1) == (b"0\r", b"0\r")


def test_the_speed_stays_until_it_is_overwritten(bench, if1):
    """Acceleration: "The interface will remember any programmed data unless it is overwritten"."""
    write(if1, "@200")
    for axis in "XYZ":
        write(if1, f"{axis}10$")
    bench.run(1)
    for axis in "XYZ":
        assert since_start(if1.axes[axis]) == constant(200, 10)
    command(bench, if1, "X10@100$", seconds=1)
    assert since_start(if1.axes["X"]) == constant(100, 10)
    command(bench, if1, "Y10$", seconds=1)
    assert since_start(if1.axes["Y"]) == constant(100, 10)


def test_a_new_speed_needs_no_ramp_calculation(bench, if1):
    """Acceleration: only "new acceleration, start/stop or speed range data" need a calculation, not a new speed."""
    write(if1, "@5400")
    assert ask(bench, if1, "E", 0.02) == b"C\r"


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_any_speed_in_any_range(data):
    """Speed: it is the nearest multiple of the range's resolution, but never 0."""
    range_ = data.draw(st.integers(1, 4), "range")
    speed = data.draw(st.integers(1, MAXIMUM[range_]), "speed")
    bench = Bench()
    if1 = ready(bench, recalculation_s=0.01)
    command(bench, if1, f">{range_}^500@{speed}YG$", seconds=1)
    assert Fraction(if1.axes["Y"].velocity) == nearest(speed, RESOLUTION[range_])
