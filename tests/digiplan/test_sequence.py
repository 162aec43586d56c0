"""Sequence mode: programming a sequence, running it again, mistakes while entering, backlash, delays."""

import pytest

from axistwin.units import MS, S

from .talking import (
    OWN_TIME_NS,
    ask,
    command,
    each_character,
    edges,
    gaps,
    moves,
    number,
    play,
    positions,
    ready,
    scripts,
    send,
    status,
    status_word,
    times,
    until_idle,
    write,
)


def test_four_moves_describe_a_square(bench, if1):
    """Programming a sequence: "four moves which cause an X-Y system to describe a square"."""
    write(if1, ": X 1000 @ 200 : Y : X- : Y- : $")
    corners = []
    for _ in range(4):
        bench.run(5.0)  # 1000 steps at 200 steps/s
        corners.append(positions(if1))
    bench.run(1.0)

    # at most 0.05 s pass before the first pulse, so each corner is less than 10 steps away
    for (x, y, _), (want_x, want_y) in zip(corners, [(1000, 0), (1000, 1000), (0, 1000), (0, 0)], strict=True):
        assert abs(x - want_x) < 10 and abs(y - want_y) < 10
    assert (moves(if1.axes["X"]), moves(if1.axes["Y"])) == ([1000, -1000], [1000, -1000])
    assert positions(if1) == (0, 0, 0)


def test_each_move_of_the_square_runs_at_200_steps_per_second(bench, if1):
    """Programming a sequence: "X 1000 @ 200".  200 = 32 x 6.25, one step every 5 ms."""
    command(bench, if1, ": X 1000 @ 200 : Y : X- : Y- : $", seconds=21.0)

    x, y = times(if1.axes["X"]), times(if1.axes["Y"])
    for leg in (x[:1000], x[1000:], y[:1000], y[1000:]):
        assert set(gaps(leg)) == {5 * MS}
    assert x[0] < x[999] < y[0] < y[999] < x[1000] < x[1999] < y[1000]


def test_a_sequence_starts_with_the_carriage_return(bench, if1):
    """Programming a sequence: "The sequence starts as soon as the "<CR>" is received"."""
    if1.serial.write(b":X10@200:Y:$")
    bench.run(5.0)
    assert positions(if1) == (0, 0, 0)

    begun_ns = bench.now
    if1.serial.write(b"\r")
    bench.run(1.0)
    assert positions(if1) == (10, 10, 0)
    # one character (1.1 ms), about 1 ms to the input buffer, one period of 5 ms to the first pulse
    assert times(if1.axes["X"])[0] - begun_ns < 9 * MS


@pytest.mark.parametrize("again", ["::$", ":$", ": : $", ": $"])
def test_the_whole_sequence_can_be_repeated_without_sending_it_again(bench, if1, again):
    """Programming a sequence: "repeated by simply sending "::$<CR>""; R14: `:$` does the same."""
    write(if1, ":X100@200:Y30:$")
    until_idle(bench, if1)
    assert positions(if1) == (100, 30, 0)

    write(if1, again)
    until_idle(bench, if1)
    assert (positions(if1), number(bench, if1, "F")) == ((200, 60, 0), 0)


def test_a_repeated_sequence_uses_the_data_of_now_where_a_step_states_none(bench, if1):
    """Speed: "The interface will remember any programmed data unless it is overwritten"."""
    write(if1, ":X:Y:$")
    until_idle(bench, if1)
    assert positions(if1) == (0, 0, 0)  # default index length 0
    write(if1, "Z70$")
    until_idle(bench, if1)
    write(if1, ":$")
    until_idle(bench, if1)
    assert positions(if1) == (70, 70, 70)


def test_what_a_step_states_holds_for_direct_messages_afterwards(bench, if1):
    """Digest 12: speed, distance, backlash and pulse length that a step sets stay in force for direct messages."""
    write(if1, ":X100@200:B-20:P2,30:$")
    until_idle(bench, if1)
    seen = edges(if1.pins["output1"])
    write(if1, "Y$")
    until_idle(bench, if1)
    write(if1, "ZB$")
    until_idle(bench, if1)
    write(if1, "P1$")
    until_idle(bench, if1)

    assert set(gaps(times(if1.axes["Y"]))) == {5 * MS}
    assert (moves(if1.axes["Y"]), moves(if1.axes["Z"])) == ([100], [120, -20])
    assert seen[1][0] - seen[0][0] == 300 * MS


