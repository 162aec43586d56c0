"""Chapters Acceleration rate, Position report-back: data sent during a motion are used by the next motion."""

from fractions import Fraction

import pytest

from ..scripts import scripts
from .talking import ask, command, play, pulse_times_of, since_start, write


def count(bench, if1):
    """Return the answer to N, and the position of X at that time."""
    return int(ask(bench, if1, "N", 0.02)), if1.axes["X"].position


@pytest.mark.parametrize(("speed", "seconds", "next_speed", "added", "error"), [
    (10_000, 8, 200, 65_537, 500), (400, 170, 10_000, 0, 10)])  # fmt: skip
def test_the_next_speed_does_not_change_the_counter_of_an_interpolated_run(
    bench, if1, speed, seconds, next_speed, added, error
):
    """In linear interpolation: "65537 needs to be added" above the start/stop rate, and not below, still so."""
    command(bench, if1, f"X2/Y1@{speed}G$", seconds=seconds)
    for _ in range(2):
        told, made = count(bench, if1)
        assert made > 65_537 and made - error <= told + added <= made
        write(if1, f"@{next_speed}")


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


@scripts({
    # afterwards the start/stop speed is 1000
    "Acceleration; Combining: a move that waits for its input has the ramp of the time of its request":
    "H1X100@1000$; 0.1 s; <10; 0.1 s; input1 high; 0.9 s; X 100 pulses from 400 to 1000 by 100 at 10000; 1 s; "
    "X$; 1 s; X 100 pulses at 1000",
    # the data of the move that began last are remembered
    'Combining: "the X-axis move of 1000 steps at 200 steps/sec will begin when input 1 goes high": with its data':
    "H1X100@200$; 0.1 s; X30@400; 0.1 s; input1 high; 1 s; X 100 pulses at 200; Y$; 1 s; Y 100 pulses at 200",
    'Acceleration: "will remember any programmed data unless it is overwritten": also while a move waits':
    "H1X100$; 0.1 s; @200; 0.1 s; input1 high; 1 s; X 100 pulses at 200",
    'Backlash correction: "applied at the programmed start/stop speed", here of the old ramp, 400':
    ":B-20:P0,50:X50@200B:$; 0.1 s; <8; 2 s; X 20 pulses at 400",
    'Speed: "a speed ... above the maximum for that range": until the new ramp is calculated, range 1 is in force':
    ":P0,50:X100:$; 0.1 s; >2; @40000; 2 s; X at 0; F: 16; :$; 2 s; X at 100; F: 0",
    'Intervention: "as well as acceleration rate and start/stop speed data"; no answer during the calculation':
    ":P0,50:%:Y100@800:$; 0.1 s; <8; 0.5 s; receives %<CR>; E; 0.8 s; still; 0.2 s; receives C<CR>; %; 1 s; "
    "Y 100 pulses at 800",
    'Acceleration: "has to calculate a new ramp", up to 1 second, which a held sequence waits for, too':
    "X40@400$; ^20; :Y5:$; until X at 40; 0.98 s; Y at 0; 0.05 s; Y at 5",
    'Intervention: "start/stop speed data" sent during the host\'s move are in force for the host\'s next move':
    ":%:X1:$; 0.1 s; receives %<CR>; Y100@800$; <8; Y$; 3 s; Y 100 pulses at 800; Y at 200",
    'Acceleration: "after new acceleration, start/stop or speed range data ... has to calculate a new ramp"':
    ":X100@1000:P0,50:Y:$; 0.2 s; {<10|^20|>2}; 3 s; X 100 pulses from 400 to 1000 by 100 at 10000; X like Y",
})  # fmt: skip
def test_data_sent_while_something_waits(bench, if1, script):
    play(bench, if1, script)


def test_a_run_and_an_interpolation_that_begin_before_the_new_ramp_have_the_old_one(bench, if1):
    """Constraints: "Minimum acceleration 5000": the old ramp, still in force, complies; the new data do not."""
    play(bench, if1, ":P0,50:X100/Y50@1000:X@1000G:$; 0.1 s; ^4; 3 s; Y at 50; F: 0")
    # 400, 500, ... 900 steps/s, each for 10 ms
    assert since_start(if1.axes["X"])[:39] == pulse_times_of([(400 + 100 * n, Fraction(1, 100)) for n in range(6)])
