"""The trajectory generator, sample by sample: chapters 4 and 5 of the base language."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.kernel.trajectory import max_stoppable_speed, next_velocity, stopping_distance

from .scripts import play, scripts
from .talking import positions, send


def test_a_trapezoid_of_whole_counts(bench, motor):
    """V is in 1/65536 count per sample, A in 1/65536 count per sample²; the move takes 109 samples.

    A of 1 count/sample² to 10 counts/sample takes 1+2+…+10 = 55 counts in 10 samples, and so does the stop, whose first
    sample is the last at full speed; 890 counts in 89 samples are between them.
    """
    assert send(bench, motor, b"A=65536 V=10*65536 P=1000 G RBt ", 0) == b"1\r"
    path = positions(bench, motor, 112)
    assert path[:11] == [1, 3, 6, 10, 15, 21, 28, 36, 45, 55, 65]
    assert path[98:109] == [945, 955, 964, 972, 979, 985, 990, 994, 997, 999, 1000] and path.index(1000) == 108


def test_s_stops_at_once(bench, motor):
    """After S the trajectory's velocity is 0 from the next sample on."""
    send(bench, motor, b"A=65536 V=6*65536 MV G ", 0)
    path = positions(bench, motor, 6)
    send(bench, motor, b"S ", 0)
    assert positions(bench, motor, 3) == [path[-1]] * 3 and send(bench, motor, b"RBt RBo ", 0) == b"0\r0\r"


def test_o_changes_the_numbers_and_nothing_else(bench, motor):
    """O= during a move changes the reported positions; the shaft's motion stays the same."""
    send(bench, motor, b"A=65536 V=100*65536 P=20 G ", 0)
    path = positions(bench, motor, 4)
    send(bench, motor, b"O=1000 ", 0)
    path += positions(bench, motor, 5)
    assert path == [1, 3, 6, 10, 14, 17, 19, 20, 20]
    assert send(bench, motor, b"RP RPE ", 0) == b"1010\r0\r"


SPEEDS = st.integers(1, 5_000_000)
RATES = st.integers(1, 300_000)