def test_a_wider_variety_of_instructions(bench, if1):
    """Programming a sequence: output 2 on; inputs 1, 3 high then 2 low; Z; outputs 4, 1; output 2 off for 500 ms; Y."""
    for name in ("input1", "input3"):
        if1.pins[name].drive(False)
    if1.pins["input2"].drive(True)
    command(bench, if1, "S1$", seconds=0.1)
    out1, out2, out4 = (edges(if1.pins[f"output{n}"]) for n in (1, 2, 4))

    command(bench, if1, " : S2 : H13 L2 Z 100 @ 40 S4 R1 : P2, 50 : Y @ 200 : $", seconds=0.5)
    assert if1.pins["output2"].level and positions(if1) == (0, 0, 0)
    if1.pins["input1"].drive(True)
    bench.run(0.5)
    if1.pins["input2"].drive(False)  # this is too early, because input 3 is not high yet
    bench.run(0.5)
    if1.pins["input2"].drive(True)
    if1.pins["input3"].drive(True)
    bench.run(0.5)
    assert positions(if1) == (0, 0, 0)
    begun_ns = bench.now
    if1.pins["input2"].drive(False)
    until_idle(bench, if1)

    # 40 is not a multiple of 6.25: 6.4 rounds to 6, so 37.5 steps/s, a step every 26.667 ms
    z, y = times(if1.axes["Z"]), times(if1.axes["Y"])
    assert len(z) == 100 and {26_666_666, 26_666_667} == set(gaps(times(if1.axes["Z"])))
    assert len(y) == 100 and set(gaps(times(if1.axes["Y"]))) == {5 * MS}
    assert z[0] - begun_ns < 30 * MS
    assert out4 == [(z[-1], True)] and out1 == [(z[-1], False)]
    assert out2[1:] == [(z[-1], False), (z[-1] + 500 * MS, True)]
    assert y[0] == z[-1] + 500 * MS + 5 * MS


@scripts(
    {
        'Combining inputs: "a low-to-high transition ... can be performed using the Sequence Mode"':
        "input2 high; :L2:H2X10@200:$; 1 s; at 0 0 0; input2 low; 1 s; at 0 0 0; input2 high; 1 s; at 10 0 0",
        'Speed: "If a speed is requested which is above the maximum for that range, ... a range error fault"':
        ":X10@200:Y@25001:$; 2 s; F: 16",
        'Programming a sequence: "terminate the incorrect sequence by sending ": $ # <CR>""':
        ":X1000@200:Y50:X-77: $ #; 1 s; at 0 0 0; E: C; F: 0; :X100@200:Y50:$; idle; at 100 50 0",
        'Programming a sequence: a mistake; "The sequence may then be re-entered"':
        ":X1000@200:Q?W9:$#; 0.1 s; :X100@200:Y50:$; idle; at 100 50 0",
        'Sequence status: "The command "O" (letter O, not the number zero)"': "0; 0.2 s; F: 8",
        "Digest 12: repeats, `%`, backlash and waits are steps too":
        "input1 low; :B-5:S1:X1@400:=1,3:P0,1:H1:Y3:$; 1 s; O: 6; input1 high; 0.5 s; O: 7; at 2 3 0",
        'Busy status: "also encompasses "motionless" activities such as waiting for inputs and pulsing outputs"':
        "input1 low; :H1:P1,50:X100@200:$; 0.1 s; E: E; K: 0; input1 high; 0.1 s; E: E; K: 0; 0.5 s; E: E; "
        "K: 3; 1 s; E: C; K: 0",
    }
)  # fmt: skip
def test_sequences_from_start_to_end(bench, if1, script):
    play(bench, if1, script)


def test_63_operations_are_possible(bench, if1):
    """Programming a sequence: "a sequence of up to 63 separate operations"."""
    command(bench, if1, ":" + "X1@400:" * 62 + "Y7:$", seconds=2.0)
    assert (positions(if1), number(bench, if1, "O"), number(bench, if1, "F")) == ((62, 7, 0), 63, 0)


def test_a_64th_operation_is_out_of_range_and_drops_the_sequence(bench, if1):
    """R35: a sequence of more than 63 steps sets F 16, and none of it runs."""
    for _ in range(64):  # sent slowly, so that the input buffer loses nothing
        if1.serial.write(b":X1")
        bench.run(0.01)
    if1.serial.write(b":$\r")
    bench.run(1.0)
    assert (positions(if1), status_word(bench, if1), number(bench, if1, "F")) == ((0, 0, 0), 128, 16)


