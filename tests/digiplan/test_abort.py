"""Sequence mode: aborting a run-mode move in a sequence."""

from fractions import Fraction

from axistwin.core.units import MS, S

from ..scripts import scripts
from .talking import command, gaps, moves, play, pulse_times_of, since_start, start_ns, times

# A run at 1000 steps/s from the default start/stop 400, acceleration 10,000, range 1: levels 400 ... 900 of 10 ms each,
# 4 + 5 + 6 + 7 + 8 + 9 = 39 pulses, and the same on the way down.
RAMP, RAMP_NS = 39, 60 * MS


def test_a_run_is_stopped_again_by_a_high_level(bench, if1):
    """Aborting: "start the X motor ..., and will stop it again when a high level is seen"."""
    play(bench, if1, "input1 low; : X @ 1000 G : H1 A : $; 10 s; E: E; K: 3; O: 2")
    x = times(if1.axes["X"])
    assert set(gaps(x[RAMP:])) == {1 * MS}
    before, at_ns = len(x), bench.now
    play(bench, if1, "input1 high; 1 s; E: C; K: 0")
    x = times(if1.axes["X"])
    assert RAMP <= len(x) - before <= RAMP + 51  # up to 50 ms have passed with requests of O
    assert x[-1] - at_ns <= RAMP_NS + 2 * MS


def test_the_stop_is_a_deceleration_along_the_ramp(bench, if1):
    """Aborting: A decelerates a run through the same levels as the cancel code does."""
    command(bench, if1, ":X@1000G:H1A:$", seconds=2.0)
    stop_ns = bench.now
    if1.pins["input1"].drive(True)
    bench.run(1.0)
    level_s = Fraction(1, 100)
    up = [(rate, level_s) for rate in range(400, 1000, 100)]
    along = (1000, Fraction(stop_ns - start_ns(if1.axes["X"]), S) - 6 * level_s)
    assert since_start(if1.axes["X"]) == pulse_times_of([*up, along, *reversed(up)])


@scripts({
    # 206 / 6.25 = 32.96, so 33 x 6.25 = 206.25 steps/s
    "Aborting, after a delay instead of an input: a run of 500 ms at 206.25 steps/s is 103 steps":
    ":X@206G:P0,50:A:Y7:$; idle; at 103 7 0",
    # up 39 in 60 ms, 440 ms at 1000 steps/s, down 39: 518; the phase at the cut adds no more than one
    "Aborting: there is one ramp generator, so the Y move begins when the X axis is at rest":
    ":X@1000G:P0,50:A:Y20@400:$; idle; Y begins 0 to 5 ms after X; X between 518 520; Y at 20",
    "Aborting: a run-mode move is followed by other steps":
    ":X@1000G:S1:P2,50:H1A:$; 0.2 s; output1 is high; output2 is high; 1 s; output2 is low; K: 3",
    'Run mode: "the data used in a previous index will be lost ... default to zero index length"':
    ":Z100@200:X@206G:P0,50:A:Y:Z30:$; idle; at 103 0 130",
    "Aborting: a run started by a sequence continues until it is stopped":
    ":X@200G:$; 10 s; K: 3; E: E; #; 0.2 s; K: 0; E: C",
    "Aborting without a run: the sequence continues": ":A:X10@400:A:Y10:$; idle; at 10 10 0; F: 0",
    'Command list: A is "Abort in Sequence Mode"; a direct message with it is a data fault (R7)':
    "X@200G$; 1 s; A$; 0.1 s; H1A$; 1 s; K: 131; F: 8",
    'R36: a move "waits until the run is stopped"; only the cancel code can stop it, which ends the sequence':
    ":X@200G:Y100:$; 20 s; Y at 0; K: 3; O: 2; E: E; #; 1 s; Y at 0; K: 0; E: C",
    'Aborting: "stop the run-mode move", of all its axes at the same time':
    ":X-Y@1000G:P0,99:A:$; idle; Y between 901 1100; X like Y; N: X; N: Y; X between -1100 -901",
    'Aborting, format: "Read inputs for high levels ... low levels ... Send abort command ... Send repeat data"':
    "input1 high; input2 low; :X@200G:P0,20:{L1A|H2L1A|H2L1A=0,3}:$; 1 s; K: 3; input2 high; 0.1 s; input1 low; "
    "0.1 s; K: 0",
})  # fmt: skip
def test_runs_in_a_sequence(bench, if1, script):
    play(bench, if1, script)


def test_the_repeat_command_can_be_combined_with_an_abort(bench, if1):
    """Aborting: ": H3 A = 2, 1 :" "the run will be aborted and the sequence will repeat twice from step 1"."""
    again = "; 1 s; K: 3; input3 high; 0.01 s; input3 low"
    play(bench, if1, f"input3 low; :X@200G:P0,5:H3A=2,1:${again * 3}; 1 s; E: C; K: 0")
    assert len(moves(if1.axes["X"])) == 3