@given(speed=SPEEDS, rate=RATES)
def test_stopping_distance_is_the_sum_of_the_samples(speed, rate):
    """The stopping distance of a formula equals the sum over all samples."""
    count = -(-speed // rate)
    if count > 5000:
        rate = speed // 1000 + 1
    way, left = 0, speed
    while left > 0:
        way, left = way + left, left - rate
    assert stopping_distance(speed, rate) == way


@given(distance=st.integers(1, 1 << 48), rate=st.integers(1, (1 << 31) - 1))
def test_fastest_is_the_largest_speed_from_which_one_can_stop(distance, rate):
    """The stopping distance of this speed fits into `distance`; that of the next larger speed does not."""
    speed = max_stoppable_speed(distance, rate)
    assert stopping_distance(speed, rate) <= distance < stopping_distance(speed + 1, rate)


@settings(max_examples=50, deadline=None)
@given(
    target=st.integers(-3000, 3000),
    top=st.integers(65_536, 5_000_000),
    rate=st.integers(2_000, 300_000),
    speed=st.integers(-(10**6), 10**6),
)
def test_every_sample_respects_a_and_v_and_the_last_lands_exactly(target, top, rate, speed):
    """The velocity changes by at most A per sample, stays within V once below it, and is 0 at the target."""
    position, velocity, target = 0, speed, target << 16
    for _ in range(10_000):
        before, velocity = velocity, next_velocity(velocity, target - position, top, rate)
        assert abs(velocity - before) <= rate and abs(velocity) <= max(top, abs(before) - rate)
        position += velocity
        if position == target and abs(velocity) <= rate:
            return
    raise AssertionError("it does not arrive")


HIGHEST = 2**31 - 1


@pytest.mark.parametrize(("sign", "origin"), [(1, HIGHEST - 7), (-1, -HIGHEST + 6)])
def test_a_relative_move_goes_through_the_end_of_the_scale_the_short_way(bench, motor, sign, origin):
    """Base 4: D is relative and positions are modulo 2^32, so 1+2+3+4+4+3+2+1 = 20 counts may pass 2^31.

    From 2147483640, 20 counts lead to 2147483660, which reads -2147483636; Bw is set.
    """
    send(bench, motor, b"A=65536 V=5*65536 O=%d D=%d " % (origin, 20 * sign), 0)
    zero = motor.axes["shaft"].position
    for begin in (0, 20):
        assert send(bench, motor, b"G RBt ", 0) == b"1\r"
        path = [sign * (position - zero) for position in positions(bench, motor, 9)]
        assert path == [begin + n for n in (1, 3, 6, 10, 14, 17, 19, 20, 20)]
        assert send(bench, motor, b"RBt RBw ", 0) == b"0\r1\r"
        at = (origin + sign * (begin + 20) + 2**31) % 2**32 - 2**31
        assert send(bench, motor, b"RP RPE ", 0) == b"%d\r0\r" % at


def test_a_move_that_cannot_stop_before_the_end_of_the_scale_comes_back(bench, motor):
    """At 4 counts/sample, 3 counts before 2^31, the motor stops at least 10 counts further, and returns."""
    send(bench, motor, b"A=65536 V=4*65536 MV O=2147483600 G ", 0)
    while int(send(bench, motor, b"RP ", 0)) not in range(2147483640, 2147483648):
        positions(bench, motor, 1)
    send(bench, motor, b"MP P=2147483646 G ", 0)
    path = positions(bench, motor, 40)
    assert send(bench, motor, b"RP RBt RBw ", 0) == b"2147483646\r0\r1\r"
    assert max(path) - path[-1] < 20


def test_an_absolute_move_never_goes_through_the_end_of_the_scale(bench, motor):
    """Base 4: MP does not pass ±2^31, so a move from -2000000000 to 2000000000 goes in positive direction."""
    send(bench, motor, b"A=65536 V=4*65536 O=-2000000000 P=2000000000 G ", 0)
    zero = motor.axes["shaft"].position
    positions(bench, motor, 20)
    assert motor.axes["shaft"].position > zero


# Torque of a motor without a data sheet, and A=0


FASTER = 4 * 65536


@scripts({
    "The distance is too short to reach V: 1+2+3+4+4+3+2+1 = 20 counts in 8 samples":
    "A=65536 V=100*65536 P=20 G; positions 1 3 6 10 14 17 19 20 20",
    "Bt is 1 until the sample in which the target is commanded":
    "A=65536 V=100*65536 P=20 G; 7 samples; RBt RV -> 1 131072; 1 sample; RBt RV RP -> 0 0 20",
    "With A=1/4 and V=1/2 the positions are 1/4, 3/4, 1 1/4 …, which are rounded down to whole counts":
    "A=16384 V=32768 MV G; positions 0 0 1 1 2 2 3 3",
    "D=100 and G move by 100; another G moves by another 100":
    "A=65536 V=65536*50 D=100 G; 40 samples; at 100; RMODE G -> R; 40 samples; at 200",
    "A V assigned without G changes nothing; with G the motor decelerates at A to the new V":
    "A=65536 V=5*65536 MV G; 5 samples; V=2*65536; positions 20 25; G; positions 29 32 34 36 38",
    "MV from 2 to -2 counts per sample with A=1 passes through 1, 0 and -1":
    "A=65536 V=2*65536 MV G; positions 1 3 5; V=-2*65536 G; positions 6 6 5 3 1",
    "X from 6 counts per sample with A=2 decelerates by 4, 2, 0; then the servo holds":
    "A=65536 V=6*65536 MV G; 6 samples; A=2*65536 X; positions 25 27 27 27; RBt RBo -> 0 0",
    '3.1: limits are "directional": with the positive limit acknowledged, the move up to 2^31 - 1 is refused':
    "A=65536 V=4*65536 O=-2147483648 P=2147483647 UCP; 2 samples; Zr G RBt -> 0",
    # Torque of a motor without a data sheet, and A=0
    "Base 5, MT: T acts at once; without a data sheet the shaft turns T/32 counts per sample, or -T/32 with "
    "F=2":
    [f"F={functions} MT T={torque}; 1 sample; mark; 500 samples; moved {500 * counts * way}"
     for torque, counts in ((0, 0), (31, 0), (32, 1), (63, 1), (64, 2), (1023, 31), (-31, 0), (-32, -1), (-1023, -31))
     for functions, way in ((0, 1), (2, -1))],
    "4 of the base language: A=0 means no change of velocity; S stops the motor whatever A is":
    [f"MV A={FASTER} V={FASTER} G; 0.01 s; {words}; 1 sample; mark; 100 samples; moved 400; "
     "RV RBt -> 262144 1; S; RV -> 0"
     for words in ("MV A=0 V=0 G", "MP A=0 P=0 G", "A=0 X")],
    "At 5 counts per sample with A=1 the motor needs 4+3+2+1 = 10 counts to stop, then it returns. It returns "
    "by 1, 2, 3 counts; 4 are left. The largest steps that end there are 7/3, 4/3, 1/3: 21 2/3, 20 1/3, 20":
    "A=65536 V=5*65536 P=1000 G; positions 1 3 6 10 15 20; P=20 G; "
    "positions 24 27 29 30 30 29 27 24 21 20 20 20",
    "With A=0 or V=0, G does not move: Bo becomes 0; the trajectory is in progress unless its target is "
    "reached":
    [f"{words} G; 20 samples; RBo RBt RP -> 0 {busy} 0"
     for words, busy in (("V=1000 P=100", 1), ("A=1000 P=100", 1), ("MV A=1000 V=0", 1), ("P=0 A=100 V=100", 0))],
})  # fmt: skip
def test_trajectory(script):
    play(script)
