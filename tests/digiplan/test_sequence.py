"""Sequence mode: programming a sequence, running it again, mistakes while entering, backlash, delays."""

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .talking import OWN_TIME_NS, command, edges, gaps, play, positions, ready, times, until_idle


@scripts({
    'Programming a sequence: "four moves which cause an X-Y system to describe a square"; 200 = 32 x 6.25':
    ": X 1000 @ 200 : Y : X- : Y- : $; until X at 1000; X 1000 pulses at 200; until Y at 1000; "
    "Y 1000 pulses at 200; at 1000 1000 0; until X at 0; X 1000 pulses at 200; at 0 1000 0; until Y at 0; "
    "Y 1000 pulses at 200; idle; X moves 1000 -1000; Y moves 1000 -1000; at 0 0 0",
    'Programming a sequence: "The sequence starts as soon as the "<CR>" is received"; first pulse after 5 ms':
    "sends :X10@200:Y:$; 5 s; at 0 0 0; sends <CR>; 0.009 s; at 1 0 0; 1 s; at 10 10 0",
    'Programming a sequence: "repeated by simply sending "::$<CR>""; R14: `:$` does the same':
    ":X100@200:Y30:$; idle; at 100 30 0; ::$; idle; at 200 60 0; :$; idle; at 300 90 0; : : $; idle; "
    "at 400 120 0; : $; idle; at 500 150 0; F: 0",
    'Speed: "The interface will remember any programmed data unless it is overwritten": a step without data':
    ":X:Y:$; idle; at 0 0 0; Z70$; idle; :$; idle; at 70 70 70",
    "Digest 12: speed, distance, backlash and pulse length that a step sets stay in force for direct messages":
    ":X100@200:B-20:P2,30:$; idle; Y$; idle; Y moves 100; Y 100 pulses at 200; ZB$; idle; Z moves 120 -20; "
    "P1$; idle; output1 high for 300 ms",
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
    "R34: a sequence is one message; without its `$` it is a data fault":
    ":X100@200:Y50:; X-:$; 2 s; at 0 0 0; F: 8",
    "R9: a message with `$` waits until the sequence is over": ":X100@200:Y:$; 0.1 s; Z60$; E: E; 0.75 s; Z at 0; "
    "until Z moving; at 100 100 0; 0.5 s; at 100 100 60",
    'R9: "`#` acts at once", and discards a held message; status is answered "at any time"':
    ":X1000@200:Y:=0,1:$; 1 s; Z60$; @500; E: E; 0.1 s; #; 5 s; X between 1 249; Y at 0; Z at 0; E: C",
    "R9: a sequence sent after cancel begins when the deceleration has ended":
    "X-9000@5000$; 1 s; #; :X20@200:Y30:$; 3 s; X 20 pulses at 200; Y at 30",
    'Sequence status: "a number between 1 and 63 giving the current step in the sequence"; R19: the last one after':
    "O: 0; :X200@200:Y:X-:Y-:$; 0.5 s; O: 1; 0.95 s; O: 2; 0.95 s; O: 3; 0.95 s; O: 4; 0.95 s; at 0 0 0; O: 4; "
    "Z100$; idle; O: 4",
    "Backlash correction in sequence mode: 20 steps negative for the X move, 50 positive for the Y move":
    " : B - 20 : X 1000 B : B + 50 : Y - 400 B : $; idle; X moves 1020 -20; Y moves -450 50; at 1000 -400 0; "
    "X 20 pulses at 400; X begins 3 to 5 ms after X; Y 50 pulses at 400; Y begins 3 to 5 ms after Y",
    'Backlash correction: "applied at the programmed start/stop speed", also after a slower move (R26)':
    ":B-20:X100@100B:$; until X at 120; X 120 pulses at 100; idle; X moves 120 -20; X 20 pulses at 400",
    'Backlash correction in sequence mode: "the backlash direction must always be specified"':
    ":B20:X100B:$; 2 s; F: 8; :B:X100B:$; 2 s; F: 8; at 0 0 0",
    'Adding time delays: "will wait for 500mS after the X move before continuing the sequence"; Y: 1 / 400 s more':
    ":X1000P0,50:Y10:$; idle; Y begins 500 to 500 ms after X; outputs unchanged; Y 10 pulses at 400",
    'Adding time delays: "Delays longer than 990mS can be obtained by repeating the pulse command": 5 x 990 ms':
    ":X10:P0,99:P0,99:=1,2:P0:Y10:$; idle; Y begins 4950 to 4952 ms after X",
    'Combining inputs and outputs: "cannot be pulsed at the same time as other outputs ... (see Sequence Mode)"':
    "X10S1P2,5$; 0.5 s; at 0 0 0; F: 8; :X10S1:P2,5:$; until X at 10; outputs 11000; idle; output2 high for 50 ms",
    'Index mode: "More than one axis may be selected"; also in a step (sample 3: `X-Y-Z-R1`)':
    ":X-Y-ZR1:XYS2:$; idle; X100$; idle; :$; idle; at 100 0 100; X like Y",
    "Adding time delays and index mode: a sequence takes 250 + 250 + 200 ms":
    ":S1:X100@400:P0,25:Y-40@200:R1:$; idle; output1 high for 700 to 701 ms",
    'Programming a sequence: "start/stop rate, speed range and acceleration rate cannot be placed within"':
    ":X10@200:{<5|>2|^20|D1}:Y:$; 3 s; at 0 0 0; K: 128; F: 8",
    'Programming a sequence: ramp data "cannot be placed within a sequence"; sent to a running one, they wait':
    ":X200@400:Y:$; 0.1 s; {<2|^20|>2}; E: E; until Y at 200; E; 0.98 s; at 200 200 0; 0.1 s; receives C<CR>",
    'Interpolation in sequence mode: "a status request must be made"; Clearing: "movement will not be inhibited"':
    ">2; 1.2 s; :X100/Y50:$; 0.2 s; at 0 0 0; >1; 1.2 s; :$; 0.5 s; at 100 50 0; F: 16",
})  # fmt: skip
def test_sequences_from_start_to_end(bench, if1, script):
    play(bench, if1, script)


