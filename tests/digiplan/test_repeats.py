"""Sequence mode: repeating parts of a sequence."""

from itertools import pairwise

import pytest

from axistwin.units import MS, S

from .talking import (
    OWN_TIME_NS,
    command,
    edges,
    moves,
    number,
    play,
    positions,
    scripts,
    status,
    status_word,
    times,
    until_idle,
    write,
)


def test_x_and_y_are_moved_six_times_and_then_the_output_is_reset(bench, if1):
    """Repeating: "repeated five times from step 2 ... giving a total of six X moves and six Y moves"."""
    out = edges(if1.pins["output1"])
    write(if1, " : S1 : X 400 @ 100 : Y : = 5, 2 : R1 : $")
    until_idle(bench, if1)
    x, y = times(if1.axes["X"]), times(if1.axes["Y"])

    assert moves(if1.axes["X"]) == moves(if1.axes["Y"]) == [400] * 6
    order = sorted([(at_ns, "X") for at_ns in x[::400]] + [(at_ns, "Y") for at_ns in y[::400]])
    assert [axis for _, axis in order] == ["X", "Y"] * 6
    assert [level for _, level in out] == [True, False]
    # 12 moves of 400 steps at 100 steps/s; S1 and six times `=` take only the interface's own time
    assert 48 * S <= out[1][0] - out[0][0] <= 48 * S + 7 * OWN_TIME_NS