@pytest.mark.parametrize("parameter", ["<5", ">2", "^20", "D1"])
def test_ramp_parameters_cannot_be_placed_within_a_sequence(bench, if1, parameter):
    """Programming a sequence: "start/stop rate, speed range and acceleration rate cannot be placed within"."""
    command(bench, if1, f":X10@200:{parameter}:Y:$", seconds=3.0)
    assert (positions(if1), status_word(bench, if1), number(bench, if1, "F")) == ((0, 0, 0), 128, 8)


@pytest.mark.parametrize(
    "step",
    ["X10H1", "R1S2", "L1H2", "S1X10", "P1,5X10", "S1P2,5", "X10A", "=2,1A", "=2,1H1", "A=2", "=2", "=,1", "H4", "S6",
     "W", "x10", "X10:K", "]", "[", "("],
)  # fmt: skip
def test_a_step_in_the_wrong_order_is_a_data_fault(bench, if1, step):
    """Programming a sequence: "The format used ... is the same as in direct mode"; R7: F 8, all of it ignored."""
    for name in ("input1", "input2"):
        if1.pins[name].drive(True)
    command(bench, if1, f":Y5@200:{step}:Y6:$", seconds=2.0)
    assert (positions(if1), status_word(bench, if1)) == ((0, 0, 0), 128)
    assert number(bench, if1, "F") in (8, 16)  # 16 for a number out of its range, 8 for everything else


def test_a_carriage_return_inside_an_unfinished_sequence_drops_it(bench, if1):
    """R34: a sequence is one message; without its `$` it is a data fault."""
    command(bench, if1, ":X100@200:Y50:", "X-:$", seconds=2.0)
    assert (positions(if1), number(bench, if1, "F")) == ((0, 0, 0), 8)


def test_a_move_asked_for_while_a_sequence_runs_is_held_until_it_is_over(bench, if1):
    """R9: a message with `$` waits until the sequence is over; status is answered "at any time"."""
    command(bench, if1, ":X100@200:Y:$", seconds=0.1)
    write(if1, "Z60$")
    assert (ask(bench, if1, "E", 0.8), positions(if1)[2]) == (b"E\r", 0)
    bench.run(1.2)
    assert positions(if1) == (100, 100, 60)
    assert times(if1.axes["Z"])[0] >= times(if1.axes["Y"])[-1]


def test_cancel_acts_at_once_though_a_message_is_held(bench, if1):
    """R9: "`#` acts at once", and throws away what was sent before it and has not been executed."""
    command(bench, if1, ":X1000@200:Y:=0,1:$", seconds=1.0)
    write(if1, "Z60$", "@500", "E")
    bench.run(0.1)
    write(if1, "#")
    bench.run(5.0)
    assert positions(if1)[0] < 250 and positions(if1)[1:] == (0, 0)
    assert if1.serial.read() == b"E\r"  # status is answered "at any time"
    assert status(bench, if1, "E") == "C"


def test_what_is_sent_behind_a_cancel_is_done_when_the_axis_stands(bench, if1):
    """R9: a move sent after cancel begins when the deceleration has ended."""
    command(bench, if1, "X-9000@5000$", seconds=1.0)
    command(bench, if1, "#", ":X20@200:Y30:$", seconds=3.0)
    assert moves(if1.axes["X"])[1] == 20 and positions(if1)[1] == 30


def test_with_the_option_a_move_asked_for_while_a_sequence_runs_is_ignored(bench):
    """R9: "Alternative: ignore. Make it an option": a move during a sequence is then ignored."""
    if1 = ready(bench, busy="ignore")
    command(bench, if1, ":X100@200:Y:$", seconds=0.1)
    write(if1, "Z60$")
    assert status(bench, if1, "E") == "E"
    bench.run(3.0)
    assert positions(if1) == (100, 100, 0)


def test_sequence_status_counts_the_steps(bench, if1):
    """Sequence status: "a number between 1 and 63 giving the current step in the sequence"; R19: letter O."""
    assert number(bench, if1, "O") == 0
    command(bench, if1, ":X200@200:Y:X-:Y-:$", seconds=0.5)
    for step in (1, 2, 3, 4):
        assert number(bench, if1, "O") == step
        bench.run(0.95)
    assert positions(if1) == (0, 0, 0)
    assert number(bench, if1, "O") == 4  # R19: the last step executed
    write(if1, "Z100$")
    until_idle(bench, if1)
    assert number(bench, if1, "O") == 4


