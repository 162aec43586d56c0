"""Report-back functions: position report-back N."""

import pytest

from axistwin import Bench

from .talking import command, moves, number, play, positions, ready, scripts, times, until_idle, write


@scripts(
    {
        'Position report-back: ""N <CR>" sent by controller, " 527 <CR>" returned by interface"':
        "N: 0; X527$; idle; N: 527",
        "Position report-back: each move of a sequence is an index":
        ":X100@400:P0,30:Y30:P0,30:$; 0.45 s; N: 100; 0.3 s; N: 30",
        'In linear interpolation: "the maximum number of steps returned is 65535"': "X65535/Y3@10000$; idle; N: 65535",
    }
)  # fmt: skip
def test_steps_of_the_last_move(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("text", ["X-300$", "Y300$", "XYZ300$", "X-Y+Z-300@1000$", "X300/Y20@1000$"])
def test_steps_are_counted_whatever_axis_and_direction(bench, if1, text):
    """Position report-back: "the number of steps produced from the start of the index or run"."""
    write(if1, text)
    until_idle(bench, if1)
    assert number(bench, if1, "N") == 300


def test_a_cancelled_index_tells_the_steps_made(bench, if1):
    """Position report-back: "If an index or run command is terminated, ... the number of clock pulses sent"."""
    command(bench, if1, "X90000@5000$", seconds=3.0)
    command(bench, if1, "#", seconds=2.0)
    assert 0 < positions(if1)[0] < 90000
    assert number(bench, if1, "N") == positions(if1)[0] == len(times(if1.axes["X"]))


def test_an_index_ended_by_an_external_signal_tells_the_steps_made(bench, if1):
    """Position report-back: terminated "by an external signal"."""
    command(bench, if1, "Y-90000@5000$", seconds=3.0)
    if1.pins["estop"].drive(False)
    bench.run(2.0)
    assert number(bench, if1, "N") == -positions(if1)[1] == len(times(if1.axes["Y"]))


def test_a_run_tells_the_steps_made_and_the_next_one_counts_anew(bench, if1):
    """Position report-back: "from the start of the index or run"."""
    command(bench, if1, "X@1000G$", seconds=10.0)
    command(bench, if1, "#", seconds=1.0)
    first = positions(if1)[0]
    assert number(bench, if1, "N") == first > 9000
    command(bench, if1, "X-@300G$", seconds=3.0)
    command(bench, if1, "#", seconds=1.0)
    assert number(bench, if1, "N") == first - positions(if1)[0]
    write(if1, "Z5$")
    until_idle(bench, if1)
    assert number(bench, if1, "N") == 5
    write(if1, "S1$")
    until_idle(bench, if1)
    assert number(bench, if1, "N") == 5


def test_below_the_start_stop_speed_the_error_in_motion_is_small(bench, if1):
    """Position report-back: "Below the start/stop speed, the error will generally be small"."""
    write(if1, "X4000@300$")
    for _ in range(20):
        bench.run(0.5)
        before = positions(if1)[0]
        told = number(bench, if1, "N")
        assert before - 1 <= told <= positions(if1)[0] + 1


def test_above_the_start_stop_speed_the_error_in_motion_is_up_to_256_steps(bench, if1):
    """Position report-back: "Above the start/stop speed, there will be an error of up to 256 steps"."""
    write(if1, "X60000@5000$")
    errors = set()
    for _ in range(25):
        bench.run(0.37)
        before = positions(if1)[0]
        told = number(bench, if1, "N")
        assert before - 256 <= told <= positions(if1)[0] + 256
        errors.add(told - before)
    assert len(errors) > 1
    until_idle(bench, if1)
    assert number(bench, if1, "N") == 60000


def test_the_counter_returns_to_zero_beyond_32_bits(bench):
    """Position report-back: "approximately 4 x 10^9 steps (FFFF.FFFF hex), beyond this point ... returns to zero"."""
    if1 = ready(bench)
    command(bench, if1, ">3", seconds=1.2)
    write(if1, "X@99999G$")  # 100,000 steps/s
    bench.run(42_949.0)
    assert 2**32 - 600_000 < number(bench, if1, "N") < 2**32  # the way up took some 500,000
    assert positions(if1)[0] < 2**32
    bench.run(7.0)
    told, made = number(bench, if1, "N"), positions(if1)[0]
    assert made > 2**32 and told < 300_000
    command(bench, if1, "#", seconds=20.0)
    assert number(bench, if1, "N") == positions(if1)[0] - 2**32


def test_a_drive_fault_leaves_something_to_report(bench, if1):
    """Position report-back: after a drive fault "the position returned is not meaningful", but N is answered."""
    command(bench, if1, "X90000@5000$", seconds=3.0)
    if1.pins["x_fault"].drive(not if1.pins["x_fault"].level)
    bench.run(1.0)
    assert number(bench, if1, "N") >= 0


def test_the_count_of_an_index_with_backlash_correction_has_both_ways_in_it(bench, if1):
    """Position report-back: "the number of clock pulses sent to the motor" is 120, and 20 back."""
    write(if1, "B-20", "X100B$")
    until_idle(bench, if1)
    assert (moves(if1.axes["X"]), number(bench, if1, "N")) == ([120, -20], 140)


# In linear interpolation


def stopped_interpolated_run(seconds: float, speed: int) -> tuple[int, int]:
    """Cancel an interpolated run after some seconds; return the steps of the major axis, and the answer to N."""
    bench = Bench()
    if1 = ready(bench)
    command(bench, if1, f"X1000/Y250@{speed}G$", seconds=seconds)
    command(bench, if1, "#", seconds=2.0)
    return positions(if1)[0], number(bench, if1, "N")


def test_an_interpolated_run_counts_16_bits_and_needs_65537_added():
    """In linear interpolation: "65537 needs to be added ... after the initial "rollover" of 65536 steps"."""
    made, told = stopped_interpolated_run(10.0, 10_000)
    assert made > 65_537
    assert made == told + 65_537


@pytest.mark.parametrize(("made", "told"), [(65_535, 65_535), (65_536, 0), (65_537, 0), (65_538, 1)])
def test_the_roll_over_step_by_step(made, told):
    """R21: "N = true - 65 537 from 65 537 on; 65 536 itself reads 0"."""
    # at 500 steps/s a step more takes 2 ms more
    first, _ = stopped_interpolated_run(131.0, 500)
    assert abs(first - 65_536) < 200
    assert stopped_interpolated_run(131.0 + (made - first) / 500, 500) == (made, told)


def test_an_interpolated_run_at_or_below_the_start_stop_rate_counts_32_bits():
    """In linear interpolation: "If the speed is below the start/stop rate, ... approximately 4 x 10^9"."""
    made, told = stopped_interpolated_run(200.0, 400)
    assert made == told > 65_537


def test_a_plain_run_counts_32_bits_above_the_start_stop_rate(bench, if1):
    """R21: only interpolated runs count 16 bits."""
    command(bench, if1, "X@10000G$", seconds=10.0)
    command(bench, if1, "#", seconds=2.0)
    assert number(bench, if1, "N") == positions(if1)[0] > 70_000


@pytest.mark.parametrize(("speed", "coarse"), [(400, False), (403, False), (404, True), (500, True), (900, True)])
def test_the_position_is_coarse_from_the_first_speed_above_start_stop_on(bench, if1, speed, coarse):
    """Position report-back: "Above the start/stop speed", 400 steps/s: 404 runs at 406.25, but 403 at 400."""
    command(bench, if1, f"X@{speed}G$", seconds=2.0)
    told = [number(bench, if1, "N") for _ in range(4)]
    assert all(count % 256 == 0 for count in told) is coarse
