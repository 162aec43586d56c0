"""Chapters Acceleration rate, Position report-back: data sent during a motion are used by the next motion."""

from fractions import Fraction

import pytest

from .talking import ask, command, constant, pulse_times_of, ramped, send, since_start, write


def count(bench, if1):
    """Return the answer to N, and the position of X at that time."""
    return int(ask(bench, if1, "N", 0.02)), if1.axes["X"].position


def test_a_lower_speed_for_the_next_move_does_not_change_the_counter_of_an_interpolated_run(bench, if1):
    """In linear interpolation: "65537 needs to be added": still so, because this run is above the start/stop rate."""
    command(bench, if1, "X2/Y1@10000G$", seconds=8)
    told, made = count(bench, if1)
    assert made > 65_537 and made - 500 <= told + 65_537 <= made
    write(if1, "@200")
    told, made = count(bench, if1)
    assert made - 500 <= told + 65_537 <= made


def test_a_higher_speed_for_the_next_move_does_not_change_the_counter_of_an_interpolated_run(bench, if1):
    """In linear interpolation: "If the speed is below the start/stop rate, ... approximately 4 x 10^9", still so."""
    command(bench, if1, "X2/Y1@400G$", seconds=170)
    write(if1, "@10000")
    told, made = count(bench, if1)
    assert made > 65_537 and made - 10 <= told <= made


def test_another_start_stop_speed_for_the_next_move_does_not_make_the_position_exact_or_vague(bench, if1):
    """Position report-back: "Above the start/stop speed, there will be an error of up to 256 steps"."""
    command(bench, if1, "X@3000G$", seconds=3)
    write(if1, "<40")
    for _ in range(5):
        told, made = count(bench, if1)
        assert told % 256 == 0 and made - 256 - 60 <= told <= made
    command(bench, if1, "#", seconds=3)  # the new ramp is calculated when the run has ended
    before = if1.axes["X"].position
    command(bench, if1, "X@3000G$", seconds=1)
    write(if1, "<1")
    told, made = count(bench, if1)
    assert made - before - 60 <= told <= made - before


# New ramp data: "the interface has to calculate a new ramp", and has no time for that before the work has ended


@pytest.mark.parametrize("setting", ["<10", "^20", ">2"])
def test_a_step_that_begins_before_the_new_ramp_is_calculated_has_the_old_one(bench, if1, setting):
    """Acceleration: "after new acceleration, start/stop or speed range data ... has to calculate a new ramp"."""
    command(bench, if1, ":X100@1000:P0,50:Y:$")
    command(bench, if1, setting, seconds=3)
    by_the_book = pulse_times_of(ramped(100, 400, 1000, 100, 10_000))
    assert since_start(if1.axes["X"]) == since_start(if1.axes["Y"]) == by_the_book


def test_a_move_that_waits_for_its_input_has_the_old_ramp_too(bench, if1):
    """Acceleration; Combining: the move was requested before the new data, so it has the ramp of that time."""
    command(bench, if1, "H1X100@1000$", seconds=0.1)
    command(bench, if1, "<10", seconds=0.1)
    if1.pins["input1"].drive(True)
    bench.run(0.9)
    assert since_start(if1.axes["X"]) == pulse_times_of(ramped(100, 400, 1000, 100, 10_000))
    bench.run(1)
    command(bench, if1, "X$", seconds=1)
    assert since_start(if1.axes["X"]) == constant(1000, 100)  # the start/stop speed is 1000 now


def test_a_move_that_waits_for_its_input_has_its_own_data(bench, if1):
    """Combining: "the X-axis move of 1000 steps at 200 steps/sec will begin when input 1 goes high"."""
    command(bench, if1, "H1X100@200$", seconds=0.1)
    command(bench, if1, "X30@400", seconds=0.1)
    if1.pins["input1"].drive(True)
    bench.run(1)
    assert since_start(if1.axes["X"]) == constant(200, 100)
    write(if1, "Y$")  # the data of the move that began last are remembered
    bench.run(1)
    assert since_start(if1.axes["Y"]) == constant(200, 100)


def test_data_of_another_kind_sent_while_a_move_waits_are_in_force_when_it_begins(bench, if1):
    """Acceleration: "will remember any programmed data unless it is overwritten": a move without a speed uses it."""
    command(bench, if1, "H1X100$", seconds=0.1)
    command(bench, if1, "@200", seconds=0.1)
    if1.pins["input1"].drive(True)
    bench.run(1)
    assert since_start(if1.axes["X"]) == constant(200, 100)


def test_the_backlash_correction_of_such_a_step_is_at_the_old_start_stop_speed(bench, if1):
    """Backlash correction: "applied at the programmed start/stop speed", here of the old ramp, 400."""
    command(bench, if1, ":B-20:P0,50:X50@200B:$", seconds=0.1)
    command(bench, if1, "<8", seconds=2)
    times = since_start(if1.axes["X"])
    assert times == constant(400, 20)


def test_a_run_and_an_interpolation_that_begin_before_the_new_ramp_have_the_old_one(bench, if1):
    """Constraints: "Minimum acceleration 5000": the old ramp, still in force, complies; the new data do not."""
    command(bench, if1, ":P0,50:X100/Y50@1000:X@1000G:$", seconds=0.1)
    command(bench, if1, "^4", seconds=3)
    assert (if1.axes["Y"].position, ask(bench, if1, "F")) == (50, b"0\r")
    # 400, 500, ... 900 steps/s, each for 10 ms
    assert since_start(if1.axes["X"])[:39] == pulse_times_of([(400 + 100 * n, Fraction(1, 100)) for n in range(6)])


def test_a_speed_that_only_the_new_range_has_is_out_of_range_before_its_ramp_is_calculated(bench, if1):
    """Speed: "a speed ... above the maximum for that range": until the new ramp is calculated, range 1 is in force."""
    command(bench, if1, ":P0,50:X100:$", seconds=0.1)
    command(bench, if1, ">2", "@40000", seconds=2)
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (0, b"16\r")
    command(bench, if1, ":$", seconds=2)
    assert (if1.axes["X"].position, ask(bench, if1, "F")) == (100, b"0\r")


def test_the_new_ramp_is_calculated_when_the_host_is_given_control(bench, if1):
    """Intervention: "as well as acceleration rate and start/stop speed data"; no answer during the calculation."""
    command(bench, if1, ":P0,50:%:Y100@800:$", seconds=0.1)
    assert (send(bench, if1, "<8", seconds=0.5), ask(bench, if1, "E", 0.8)) == (b"%\r", b"")
    bench.run(0.2)
    assert if1.serial.read() == b"C\r"
    command(bench, if1, "%", seconds=1)
    assert since_start(if1.axes["Y"]) == constant(800, 100)


def test_ramp_data_sent_while_the_hosts_own_move_runs_are_in_force_for_its_next_one(bench, if1):
    """Intervention: "start/stop speed data" sent during the host's move are in force for the host's next move."""
    write(if1, ":%:X1:$")
    bench.run(0.1)
    write(if1, "Y100@800$", "<8", "Y$")
    bench.run(3)
    assert since_start(if1.axes["Y"]) == constant(800, 100)
    assert if1.axes["Y"].position == 200
