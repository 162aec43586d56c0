"""Report-back functions: position report-back N."""

import pytest

from ..scripts import scripts
from .talking import command, number, play, positions, write


@scripts({
    'Position report-back: ""N <CR>" sent by controller, " 527 <CR>" returned by interface"':
    "N: 0; X527$; idle; N: 527",
    "Position report-back: each move of a sequence is an index":
    ":X100@400:P0,30:Y30:P0,30:$; 0.45 s; N: 100; 0.3 s; N: 30",
    'In linear interpolation: "the maximum number of steps returned is 65535"': "X65535/Y3@10000$; idle; N: 65535",
    'Position report-back: "If an index or run command is terminated, ... the number of clock pulses sent"':
    "X90000@5000$; 3 s; #; 2 s; X between 1 89999; N: X",
    'Position report-back: terminated "by an external signal"':
    "Y-90000@5000$; 3 s; estop low; 2 s; Y between -89999 -1; N: Y",
    'Position report-back: after a drive fault "the position returned is not meaningful", but N is answered':
    "X90000@5000$; 3 s; x_fault low; 1 s; N?",
    # it counts both ways
    'Position report-back: "the number of clock pulses sent to the motor" is 120, and 20 back':
    "B-20; X100B$; idle; X moves 120 -20; N: 140",
    "R21: only interpolated runs count 16 bits: a plain run above the start/stop rate does not":
    "X@10000G$; 10 s; #; 2 s; X between 70001 120000; N: X",
    'In linear interpolation: "If the speed is below the start/stop rate, ... approximately 4 x 10^9"':
    "X1000/Y250@400G$; 200 s; #; 2 s; X between 65538 90000; N: X",
    # levels of 100 ms: 40 steps at 400/s, 50 at 500/s ...; the request is read 2.3 to 5 ms after 50 ms, 20 steps
    'Position report-back: on the ramp "above the start/stop speed" begins with its second level':
    "^1 @5000; 1.2 s; X40000$; until moving; 0.05 s; N: 20|21|22; 0.15 s; N: 0",
    'Position report-back: "the number of steps produced from the start of the index or run"':
    "{X-300|Y300|XYZ300|X-Y+Z-300@1000|X300/Y20@1000}$; idle; N: 300",
})  # fmt: skip
def test_steps_of_the_last_move(bench, if1, script):
    play(bench, if1, script)


def test_a_run_tells_the_steps_made_and_the_next_one_counts_anew(bench, if1):
    """Position report-back: "from the start of the index or run"."""
    play(bench, if1, "X@1000G$; 10 s; #; 1 s; N: X; X between 9001 11000")
    first = positions(if1)[0]
    play(bench, if1, "X-@300G$; 3 s; #; 1 s")
    play(bench, if1, f"N: {first - positions(if1)[0]}; Z5$; idle; N: 5; S1$; idle; N: 5")


@pytest.mark.parametrize(("move", "error"), [("X4000@300$", 1), ("X60000@5000$", 256)])
def test_the_error_in_motion_is_small_up_to_start_stop_and_up_to_256_steps_above(bench, if1, move, error):
    """Position report-back: "Above the start/stop speed, there will be an error of up to 256 steps".

    "Below the start/stop speed, the error will generally be small".
    """
    write(if1, move)
    errors = set()
    for _ in range(25):
        bench.run(0.37)
        before = positions(if1)[0]
        told = number(bench, if1, "N")
        assert before - error <= told <= positions(if1)[0] + error
        errors.add(told - before)
    assert len(errors) > 1
    play(bench, if1, "idle; N: X")


def test_the_counter_returns_to_zero_beyond_32_bits(bench, if1):
    """Position report-back: "approximately 4 x 10^9 steps (FFFF.FFFF hex), beyond this point ... returns to zero"."""
    play(bench, if1, ">3; 1.2 s; X@99999G$; 42949 s")  # 100,000 steps/s
    assert 2**32 - 600_000 < number(bench, if1, "N") < 2**32  # the way up took some 500,000
    assert positions(if1)[0] < 2**32
    bench.run(7.0)
    told, made = number(bench, if1, "N"), positions(if1)[0]
    assert made > 2**32 and told < 300_000
    command(bench, if1, "#", seconds=20.0)
    assert number(bench, if1, "N") == positions(if1)[0] - 2**32


@pytest.mark.parametrize(("made", "told"), [(65_535, 65_535), (65_536, 0), (65_537, 0), (65_538, 1), (99_000, 33_463)])
def test_the_roll_over_step_by_step(bench, if1, made, told):
    """In linear interpolation: "65537 needs to be added ... after the initial "rollover" of 65536 steps".

    R21: "N = true - 65 537 from 65 537 on; 65 536 itself reads 0".
    """
    write(if1, "X1000/Y250@500G$")
    # up to the speed of 500 steps/s it takes 10 ms at 400 steps/s; a stop takes as long, and 4 steps
    bench.run_until(lambda: if1.axes["X"].moving, 1)
    bench.run(0.01 + (made - 8) / 500 - 0.002)
    command(bench, if1, "#", seconds=2.0)
    assert (positions(if1)[0], number(bench, if1, "N")) == (made, told)


@pytest.mark.parametrize(("speed", "coarse"), [(400, False), (403, False), (404, True), (500, True), (900, True)])
def test_the_position_is_coarse_from_the_first_speed_above_start_stop_on(bench, if1, speed, coarse):
    """Position report-back: "Above the start/stop speed", 400 steps/s: 404 runs at 406.25, but 403 at 400."""
    command(bench, if1, f"X@{speed}G$", seconds=2.0)
    told = [number(bench, if1, "N") for _ in range(4)]
    assert all(count % 256 == 0 for count in told) is coarse