def test_the_backlash_correction_can_be_changed_from_step_to_step(bench, if1):
    """Backlash correction in sequence mode: 20 steps negative for the X move, 50 positive for the Y move."""
    write(if1, " : B - 20 : X 1000 B : B + 50 : Y - 400 B : $")
    until_idle(bench, if1)

    assert (moves(if1.axes["X"]), moves(if1.axes["Y"])) == ([1020, -20], [-450, 50])
    assert positions(if1) == (1000, -400, 0)
    for axis, first in ((if1.axes["X"], 1020), (if1.axes["Y"], 450)):
        pulses = times(axis)
        assert pulses[first] - pulses[first - 1] >= 3 * MS + 2_500_000  # the pause and one period at 400 steps/s
        assert set(gaps(pulses[first:])) == {2_500_000}


def test_a_correction_below_the_start_stop_speed_runs_at_start_stop_speed(bench, if1):
    """Backlash correction: "applied at the programmed start/stop speed"; R26."""
    write(if1, ":B-20:X100@100B:$")
    until_idle(bench, if1)
    x = times(if1.axes["X"])
    assert set(gaps(x[:120])) == {10 * MS}
    assert set(gaps(x[120:])) == {2_500_000}


def test_an_index_of_no_length_has_no_backlash_to_correct(bench, if1):
    """Digest 9: "Distance 0: no pulse, done at once", also for an index with B after a run has cleared the length."""
    command(bench, if1, ":B-20:X0B:B+20:Y-B:$", seconds=1.0)
    assert times(if1.axes["X"]) == times(if1.axes["Y"]) == []


@pytest.mark.parametrize("text", [":B20:X100B:$", ":B:X100B:$"])
def test_the_backlash_direction_must_always_be_specified(bench, if1, text):
    """Backlash correction in sequence mode: "the backlash direction must always be specified"."""
    command(bench, if1, text, seconds=2.0)
    assert (number(bench, if1, "F"), positions(if1)) == (8, (0, 0, 0))


def test_output_0_makes_a_delay_after_a_move(bench, if1):
    """Adding time delays: "will wait for 500mS after the X move before continuing the sequence"."""
    outputs = [edges(if1.pins[f"output{n}"]) for n in range(1, 6)]
    write(if1, ":X1000P0,50:Y10:$")
    until_idle(bench, if1)
    # default speed 400: 2.5 ms from the beginning of the Y move to its first pulse
    x, y = times(if1.axes["X"])[-1], times(if1.axes["Y"])[0]
    assert y - x == 500 * MS + 2_500_000
    assert outputs == [[], [], [], [], []]


def test_longer_delays_come_from_repeating_the_pulse_command(bench, if1):
    """Adding time delays: "Delays longer than 990mS can be obtained by repeating the pulse command"."""
    write(if1, ":X10:P0,99:P0,99:=1,2:P0:Y10:$")
    until_idle(bench, if1)
    x, y = times(if1.axes["X"])[-1], times(if1.axes["Y"])[0]
    delay = 5 * 990 * MS + 2_500_000  # four delays, one more of the remembered length, and the first period
    assert delay <= y - x <= delay + 2 * OWN_TIME_NS  # `=` is executed twice


def test_pulses_and_switching_together_need_two_steps(bench, if1):
    """Combining inputs and outputs: "cannot be pulsed at the same time as other outputs ... (see Sequence Mode)"."""
    one, two = edges(if1.pins["output1"]), edges(if1.pins["output2"])
    command(bench, if1, "X10S1P2,5$", seconds=0.5)
    assert positions(if1) == (0, 0, 0) and number(bench, if1, "F") == 8
    write(if1, ":X10S1:P2,5:$")
    until_idle(bench, if1)
    end_ns = times(if1.axes["X"])[-1]
    assert one == [(end_ns, True)]
    assert two == [(end_ns, True), (end_ns + 50 * MS, False)]


def test_a_sequence_moves_several_axes_at_once(bench, if1):
    """Index mode: "More than one axis may be selected"; also in a step (sample 3: `X-Y-Z-R1`)."""
    write(if1, ":X-Y-ZR1:XYS2:$")
    until_idle(bench, if1)
    write(if1, "X100$")
    until_idle(bench, if1)
    write(if1, ":$")
    until_idle(bench, if1)
    assert positions(if1) == (100, 0, 100)
    x = times(if1.axes["X"])
    assert x[100:] == times(if1.axes["Y"])


