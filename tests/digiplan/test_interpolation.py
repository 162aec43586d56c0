"""Linear interpolation mode."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.units import MS, S

from .talking import (
    command,
    constant,
    edges,
    faults,
    gaps,
    moves,
    number,
    play,
    positions,
    pulse_times_of,
    ramped,
    ready,
    scripts,
    since_start,
    status,
    status_word,
    times,
    until_idle,
    write,
)


def scaled(segments, minor: int, major: int):
    """Return the ramp of the minor axis: each rate of the major axis times minor/major."""
    return [(Fraction(rate) * minor / major, seconds) for rate, seconds in segments]


def test_x_runs_2000_steps_and_y_500_in_the_same_time(bench, if1):
    """Programming: "X axis to run for 2000 steps at 1000 steps/sec, and the Y axis ... 500 steps at 250 steps/sec"."""
    write(if1, " X 2000 / Y 500 @ 1000 $ ")
    until_idle(bench, if1)
    assert positions(if1) == (2000, 500, 0)
    # start/stop 400, 10,000 steps/s2, increment 100: 6 levels of 10 ms, 39 steps; 1922 steps at 1000/s
    course = ramped(2000, 400, 1000, 100, 10_000)
    assert course[6] == (1000, Fraction(1922, 1000))
    x, y = since_start(if1.axes["X"]), since_start(if1.axes["Y"])
    assert x == pulse_times_of(course) and x[-1] == 2_042 * MS
    assert y == pulse_times_of(scaled(course, 500, 2000)) and y[-1] == 2_042 * MS
    assert set(gaps(x[39:1961])) == {1 * MS} and set(gaps(y[10:490])) == {4 * MS}


def test_an_interpolated_move_with_inputs_and_outputs(bench, if1):
    """Programming: "H1 L2 X2500 / Y100 @ 6000 S135 R24 $"."""
    if1.pins["input1"].drive(False)
    if1.pins["input2"].drive(True)
    command(bench, if1, "S24$", "H1 L2 X2500 / Y100 @ 6000 S135 R24 $", seconds=0.5)
    if1.pins["input1"].drive(True)
    bench.run(0.5)
    assert positions(if1) == (0, 0, 0)
    if1.pins["input2"].drive(False)
    bench.run(0.5)
    assert not if1.pins["output1"].level and if1.pins["output2"].level
    until_idle(bench, if1)
    assert positions(if1) == (2500, 100, 0)
    assert [if1.pins[f"output{n}"].level for n in range(1, 6)] == [True, False, True, False, True]
    # Too short for 6000: 46 levels 400 ... 4900 take 1219 steps, 62 are left over at 5000/s: 12.4 ms
    assert sum(range(4, 50)) == 1219
    course = ramped(2500, 400, 6000, 100, 10_000)
    assert since_start(if1.axes["X"]) == pulse_times_of(course)
    assert since_start(if1.axes["Y"]) == pulse_times_of(scaled(course, 100, 2500))
    assert since_start(if1.axes["X"])[-1] == 932_400_000


def test_the_minor_axis_move_duplicated_on_the_third_axis(bench, if1):
    """Duplicating, 1 (R23: `@`, not `%`): X at 1000, "both Y and Z axes to run 500 steps at 250 steps/sec"."""
    write(if1, " X 2000 / YZ 500 @ 1000 $ ")
    until_idle(bench, if1)
    assert positions(if1) == (2000, 500, 500)
    assert times(if1.axes["Y"]) == times(if1.axes["Z"])
    assert set(gaps(times(if1.axes["Z"])[10:490])) == {4 * MS}


def test_the_major_axis_move_duplicated_and_then_the_axes_interchanged(bench, if1):
    """Duplicating, 2 and 3: X and Y 1000 at 800, Z 50 at 40 steps/sec; then "X and Z axes interchanged"."""
    write(if1, " XY 1000 / Z 50 @ 800 $ ")
    until_idle(bench, if1)
    assert positions(if1) == (1000, 1000, 50)
    course = ramped(1000, 400, 800, 100, 10_000)
    x, y, z = (since_start(if1.axes[name]) for name in "XYZ")
    assert x == y == pulse_times_of(course)
    assert z == pulse_times_of(scaled(course, 50, 1000))
    assert set(gaps(z[3:47])) == {25 * MS}  # 40 steps/s

    write(if1, " YZ / X $ ")
    until_idle(bench, if1)
    assert positions(if1) == (1050, 2000, 1050)
    assert since_start(if1.axes["Y"]) == since_start(if1.axes["Z"]) == x
    assert since_start(if1.axes["X"]) == z


@pytest.mark.parametrize(
    ("text", "where"),
    [("X-2000/Y500$", (-2000, 500, 0)), ("X+2000/Y-500$", (2000, -500, 0)), ("Z-800/X-Y800$", (-800, 800, -800)),
     ("X-Y300/Z-7$", (-300, 300, -7)), ("Y65535/Z1@10000$", (0, 65535, 1)), ("X10/Y0$", (10, 0, 0)),
     ("X1/Y1$", (1, 1, 0))],
)  # fmt: skip
def test_each_axis_has_its_own_direction_and_ends_on_its_exact_count(bench, if1, text, where):
    """Programming: "any two axes"; index mode: "-" changes the direction."""
    write(if1, text)
    until_idle(bench, if1)
    assert positions(if1) == where


def test_below_the_start_stop_speed_there_is_no_ramp(bench, if1):
    """Start/stop speed: "Below this speed, no acceleration is applied"; the minor axis runs at 3/7 of 200 steps/s."""
    write(if1, "X700/Z300@200$")
    until_idle(bench, if1)
    assert since_start(if1.axes["X"]) == constant(200, 700)
    assert since_start(if1.axes["Z"]) == constant(Fraction(600, 7), 300)


@pytest.mark.parametrize(
    ("parameters", "move"),
    [("", "X20000/Y500@10001$"), ("", "X20000/Y500@10100$"), ("", "X65536/Y500@1000$"), ("", "X999999999/Y1$"),
     ("^4", "X2000/Y500@1000$"), ("^1", "X2000/Y500@400$"), (">2", "X2000/Y500@1000$"), (">3", "X2000/Y500@1000$"),
     (">4", "X2000/Y500@1000$"), ("@12000", "X2000/Y500$"), ("", "H1X65536/Y2S1$"), ("", "X65536/Y2P1,50$")],
)  # fmt: skip
def test_what_does_not_comply_is_flagged_and_ignored(bench, if1, parameters, move):
    """Constraints: "an out-of-range flag is set in the status command (... k = 128, F = 16)"; R32: k means K."""
    out = edges(if1.pins["output1"])
    if parameters:
        command(bench, if1, parameters, seconds=1.2)
    command(bench, if1, move, seconds=2.0)
    assert (positions(if1), status_word(bench, if1), status(bench, if1, "E")) == ((0, 0, 0), 128, "F")
    assert number(bench, if1, "F") == 16
    assert (status_word(bench, if1), number(bench, if1, "F")) == (0, 0)
    assert (status(bench, if1, "E"), out) == ("C", [])


@pytest.mark.parametrize(
    ("parameters", "move", "where"),
    [("", "X20000/Y500@10000$", (20000, 500, 0)), ("", "X65535/Y500@9999$", (65535, 500, 0)),
     ("^5", "X2000/Y500@1000$", (2000, 500, 0)), ("^500", "X2000/Y2000$", (2000, 2000, 0)),
     (">1", "X2000/Y1999$", (2000, 1999, 0))],
)  # fmt: skip
def test_the_very_limits_of_the_constraints_comply(bench, if1, parameters, move, where):
    """Constraints: the ends of the ranges are valid: velocity 10000, acceleration 5000, index 65535, range 1."""
    if parameters:
        command(bench, if1, parameters, seconds=1.2)
    write(if1, move)
    until_idle(bench, if1, 200)
    assert positions(if1) == where
    assert faults(bench, if1) == (b"0\r", b"0\r")


def test_a_minor_axis_longer_than_the_major_one_is_out_of_range(bench, if1):
    """R16: the multiplier is below 1, because the minor axis has a "short index (the minor axis)"."""
    command(bench, if1, "X500/Y501@1000$", seconds=1.0)
    assert (positions(if1), faults(bench, if1)) == ((0, 0, 0), (b"128\r", b"16\r"))


@pytest.mark.parametrize(
    "text", ["X100/X50$", "X100/YX50$", "X100/$", "/Y50$", "X100/Y50/Z20$", "X100/Y50", "X/100Y50$"]
)
def test_what_is_no_interpolation_moves_nothing(bench, if1, text):
    """Programming: "The major axis move is given first", `/` "always precedes the minor axis"; R7."""
    command(bench, if1, text, seconds=1.0)
    assert positions(if1) == (0, 0, 0)
    assert number(bench, if1, "F") in (0, 8)


def test_the_example_in_sequence_mode(bench, if1):
    """In sequence mode: "H1 X1000:L1X / Y200 % 6000 P1,20 : Y1000:=3,1: $"; R23: `@`, R24: `:` in front."""
    out = edges(if1.pins["output1"])
    if1.pins["input1"].drive(False)
    write(if1, ":H1 X1000:L1X / Y200 @ 6000 P1,20 : Y1000:=3,1: $")
    for passes in range(1, 5):
        bench.run(4.0)
        assert positions(if1) == (2000 * (passes - 1), 1200 * (passes - 1), 0)
        if1.pins["input1"].drive(True)
        bench.run(4.0)
        assert positions(if1) == (2000 * passes - 1000, 1200 * (passes - 1), 0)
        if1.pins["input1"].drive(False)
    until_idle(bench, if1)
    assert positions(if1) == (8000, 4800, 0)
    assert moves(if1.axes["X"]) == [1000] * 8 and moves(if1.axes["Y"]) == [200, 1000] * 4
    assert [level for _, level in out] == [True, False] * 4
    assert {b[0] - a[0] for a, b in zip(out[::2], out[1::2], strict=True)} == {200 * MS}
    assert number(bench, if1, "F") == 0


@scripts(
    {
        'In sequence mode: "the interface will fault out. A status request must be made"':
        "^2; 1.2 s; :Z100@400:X1000/Y200@6000:Z50:$; 3 s; at 0 0 100; K: 128; E: F; F: 16; E: C; ^10; 1.2 s; "
        ":$; idle; at 1000 200 250",
        "Duplicating, 3: both distances are taken from the move before; a plain index takes the major one":
        "X600/Y70@400$; idle; Z/X$; idle; at 670 70 600; X800/Y$; idle; at 1470 140 600",
    }
)  # fmt: skip
def test_interpolated_moves_in_turn(bench, if1, script):
    play(bench, if1, script)


def test_the_cancel_code_brings_both_axes_down_together(bench, if1):
    """Index mode: "This will stop any axis in motion"; both axes keep their proportion to the end."""
    command(bench, if1, "X4000/Y1000@1000$", seconds=1.0)
    command(bench, if1, "#", seconds=0.5)
    x, y, _ = positions(if1)
    assert 900 < x < 1200 and y == x // 4
    assert number(bench, if1, "N") == x
    assert times(if1.axes["X"])[-1] - times(if1.axes["Y"])[-1] < 10 * MS


def test_the_motion_status_of_an_interpolated_move(bench, if1):
    """Motion status: it is 5 while accelerating, 3 at programmed speed, 9 while decelerating."""
    command(bench, if1, "^5", seconds=1.2)
    write(if1, "X20000/Y500@10000$")  # the ramp up takes 1.92 s: 96 levels of 20 ms
    bench.run(0.5)
    assert status_word(bench, if1) == 5
    # up: 96 levels 400 ... 9900, 20 ms each: 9888 steps; 20000 - 19776 = 224 steps at 10000/s are 22.4 ms
    bench.run(1.5)
    assert status_word(bench, if1) == 9
    until_idle(bench, if1)
    assert positions(if1) == (20000, 500, 0)


@given(
    major=st.integers(1, 65535),
    share=st.fractions(0, 1),
    speed=st.integers(1, 10000),
    acceleration=st.sampled_from([5, 10, 77, 500]),
    start_stop=st.integers(1, 40),
    axes=st.permutations("XYZ"),
    signs=st.tuples(st.sampled_from("+-"), st.sampled_from("+-")),
)
@settings(max_examples=25, deadline=None)
def test_every_interpolated_move_ends_on_exact_counts_and_keeps_to_the_line(
    major, share, speed, acceleration, start_stop, axes, signs
):
    """ "such that the two axes will be in proportion": never more than one step from the straight line."""
    bench = Bench()
    if1 = ready(bench)
    minor = int(major * share)
    command(bench, if1, f"^{acceleration}<{start_stop}", seconds=1.2)
    write(if1, f"{axes[0]}{signs[0]}{major}/{axes[1]}{signs[1]}{minor}@{speed}$")
    bench.run(0.1 + major / min(speed, 6.25) * 1.1 + 4)

    first, second = if1.axes[axes[0]], if1.axes[axes[1]]
    assert first.position == (major if signs[0] == "+" else -major)
    assert second.position == (minor if signs[1] == "+" else -minor)
    assert if1.axes[axes[2]].position == 0
    a, b = first.pulse_times(), second.pulse_times()
    if minor:
        # when the minor axis makes its k-th step, the major axis is within one minor step of k x major/minor
        stands = a.searchsorted(b, side="right")
        for k, at in enumerate(stands.tolist(), start=1):
            assert abs(k - Fraction(at * minor, major)) <= 1
        assert a[-1] - b[-1] <= S