def test_nested_repeats(bench, if1):
    """Repeating: six X and six Y moves, Z 50, then "the entire sequence is repeated from step 1 a further 24 times"."""
    out = edges(if1.pins["output1"])
    write(if1, " : S1 : X400 @ 100 : Y : = 5, 2 : R1 : Z50 : = 24, 1 : $")
    bench.run(1213.0)  # 24 x 48.5 s + 48.5 s and the interface's own time
    until_idle(bench, if1)
    assert positions(if1) == (60_000, 60_000, 1250)  # 150 x 400, 150 x 400, 25 x 50
    assert moves(if1.axes["X"]) == moves(if1.axes["Y"]) == [400] * 150
    assert moves(if1.axes["Z"]) == [50] * 25
    assert [level for _, level in out] == [True, False] * 25
    passes = [b - a for (a, on), (b, _) in pairwise(out) if not on]
    assert all(S // 2 <= length <= S // 2 + 2 * OWN_TIME_NS for length in passes)  # Z: 50 steps at 100 steps/s


def test_255_repeats_perform_a_move_256_times(bench, if1):
    """Repeating: "Up to 255 repeats can be specified, so the same move ... can be performed 256 times"."""
    write(if1, ":X3@400:=255,1:$")
    until_idle(bench, if1)
    assert moves(if1.axes["X"]) == [3] * 256


@scripts(
    {
        "Repeating: up to 255; R35: 256 is out of range": ":X3@400:=256,1:$; 1 s; at 0 0 0; K: 128; F: 16",
        "Repeating: each pass of the second repeat begins the first repeat again":
        ":X1@400:=2,1:=3,1:$; idle; at 12 0 0",
        "Repeating, format: high levels, low levels, repeat data":
        "input1 low; input3 high; :X10@400:H1L3=1,1:$; 0.5 s; input3 low; 0.5 s; at 10 0 0; input1 high; "
        "0.5 s; at 20 0 0; E: C",
        'Programming a sequence: "the whole sequence can be repeated"':
        ":X2@400:=4,1:$; idle; at 10 0 0; :$; idle; at 20 0 0; :$; idle; at 30 0 0; :$; idle",
    }
)  # fmt: skip
def test_repeated_steps(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("step", ["=1,0", "=1,64", "=1,3", "=0,9"])
def test_a_repeat_from_a_step_that_does_not_exist_is_out_of_range(bench, if1, step):
    """R35: a step m that is not 1 to 63, or not yet defined, sets F 16, and the sequence is dropped."""
    command(bench, if1, f":X3@400:{step}:Y4:$", seconds=1.0)
    assert positions(if1) == (0, 0, 0)
    assert (status_word(bench, if1), number(bench, if1, "F")) == (128, 16)


def test_an_inner_repeat_starts_afresh_on_every_outer_pass(bench, if1):
    """Repeating: "nesting repeats within the sequence", three levels; an outer pass restarts the inner repeats."""
    write(if1, ":X1@400:=2,1:Y1:=1,1:Z1:=3,1:$")
    until_idle(bench, if1)
    # per Z: two Y; per Y: three X.  Four Z.
    assert positions(if1) == (4 * 2 * 3, 4 * 2, 4)


def test_overlapping_repeats(bench, if1):
    """Repeating: the second repeat begins in the middle of the first one's steps.

    The moves are X Y X Y Z; from step 2: Y; the first repeat begins again and goes back to step 1: X Y; Z.
    """
    write(if1, ":X1@400:Y1:=1,1:Z1:=1,2:$")
    until_idle(bench, if1)
    assert positions(if1) == (3, 4, 2)


def test_zero_repeats_for_ever_until_it_is_cancelled(bench, if1):
    """Repeating: "it will continue round until the cancel code "# <CR>" is sent"."""
    command(bench, if1, " : X 1000 @ 400 : Y : X- : Y- : = 0, 1 : $", seconds=1000.0)  # one pass takes 10 s
    assert status(bench, if1, "E") == "E"
    assert len(moves(if1.axes["X"])) in (199, 200, 201)
    command(bench, if1, "#", seconds=0.1)
    stands = positions(if1)
    assert status(bench, if1, "E") == "C"
    bench.run(100.0)
    assert positions(if1) == stands


def test_a_cancelled_sequence_restarts_from_the_beginning_only(bench, if1):
    """Repeating: "Once a sequence has been terminated, it can only be restarted from the beginning"; R14: by `:$`."""
    command(bench, if1, ":X1000@400:Y:X-:Y-:=0,1:$", seconds=3.5)  # in the middle of the Y move
    command(bench, if1, "#", seconds=0.1)
    x, y, _ = positions(if1)
    assert x == 1000 and 0 < y < 1000
    command(bench, if1, ":$", seconds=2.55)
    assert positions(if1)[0] == 2000
    assert positions(if1)[1] - y < 100
    assert number(bench, if1, "O") == 2


def test_percent_does_not_restart_a_sequence(bench, if1):
    """R14: the manual's ":% <CR>" is a misprint: `%` means "wait for control", and this message is unfinished."""
    write(if1, ":X10@400:$")
    until_idle(bench, if1)
    command(bench, if1, ":%", seconds=1.0)
    assert positions(if1) == (10, 0, 0)


def test_a_switch_turns_the_square_on_and_off_and_it_stops_at_the_origin(bench, if1):
    """Repeating: ":H1" first: "will only continue to repeat if input 1 is high ... always stop at the origin"."""
    if1.pins["input1"].drive(True)
    command(bench, if1, " :H1: X 1000 @ 400 : Y : X- : Y- : = 0, 1 : $", seconds=23.0)
    if1.pins["input1"].drive(False)
    bench.run(50.0)
    assert positions(if1) == (0, 0, 0)
    assert moves(if1.axes["X"]) == [1000, -1000] * 3
    assert (status(bench, if1, "E"), status_word(bench, if1), number(bench, if1, "O")) == ("E", 0, 1)
    if1.pins["input1"].drive(True)
    bench.run(4.9)
    assert positions(if1)[0] == 1000 and positions(if1)[1] > 900


def test_a_repeat_can_wait_for_an_input_at_each_repetition(bench, if1):
    """Repeating: ": H2 = 10, 4 :" "would repeat ... ten times from step 4, with each repetition waiting"; R15."""
    if1.pins["input2"].drive(False)
    command(bench, if1, ":Y1@400:Y1:Y1:X10:Z1:H2=10,4:Y1:$", seconds=1.0)
    for passes in range(1, 12):
        assert positions(if1) == (10 * passes, 3, passes)
        assert status(bench, if1, "E") == "E"
        bench.run(1.0)
        assert positions(if1) == (10 * passes, 3, passes)
        if1.pins["input2"].drive(True)
        bench.run(0.01)  # the X move has begun: 10 steps at 400 steps/s
        if1.pins["input2"].drive(False)
        bench.run(1.0)
    # R15: the eleventh repetition, after which the sequence continues, has waited too
    assert (positions(if1), status(bench, if1, "E")) == ((110, 4, 11), "C")


@pytest.mark.parametrize(
    "text", [":=0,1:$", ":S1:=0,1:$", ":X0:=0,1:$", ":X:Y:=0,1:$", ":=255,1:=255,1:=255,1:=0,1:$", ":B+5:R1:=0,2:$",
             ":H1:L2:=0,1:$", ":A:=0,1:$"],
)  # fmt: skip
def test_repeating_nothing_for_ever_lets_time_pass_and_can_be_cancelled(bench, if1, text):
    """Repeating an empty step for ever takes time, and the cancel code ends it."""
    if1.pins["input1"].drive(True)
    if1.pins["input2"].drive(False)
    command(bench, if1, text, seconds=2.0)
    assert status(bench, if1, "E") == "E"
    command(bench, if1, "#", seconds=0.1)
    assert status(bench, if1, "E") == "C"
    write(if1, "X5@400$")
    until_idle(bench, if1)
    assert positions(if1) == (5, 0, 0)


def test_the_rerun_of_a_cancelled_sequence_counts_its_repeats_afresh(bench, if1):
    """Repeating: "restarted from step 1", with all passes, after a cancel in the second of five passes."""
    command(bench, if1, ":X100@400:=4,1:$", seconds=0.4)
    command(bench, if1, "#", seconds=0.1)
    before = positions(if1)[0]
    assert 100 < before < 200
    write(if1, ":$")
    until_idle(bench, if1)
    assert positions(if1)[0] - before == 500


def test_an_index_of_an_hour_in_repeats_costs_nothing_extra(bench, if1):
    """Repeating a delay: 4 × 256 times 990 ms, about 17 minutes, are exact but for the interface's own time."""
    out = edges(if1.pins["output1"])
    command(bench, if1, ":S1:P0,99:=255,2:=3,2:R1:$", seconds=1020.0)
    exact = 1024 * 990 * MS
    assert exact <= out[1][0] - out[0][0] <= exact + (1 + 1024 + 4) * OWN_TIME_NS