@pytest.mark.parametrize("form", ["U61", "V61"])
def test_the_long_sequence_of_samples_3_6_and_9(bench, form):
    """Samples 3, 6, 9: ten moves between outputs, for ever (R30: `:=0,1:` it is); speed 10,000 here as in sample 3."""
    if1 = ready(bench, form)
    text = ":R12345:H1:X1000@10000S1:X-S2:YS3:Y-S4:ZS5:Z-R5:XYZR4:X-Y-Z-R3:X-YZR2:XY-Z-R1:=0,1: $"
    if1.serial.write(text.encode() + (b"\n" if form[0] == "V" else b"\r"))
    bench.run(1.0)
    assert positions(if1) == (0, 0, 0)
    if1.pins["input1"].drive(True)
    first = edges(if1.pins["output1"])
    # Up from 400 to 10000 in steps of 100 every 10 ms is longer than half of 1000 steps, so the index is short:
    # levels of 4, 5, 6 ... pulses.  28 levels take 490 pulses, 29 would take 522.  The 1000 - 980 = 20 left over run
    # at the next level, 3200/s: 6.25 ms.  One index: 56 x 10 ms + 6.25 ms = 566.25 ms.  Ten of them: 5.6625 s.
    assert sum(range(4, 32)) == 490
    bench.run(20.0)
    ons = [at_ns for at_ns, level in first if level]
    rounds = set(gaps(ons))
    assert len(ons) == 4 and len(rounds) == 1
    # R12345, H1 and = take only the interface's own time
    assert 5_662_500_000 <= rounds.pop() <= 5_662_500_000 + 3 * OWN_TIME_NS


def test_the_virtual_clock_of_a_sequence_is_exact(bench, if1):
    """Adding time delays and index mode: no time is lost between steps."""
    seen = edges(if1.pins["output1"])
    write(if1, ":S1:X100@400:P0,25:Y-40@200:R1:$")
    until_idle(bench, if1)
    assert [level for _, level in seen] == [True, False]
    exact = S // 4 + S // 4 + S // 5
    assert exact <= seen[1][0] - seen[0][0] <= exact + OWN_TIME_NS


@pytest.mark.parametrize("wrong", [":Y10:=2,9:$", ":y10:$", ":" + "Y1:" * 64 + "$", ":Y10@99999:$", ":Y10", ":Y10:$#"])
def test_a_sequence_that_is_refused_or_cancelled_leaves_the_old_one(bench, if1, wrong):
    """Programming a sequence: "If a mistake is made ...  The sequence may then be re-entered"; the old one is kept."""
    write(if1, ":X10:$")
    until_idle(bench, if1)
    each_character(bench, if1, wrong + "\r", lambda n: bench.run(0.002))
    bench.run(0.5)
    command(bench, if1, ":$")
    assert positions(if1) == (20, 0, 0)


@pytest.mark.parametrize("setting", ["<2", "^20", ">2"])
def test_ramp_data_during_a_sequence_wait_for_its_end(bench, if1, setting):
    """Programming a sequence: ramp data "cannot be placed within a sequence"; sent to a running one, they wait."""
    command(bench, if1, ":X200@400:Y:$", seconds=0.1)
    command(bench, if1, setting, seconds=0.1)
    assert ask(bench, if1, "E") == b"E\r"  # the ramp is not calculated yet
    assert bench.run_until(lambda: not if1.axes["X"].moving and not if1.axes["Y"].moving, 2)
    bench.run_until(lambda: if1.axes["Y"].position == 200 and not if1.axes["Y"].moving, 2)
    assert (positions(if1), send(bench, if1, "E", seconds=0.98)) == ((200, 200, 0), b"")
    bench.run(0.1)
    assert if1.serial.read() == b"C\r"


def test_a_sequence_that_faulted_out_may_run_again_before_f_is_read(bench, if1):
    """Interpolation in sequence mode: "a status request must be made"; Clearing: "movement will not be inhibited"."""
    command(bench, if1, ">2", seconds=1.2)
    command(bench, if1, ":X100/Y50:$")
    assert positions(if1) == (0, 0, 0)
    command(bench, if1, ">1", seconds=1.2)
    command(bench, if1, ":$", seconds=0.5)
    assert (positions(if1), ask(bench, if1, "F")) == ((100, 50, 0), b"16\r")
