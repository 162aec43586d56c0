"""Emergency stop and limit inputs: the limit switches, and moving off a limit."""

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .talking import command, edges, play, positions, ready, send, times

TRAVEL = {"limits": (-100, 2000)}
"""The minus switch opens below -100, the plus switch above 2000."""


@scripts({
    'Clearing: "any axis in motion will stop"; below the start/stop speed at once':
    "X9000@400$; 10 s; at 2001 0 0; I: 216; N: 2001; K: 64",
    'Emergency stop and limit inputs: "and vice versa"': "X-9000@400$; 10 s; at -101 0 0; I: 232; K: 64",
    'Clearing: "driven off the limit in the opposite direction and no further status request need be made"':
    "X9000@400$; 8 s; K: 64; X-500$; idle; at 1501 0 0; X100$; idle; at 1601 0 0; K: 0",
    'Digest 14: "further movement refused until read"; the manual: "after a status request has been made"':
    "X9000@400$; 8 s; X-500$; Z-5$; 2 s; at 2001 0 0; K: 64; 2 s; at 2001 0 0",
    'Limit inputs: "the interface can only be driven in the negative direction ... after a status request"':
    "X9000@400$; 8 s; X10$; 0.5 s; at 2001 0 0; K: 64; X10$; 0.5 s; X@200G$; 0.5 s; at 2001 0 0",
    'Clearing: "a status request will be necessary ... and this will serve to reset the fault bit"':
    "X9000@400$; 8 s; K: 64; K: 0; K: 0; E: C; I: 216; led is high",
    'Inputs: "It will turn off after Motion Status has been read and the input removed": at 2000 the switch closes':
    "X9000@400$; 8 s; led is high; K?; X-1$; idle; at 2000 0 0; led is low",
    'Limit inputs: "can only be driven in the negative direction": an axis that makes no step goes nowhere':
    "X9000@400$; 8 s; K: 64; X0$; 0.5 s; K: 0; X-100/Y0$; 3 s; at 1901 0 0; K: 0",
    "Run mode ends at a limit as an index does: a run is stopped by a limit":
    "X@400G$; 10 s; at 2001 0 0; K: 64; K: 0; X-G$; 10 s; at -101 0 0; K: 64",
    # 1500, 500, 2000, 1000, and then the switch before 2500
    'R22: a sequence ends at a limit, "ended, outputs as they are"; after the request it can be run again':
    ":S1:X1500@400:R1:X-1000:=3,1:$; 30 s; at 2001 0 0; outputs 10000; K: 64; 5 s; at 2001 0 0; E: C; X-1901$; "
    "idle; :$; 6 s; X between 100 1599",
})  # fmt: skip
def test_a_limit_switch_of_x(bench, script):
    play(bench, ready(bench, X=TRAVEL), script)


def test_a_fast_move_decelerates_beyond_the_switch(bench):
    """Quick status: "a limit input has appeared whilst an axis is in motion and decelerating"."""
    if1 = ready(bench, X=TRAVEL)
    opened = edges(if1.pins["limit_plus"])
    command(bench, if1, "X9000@1000$", seconds=10.0)
    # 39 steps and 60 ms from 1000 down to 400
    assert positions(if1)[0] - 2001 in (38, 39, 40)
    x = times(if1.axes["X"])
    assert opened == [(x[2000], False)] and 57 * MS <= x[-1] - opened[0][0] <= 61 * MS


def test_the_limits_are_common_to_all_axes(bench):
    """Limit inputs: "Where more than one axis is used, connect the limit switches in series"."""
    if1 = ready(bench, X=TRAVEL, Y={"limits": (-50, 50)})
    play(bench, if1, "Y90@400$; 1 s; at 0 51 0; K: 64; X10$; 0.5 s; K?; Z10$; 0.5 s; K?; XY10$; 0.5 s; K?; X-Z10$; "
         "0.5 s; K?; at 0 51 0; XYZ-10$; 0.5 s; at 0 51 0")  # fmt: skip


def test_a_limit_open_at_power_up(bench):
    """Limit inputs: "must remain connected to +24v for the interface to run"; only motion off the limit is possible."""
    if1 = bench.add("if1")
    if1.pins["limit_minus"].drive(False)
    bench.run(1.5)
    send(bench, if1, "(U61", seconds=1.5)
    play(bench, if1, "X-10$; 0.5 s; at 0 0 0; K: 64; X10$; idle; at 10 0 0")


def test_a_limit_stops_both_axes_of_an_interpolated_move(bench):
    """Clearing: "any axis in motion will stop", here because the minor axis reaches its limit."""
    play(bench, ready(bench, Y={"limits": (-10, 100)}), "X4000/Y1000@400$; 5 s; Y at 101; X between 404 405; K: 64")


def test_a_backlash_correction_away_from_the_limit_that_the_move_found(bench):
    """Backlash and limit: if the overshoot opens the switch, no correction follows."""
    play(bench, ready(bench, X={"limits": (-100, 105)}), "B-20; X100@400B$; 2 s; at 106 0 0; X moves 106; K: 64")


