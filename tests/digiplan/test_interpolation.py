"""Linear interpolation mode."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import command, gaps, moves, play, positions, ready, since_start, times, write


@scripts({
    # start/stop 400, 10,000 steps/s2, increment 100: 6 levels of 10 ms, 39 steps; 1922 steps at 1000/s
    'Programming: "X axis to run for 2000 steps at 1000 steps/sec, and the Y axis ... 500 steps at 250 steps/sec"':
    " X 2000 / Y 500 @ 1000 $ ; idle; at 2000 500 0; X 2000 pulses from 400 to 1000 by 100 at 10000; "
    "Y 500 of 2000 pulses from 400 to 1000 by 100 at 10000",
    # too short for 6000: 46 levels 400 ... 4900 take 1219 steps, 62 are left over at 5000/s
    'Programming: "H1 L2 X2500 / Y100 @ 6000 S135 R24 $"':
    "input1 low; input2 high; S24$; H1 L2 X2500 / Y100 @ 6000 S135 R24 $; 0.5 s; input1 high; 0.5 s; at 0 0 0; "
    "input2 low; 0.5 s; outputs 01010; idle; at 2500 100 0; outputs 10101; "
    "X 2500 pulses from 400 to 6000 by 100 at 10000; Y 100 of 2500 pulses from 400 to 6000 by 100 at 10000",
    'Duplicating, 1 (R23: `@`, not `%`): X at 1000, "both Y and Z axes to run 500 steps at 250 steps/sec"':
    " X 2000 / YZ 500 @ 1000 $ ; idle; at 2000 500 500; Y like Z; "
    "Y 500 of 2000 pulses from 400 to 1000 by 100 at 10000",
    'Duplicating, 2 and 3: X and Y 1000 at 800, Z 50 at 40 steps/sec; then "X and Z axes interchanged"':
    " XY 1000 / Z 50 @ 800 $ ; idle; at 1000 1000 50; X 1000 pulses from 400 to 800 by 100 at 10000; X like Y; "
    "Z 50 of 1000 pulses from 400 to 800 by 100 at 10000;  YZ / X $ ; idle; at 1050 2000 1050; Y like Z; "
    "Y 1000 pulses from 400 to 800 by 100 at 10000; X 50 of 1000 pulses from 400 to 800 by 100 at 10000",
    'Start/stop speed: "Below this speed, no acceleration is applied"; the minor axis runs at 3/7 of 200 steps/s':
    "X700/Z300@200$; idle; X 700 pulses at 200; Z 300 pulses at 600/7",
    'R16: the multiplier is below 1, because the minor axis has a "short index (the minor axis)"':
    "X500/Y501@1000$; 1 s; at 0 0 0; K: 128; F: 16",
    'In sequence mode: "the interface will fault out. A status request must be made"':
    "^2; 1.2 s; :Z100@400:X1000/Y200@6000:Z50:$; 3 s; at 0 0 100; K: 128; E: F; F: 16; E: C; ^10; 1.2 s; "
    ":$; idle; at 1000 200 250",
    "Duplicating, 3: both distances are taken from the move before; a plain index takes the major one":
    "X600/Y70@400$; idle; Z/X$; idle; at 670 70 600; X800/Y$; idle; at 1470 140 600",
    # the ramp up, 96 levels 400 ... 9900 of 20 ms, takes 1.92 s and 9888 steps; 224 steps at 10000/s are 22.4 ms
    "Motion status of an interpolated move: 5 while accelerating, 3 at programmed speed, 9 while decelerating":
    "^5; 1.2 s; X20000/Y500@10000$; 0.5 s; K: 5; 1.5 s; K: 9; idle; at 20000 500 0",
    'Programming: "any two axes"; index mode: "-" changes the direction':
    "{X-2000/Y500|X+2000/Y-500|Z-800/X-Y800|X-Y300/Z-7|Y65535/Z1@10000|X10/Y0|X1/Y1}$; idle; at {-2000|2000|-800|"
    "-300|0|10|1} {500|-500|800|300|65535|0|1} {0|0|-800|-7|1|0|0}",
    'Constraints: "an out-of-range flag is set in the status command (... k = 128, F = 16)"; R32: k means K (1)':
    "{X20000/Y500@10001|X20000/Y500@10100|X65536/Y500@1000|X999999999/Y1|H1X65536/Y2S1|X65536/Y2P1,50}$; 2 s; "
    "at 0 0 0; K: 128; E: F; F: 16; K: 0; F: 0; E: C; outputs unchanged",
    'Constraints: "an out-of-range flag is set in the status command (... k = 128, F = 16)"; R32: k means K (2)':
    "{^4|^1|>2|>3|>4}; 1.2 s; X2000/Y500@{1000|400|1000|1000|1000}$; 2 s; at 0 0 0; K: 128; E: F; F: 16; K: 0; "
    "F: 0; E: C; outputs unchanged",
    'Constraints: "an out-of-range flag is set in the status command (... k = 128, F = 16)"; R32: k means K (3)':
    "@12000; X2000/Y500$; 2 s; at 0 0 0; K: 128; E: F; F: 16; K: 0; F: 0; E: C; outputs unchanged",
    "Constraints: the ends of the ranges are valid: velocity 10000, acceleration 5000, index 65535, range 1 (1)":
    "X{20000/Y500@10000|65535/Y500@9999}$; idle; at {20000|65535} 500 0; K: 0; F: 0",
    "Constraints: the ends of the ranges are valid: velocity 10000, acceleration 5000, index 65535, range 1 (2)":
    "{^5|^500|>1}; 1.2 s; X2000/Y{500@1000|2000|1999}$; idle; at 2000 {500|2000|1999} 0; K: 0; F: 0",
})  # fmt: skip
def test_interpolated_moves_in_turn(bench, if1, script):
    play(bench, if1, script)


def test_speeds_on_the_plateau(bench, if1):
    """Programming: X at 1000 and Y at 250 steps/sec for 2042 ms; Duplicating: Z at 40 steps/sec."""
    play(bench, if1, " X 2000 / Y 500 @ 1000 $ ; idle")
    x, y = since_start(if1.axes["X"]), since_start(if1.axes["Y"])
    assert x[-1] == y[-1] == 2_042 * MS
    assert set(gaps(x[39:1961])) == {1 * MS} and set(gaps(y[10:490])) == {4 * MS}
    play(bench, if1, " XY 1000 / Z 50 @ 800 $ ; idle")
    assert set(gaps(since_start(if1.axes["Z"])[3:47])) == {25 * MS}


@pytest.mark.parametrize("text", [
    "X100/X50$", "X100/YX50$", "X100/$", "/Y50$", "X100/Y50/Z20$", "X100/Y50", "X/100Y50$"])  # fmt: skip
def test_what_is_no_interpolation_moves_nothing(bench, if1, text):
    """Programming: "The major axis move is given first", `/` "always precedes the minor axis"; R7."""
    play(bench, if1, f"{text}; 1 s; at 0 0 0; F: 0|8")


def test_the_example_in_sequence_mode(bench, if1):
    """In sequence mode: "H1 X1000:L1X / Y200 % 6000 P1,20 : Y1000:=3,1: $"; R23: `@`, R24: `:` in front."""
    play(bench, if1, "input1 low; :H1 X1000:L1X / Y200 @ 6000 P1,20 : Y1000:=3,1: $")
    for passes in range(4):
        x, y = 2000 * passes, 1200 * passes
        play(bench, if1, f"4 s; at {x} {y} 0; input1 high; 4 s; at {x + 1000} {y} 0; input1 low")
    play(bench, if1, "until output1 is high; at 8000 3800 0; idle; output1 high for 200 ms; at 8000 4800 0; F: 0")
    assert moves(if1.axes["X"]) == [1000] * 8 and moves(if1.axes["Y"]) == [200, 1000] * 4


def test_the_cancel_code_brings_both_axes_down_together(bench, if1):
    """Index mode: "This will stop any axis in motion"; both axes keep their proportion to the end."""
    play(bench, if1, "X4000/Y1000@1000$; 1 s; #; 0.5 s; X between 901 1199; N: X")
    x, y, _ = positions(if1)
    assert y == x // 4 and times(if1.axes["X"])[-1] - times(if1.axes["Y"])[-1] < 10 * MS


@given(
    major=st.integers(1, 65535),
    share=st.fractions(0, 1),
    speed=st.integers(1, 10000),
    acceleration=st.sampled_from([5, 10, 77, 500]),
    start_stop=st.integers(1, 40),
    axes=st.permutations("XYZ"),
    signs=st.tuples(st.sampled_from("+-"), st.sampled_from("+-")),
)
@settings(max_examples=25)
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