def test_a_wider_variety_of_instructions(bench, if1):
    """Programming a sequence: output 2 on; inputs 1, 3 high then 2 low; Z; outputs 4, 1; output 2 off for 500 ms; Y."""
    out1, out2, out4 = (edges(if1.pins[f"output{n}"]) for n in (1, 2, 4))
    play(
        bench,
        if1,
        "input1 low; input3 low; input2 high; S1$; 0.1 s;  : S2 : H13 L2 Z 100 @ 40 S4 R1 : P2, 50 : Y @ 200 : $; "
        "0.5 s; outputs 11000; input1 high; 0.5 s; input2 low; 0.5 s; input2 high; input3 high; 0.5 s; at 0 0 0",
    )  # that low on input 2 was too early, because input 3 was not high yet
    begun_ns = bench.now
    if1.pins["input2"].drive(False)
    until_idle(bench, if1)

    # 40 is not a multiple of 6.25: 6.4 rounds to 6, so 37.5 steps/s, a step every 26.667 ms
    z, y = times(if1.axes["Z"]), times(if1.axes["Y"])
    assert len(z) == 100 and {26_666_666, 26_666_667} == set(gaps(z))
    assert len(y) == 100 and set(gaps(y)) == {5 * MS}
    assert z[0] - begun_ns < 30 * MS and (out4, out1[1:]) == ([(z[-1], True)], [(z[-1], False)])
    assert out2[1:] == [(z[-1], False), (z[-1] + 500 * MS, True)] and y[0] == z[-1] + 500 * MS + 5 * MS


def test_63_operations_are_possible(bench, if1):
    """Programming a sequence: "a sequence of up to 63 separate operations"."""
    play(bench, if1, ":" + "X1@400:" * 62 + "Y7:$; 2 s; at 62 7 0; O: 63; F: 0")


def test_63_operations_that_set_everything_are_possible(bench, if1):
    """R35: the manual limits the steps of a sequence, not their characters.  Here are 2,144."""
    step = "H3X+Y-Z0000000001@00400S1234R1234"
    play(bench, if1, f"input3 high; slowly :{':'.join([step] * 63)}:$; 30 s; O: 63; F: 0; at 63 -63 63")


def test_a_64th_operation_is_out_of_range_and_drops_the_sequence(bench, if1):
    """R35: a sequence of more than 63 steps sets F 16, and none of it runs."""
    play(bench, if1, "slowly " + ":X1" * 64 + ":$; 1 s; at 0 0 0; K: 128; F: 16")


@pytest.mark.parametrize("step", [
    "X10H1", "R1S2", "L1H2", "S1X10", "P1,5X10", "S1P2,5", "X10A", "=2,1A", "=2,1H1", "A=2", "=2", "=,1", "H4", "S6",
    "W", "x10", "X10:K", "]", "[", "("])  # fmt: skip
def test_a_step_in_the_wrong_order_is_a_data_fault(bench, if1, step):
    """Programming a sequence: "The format used ... is the same as in direct mode"; R7: F 8, all of it ignored."""
    # F is 16 for a number out of its range, 8 for everything else
    play(bench, if1, f"input1 high; input2 high; sends :Y5@200:{step}:Y6:$<CR>; 2 s; at 0 0 0; K: 128; F: 8|16")


def test_with_the_option_a_move_asked_for_while_a_sequence_runs_is_ignored(bench):
    """R9: "Alternative: ignore. Make it an option": a move during a sequence is then ignored."""
    play(bench, ready(bench, busy="ignore"), ":X100@200:Y:$; 0.1 s; Z60$; E: E; 3 s; at 100 100 0")


def test_an_index_of_no_length_has_no_backlash_to_correct(bench, if1):
    """Digest 9: "Distance 0: no pulse, done at once", also for an index with B after a run has cleared the length."""
    command(bench, if1, ":B-20:X0B:B+20:Y-B:$", seconds=1.0)
    assert times(if1.axes["X"]) == times(if1.axes["Y"]) == []


@pytest.mark.parametrize(("form", "end"), [("U61", "\r"), ("V61", "\n")])
def test_the_long_sequence_of_samples_3_6_and_9(bench, form, end):
    """Samples 3, 6, 9: ten moves between outputs, for ever (R30: `:=0,1:` it is); speed 10,000 here as in sample 3."""
    if1 = ready(bench, form)
    text = ":R12345:H1:X1000@10000S1:X-S2:YS3:Y-S4:ZS5:Z-R5:XYZR4:X-Y-Z-R3:X-YZR2:XY-Z-R1:=0,1: $"
    command(bench, if1, text, seconds=1.0, end=end)
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


@pytest.mark.parametrize("wrong", [":Y10:=2,9:$", ":y10:$", ":" + "Y1:" * 64 + "$", ":Y10@99999:$", ":Y10", ":Y10:$#"])
def test_a_sequence_that_is_refused_or_cancelled_leaves_the_old_one(bench, if1, wrong):
    """Programming a sequence: "If a mistake is made ...  The sequence may then be re-entered"; the old one is kept."""
    play(bench, if1, f":X10:$; idle; slowly {wrong}; 0.5 s; :$; 0.2 s; at 20 0 0")