@scripts({
    'Inputs: "Emergency stop or limit inputs will light the LED (red)"':
    "limit_minus low; 0.1 s; led is high; K: 64; limit_minus released; 0.1 s; K: 0; led is low",
    "Clearing: the bit stays until the request": "limit_plus low; 0.005 s; limit_plus released; 5 s; K: 64; K: 0",
    "Limit inputs: common: negative movement is allowed while the positive limit is open":
    "limit_plus low; 0.1 s; K?; X-10@400$; idle; Y-20$; idle; X-Y-Z-5$; idle; at -15 -25 -5",
    "Both switches open at once (a broken wire common to both): nothing may move":
    "limit_plus low; limit_minus low; 0.1 s; I: 248; K?; X10$; 0.3 s; K?; X-10$; 0.3 s; K?; Y10$; 0.3 s; "
    "K?; Z-10$; 0.3 s; at 0 0 0; K?; limit_minus released; 0.1 s; K?; X-10$; idle; at -10 0 0",
    'Clearing: "apart from motion away from a limit switch"; the switch chatters while it is left':
    "limit_plus low; 0.1 s; K?; X-400@400$; 0.2 s; limit_plus high; 0.01 s; limit_plus low; 0.01 s; "
    "limit_plus high; 0.01 s; limit_plus low; 0.01 s; limit_plus high; 2 s; at -400 0 0",
    "Clearing: any request clears the limit bit; the emergency stop bit only after its input has closed":
    "X4000@400$; 1 s; estop low; limit_plus low; 0.5 s; K: 96; K: 32; estop released; 0.1 s; K: 32; K: 0; mark; "
    "X-10$; idle; moved -10 0 0",
})  # fmt: skip
def test_a_limit_input_at_rest(bench, if1, script):
    play(bench, if1, script)


BEHIND = pytest.mark.parametrize("text", ["X-100@400$", "X-@400G$", "X-100/Y-50@400$", "X-100@400B$"])


@BEHIND
def test_a_limit_that_opens_behind_the_motion_stops_it(bench, if1, text):
    """Clearing: "If a fault, emergency stop or limit condition arises, any axis in motion will stop"."""
    # 0.101 s are 40 pulses at 400 steps/s; then -10 moves away from the open switch
    script = f"{text}; until X moving; 0.101 s; limit_plus low; 1 s; X at -40; K: 64; X-10$; idle; X at -50"
    play(bench, if1, script)


@BEHIND
def test_a_limit_that_opens_behind_the_motion_does_not_stop_it_where_that_is_asked_for(bench, text):
    """Limit inputs: "If the positive limit goes low ... can only be driven in the negative direction"."""
    script = f"B-5; {text}; 0.1 s; limit_plus low; 0.2 s; #; 0.1 s; X between -200 -100"
    play(bench, ready(bench, limits="motion ahead"), script)


@scripts({
    # only the first part: the 20 steps back would go towards the open switch
    'Limit inputs: with the negative limit open "the interface can only be driven" positively':
    "B-20; limit_minus low; 0.1 s; K: 64; X100B$; until X at 120; 0.5 s; at 120 0 0; K: 64",
    "Limit inputs: the level at the time of the correction counts, not the level when the index began":
    "B-20; limit_minus low; 0.1 s; K?; X100B$; 0.1 s; limit_minus released; idle; at 100 0 0; K: 0",
    'Backlash: "a pause of at least 3mS", without motion: a limit that opens in it prevents the correction':
    "B-20; X100B$; until X at 120; 0.001 s; limit_minus low; 1 s; at 120 0 0; K: 64",
})  # fmt: skip
def test_a_backlash_correction_towards_a_limit(bench, if1, script):
    play(bench, if1, script)


WAITING = pytest.mark.parametrize("text", ["H1X100@400$", ":H1X100@400:$", ":H1:X100@400:$", ":P0,20:H1X100@400:$"])


@WAITING
def test_a_limit_touched_at_rest_and_not_read_refuses_what_is_waiting(bench, if1, text):
    """Clearing: "further movement is inhibited" until the status is read, for a waiting step or direct move too."""
    script = "limit_minus low; 0.1 s; limit_minus released; input1 high; 1 s; at 0 0 0; K: 64; E: C"
    play(bench, if1, f"{text}; 0.5 s; {script}")


@pytest.mark.parametrize("text", ["H1X10$", "H1X10S1$"])
@pytest.mark.parametrize("pin", ["limit_minus", "estop", "x_fault"])
@pytest.mark.parametrize(("read", "made"), [("0.1 s", 0), ("K?", 10)])
def test_a_move_that_waits_is_accepted_while_a_fault_is_stored(bench, if1, text, pin, read, made):
    """Clearing: "further movement is inhibited": what counts is whether the status is read before the movement."""
    script = (
        f"{pin} low; 0.1 s; {pin} released; {text}; E: F; {read}; input1 high; 0.5 s; at {made} 0 0; K?; K: 0; E: C"
    )
    play(bench, if1, f"{script}; outputs {int('S' in text and made > 0)}0000")


@WAITING
@pytest.mark.parametrize(("pin", "made", "flag"), [("limit_minus", 100, 0), ("limit_plus", 0, 64)])
def test_a_limit_touched_at_rest_and_read_lets_what_is_waiting_move_away(bench, if1, text, pin, made, flag):
    """Clearing: "driven off the limit in the opposite direction", by a waiting step or direct move too."""
    play(bench, if1, f"{text}; 0.5 s; {pin} low; 0.1 s; K: 64; input1 high; 1 s; at {made} 0 0; K: {flag}")
