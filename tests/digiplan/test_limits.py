"""Emergency stop and limit inputs: the limit switches, and moving off a limit."""

import pytest

from axistwin.units import MS

from .talking import (
    command,
    edges,
    moves,
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

TRAVEL = {"limits": (-100, 2000)}
"""The minus switch opens below -100, the plus switch above 2000."""


@scripts(
    {
        'Clearing: "any axis in motion will stop"; below the start/stop speed at once':
        "X9000@400$; 10 s; at 2001 0 0; I: 216; N: 2001; K: 64",
        'Emergency stop and limit inputs: "and vice versa"': "X-9000@400$; 10 s; at -101 0 0; I: 232; K: 64",
        'Clearing: "driven off the limit in the opposite direction and no further status request need be made"':
        "X9000@400$; 8 s; K: 64; X-500$; idle; at 1501 0 0; X100$; idle; at 1601 0 0; K: 0",
        'Digest 14: "further movement refused until read"; the manual: "after a status request has been made"':
        "X9000@400$; 8 s; X-500$; Z-5$; 2 s; at 2001 0 0; K: 64; 2 s; at 2001 0 0",
        'Clearing: "a status request will be necessary ... and this will serve to reset the fault bit"':
        "X9000@400$; 8 s; K: 64; K: 0; K: 0; E: C; I: 216; led is high",
        "Run mode ends at a limit as an index does: a run is stopped by a limit":
        "X@400G$; 10 s; at 2001 0 0; K: 64; K: 0; X-G$; 10 s; at -101 0 0; K: 64",
    }
)  # fmt: skip
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
    assert opened == [(x[2000], False)]
    assert 57 * MS <= x[-1] - opened[0][0] <= 61 * MS


def test_the_wrong_direction_is_refused_before_and_after_the_request(bench):
    """Limit inputs: "the interface can only be driven in the negative direction ... after a status request"."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X9000@400$", seconds=8.0)
    command(bench, if1, "X10$", seconds=0.5)
    assert (positions(if1), status_word(bench, if1)) == ((2001, 0, 0), 64)
    command(bench, if1, "X10$", seconds=0.5)
    command(bench, if1, "X@200G$", seconds=0.5)
    assert positions(if1) == (2001, 0, 0)


def test_the_led_goes_out_when_the_limit_has_been_read_and_left(bench):
    """Inputs: "It will turn off after Motion Status has been read and the input removed"."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X9000@400$", seconds=8.0)
    assert if1.pins["led"].level
    status_word(bench, if1)
    write(if1, "X-1$")  # the switch at 2000 has closed again
    until_idle(bench, if1)
    assert positions(if1) == (2000, 0, 0)
    assert not if1.pins["led"].level


def test_the_limits_are_common_to_all_axes(bench):
    """Limit inputs: "Where more than one axis is used, connect the limit switches in series"."""
    if1 = ready(bench, X=TRAVEL, Y={"limits": (-50, 50)})
    command(bench, if1, "Y90@400$", seconds=1.0)
    assert (positions(if1), status_word(bench, if1)) == ((0, 51, 0), 64)
    for text in ("X10$", "Z10$", "XY10$", "X-Z10$"):
        command(bench, if1, text, seconds=0.5)
        status_word(bench, if1)
    assert positions(if1) == (0, 51, 0)
    command(bench, if1, "XYZ-10$", seconds=0.5)
    assert positions(if1) == (0, 51, 0)  # positive moves of X and Y are refused


@scripts(
    {
        "Limit inputs: common: negative movement is allowed while the positive limit is open":
        "limit_plus low; 0.1 s; K?; X-10@400$; idle; Y-20$; idle; X-Y-Z-5$; idle; at -15 -25 -5",
        "Both switches open at once (a broken wire common to both): nothing may move":
        "limit_plus low; limit_minus low; 0.1 s; I: 248; K?; X10$; 0.3 s; K?; X-10$; 0.3 s; K?; Y10$; 0.3 s; "
        "K?; Z-10$; 0.3 s; at 0 0 0; K?; limit_minus released; 0.1 s; K?; X-10$; idle; at -10 0 0",
    }
)  # fmt: skip
def test_open_limit_inputs(bench, script):
    play(bench, ready(bench), script)


def test_a_move_away_from_an_open_switch_is_not_stopped_by_it(bench):
    """Clearing: "apart from motion away from a limit switch"; the switch chatters while it is left."""
    if1 = ready(bench)
    if1.pins["limit_plus"].drive(False)
    bench.run(0.1)
    status_word(bench, if1)
    command(bench, if1, "X-400@400$")
    for level in (True, False, True, False, True):
        if1.pins["limit_plus"].drive(level)
        bench.run(0.01)
    bench.run(2.0)
    assert positions(if1) == (-400, 0, 0)


def test_a_limit_open_at_power_up(bench):
    """Limit inputs: "must remain connected to +24v for the interface to run"; only motion off the limit is possible."""
    if1 = bench.add("if1")
    if1.pins["limit_minus"].drive(False)
    bench.run(1.5)
    send(bench, if1, "(U61", seconds=1.5)
    command(bench, if1, "X-10$", seconds=0.5)
    assert (positions(if1), status_word(bench, if1)) == ((0, 0, 0), 64)
    write(if1, "X10$")
    until_idle(bench, if1)
    assert positions(if1) == (10, 0, 0)


def test_a_limit_stops_both_axes_of_an_interpolated_move(bench):
    """Clearing: "any axis in motion will stop", here because the minor axis reaches its limit."""
    if1 = ready(bench, Y={"limits": (-10, 100)})
    command(bench, if1, "X4000/Y1000@400$", seconds=5.0)
    x, y, _ = positions(if1)
    assert y == 101 and x in (404, 405)
    assert status_word(bench, if1) == 64


def test_a_sequence_ends_at_a_limit(bench):
    """R22: "ended, outputs as they are"; after the request it can be run again from the beginning."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, ":S1:X1500@400:R1:X-1000:=3,1:$", seconds=30.0)
    # 1500, 500, 2000, 1000, and then the switch before 2500
    assert positions(if1) == (2001, 0, 0)
    assert if1.pins["output1"].level
    assert status_word(bench, if1) == 64
    bench.run(5.0)
    assert (positions(if1), status(bench, if1, "E")) == ((2001, 0, 0), "C")
    write(if1, "X-1901$")
    until_idle(bench, if1)
    command(bench, if1, ":$", seconds=6.0)
    assert positions(if1)[0] < 1600


def test_a_backlash_correction_away_from_the_limit_that_the_move_found(bench):
    """Backlash and limit: if the overshoot opens the switch, no correction follows."""
    if1 = ready(bench, X={"limits": (-100, 105)})
    command(bench, if1, "B-20", "X100@400B$", seconds=2.0)
    assert (positions(if1), moves(if1.axes["X"]), status_word(bench, if1)) == ((106, 0, 0), [106], 64)


@scripts(
    {
        'Inputs: "Emergency stop or limit inputs will light the LED (red)"':
        "limit_minus low; 0.1 s; led is high; K: 64; limit_minus released; 0.1 s; K: 0; led is low",
        "Clearing: the bit stays until the request": "limit_plus low; 0.005 s; limit_plus released; 5 s; K: 64; K: 0",
    }
)  # fmt: skip
def test_a_limit_input_at_rest(bench, if1, script):
    play(bench, if1, script)


def test_emergency_stop_and_limit_at_once(bench, if1):
    """Clearing: any request clears the limit bit; the emergency stop bit is cleared only after its input has closed."""
    command(bench, if1, "X4000@400$", seconds=1.0)
    if1.pins["estop"].drive(False)
    if1.pins["limit_plus"].drive(False)
    bench.run(0.5)
    assert (status_word(bench, if1), status_word(bench, if1)) == (96, 32)
    if1.pins["estop"].release()
    bench.run(0.1)
    assert [status_word(bench, if1) for _ in range(2)] == [32, 0]
    x = positions(if1)[0]
    write(if1, "X-10$")
    until_idle(bench, if1)
    assert positions(if1)[0] == x - 10


@pytest.mark.parametrize("text", ["X-100@400$", "X-@400G$", "X-100/Y-50@400$", "X-100@400B$"])
def test_a_limit_that_opens_behind_the_motion_stops_it(bench, if1, text):
    """Clearing: "If a fault, emergency stop or limit condition arises, any axis in motion will stop"."""
    write(if1, text)
    bench.run_until(lambda: if1.axes["X"].moving, 1)
    bench.run(0.101)  # 40 pulses at 400 steps/s
    if1.pins["limit_plus"].drive(False)
    bench.run(1.0)
    assert (positions(if1)[0], status_word(bench, if1)) == (-40, 64)
    write(if1, "X-10$")  # away from the open switch
    until_idle(bench, if1)
    assert positions(if1)[0] == -50


@pytest.mark.parametrize("text", ["X-100@400$", "X-@400G$", "X-100/Y-50@400$", "X-100@400B$"])
def test_a_limit_that_opens_behind_the_motion_does_not_stop_it_where_that_is_asked_for(bench, text):
    """Limit inputs: "If the positive limit goes low ... can only be driven in the negative direction"."""
    if1 = ready(bench, limits="motion ahead")
    command(bench, if1, "B-5", text, seconds=0.1)
    if1.pins["limit_plus"].drive(False)
    bench.run(0.2)
    command(bench, if1, "#", seconds=0.1)
    assert positions(if1)[0] <= -100


def test_a_backlash_correction_does_not_drive_into_an_open_limit(bench, if1):
    """Limit inputs: with the negative limit open "the interface can only be driven" positively."""
    write(if1, "B-20")
    if1.pins["limit_minus"].drive(False)
    bench.run(0.1)
    assert status_word(bench, if1) == 64
    write(if1, "X100B$")
    settle_or_fault(bench, if1)
    assert positions(if1) == (120, 0, 0)  # only the first part; the 20 steps back would go towards the open switch
    assert status_word(bench, if1) == 64


def test_a_backlash_correction_comes_back_once_the_limit_has_closed(bench, if1):
    """Limit inputs: the level at the time of the correction counts, not the level when the index began."""
    write(if1, "B-20")
    if1.pins["limit_minus"].drive(False)
    bench.run(0.1)
    status_word(bench, if1)
    command(bench, if1, "X100B$", seconds=0.1)
    if1.pins["limit_minus"].release()
    until_idle(bench, if1)
    assert (positions(if1), status_word(bench, if1)) == ((100, 0, 0), 0)


def test_a_limit_that_opens_in_the_pause_of_a_backlash_correction_stops_it(bench, if1):
    """Backlash: "a pause of at least 3mS", without motion: a limit that opens in it prevents the correction."""
    write(if1, "B-20", "X100B$")
    bench.run_until(lambda: if1.axes["X"].moving, 1)
    bench.run(0.3)  # 120 pulses at 400 steps/s
    bench.run(0.001)
    if1.pins["limit_minus"].drive(False)
    bench.run(1.0)
    assert (positions(if1), status_word(bench, if1)) == ((120, 0, 0), 64)


WAITING = pytest.mark.parametrize("text", ["H1X100@400$", ":H1X100@400:$", ":H1:X100@400:$", ":P0,20:H1X100@400:$"])


@WAITING
def test_a_limit_touched_at_rest_and_not_read_refuses_what_is_waiting(bench, if1, text):
    """Clearing: "further movement is inhibited" until the status is read, for a waiting step or direct move too."""
    command(bench, if1, text, seconds=0.5)
    if1.pins["limit_minus"].drive(False)
    bench.run(0.1)
    if1.pins["limit_minus"].release()
    if1.pins["input1"].drive(True)
    bench.run(1.0)
    assert (positions(if1), status_word(bench, if1), status(bench, if1, "E")) == ((0, 0, 0), 64, "C")


@WAITING
@pytest.mark.parametrize(("pin", "made"), [("limit_minus", 100), ("limit_plus", 0)])
def test_a_limit_touched_at_rest_and_read_lets_what_is_waiting_move_away(bench, if1, text, pin, made):
    """Clearing: "driven off the limit in the opposite direction", by a waiting step or direct move too."""
    command(bench, if1, text, seconds=0.5)
    if1.pins[pin].drive(False)
    bench.run(0.1)
    assert status_word(bench, if1) == 64
    if1.pins["input1"].drive(True)
    bench.run(1.0)
    assert positions(if1) == (made, 0, 0)
    assert status_word(bench, if1) == (0 if made else 64)


def settle_or_fault(bench, controller):
    """Run until E answers that the interface is not busy, or a fault."""
    bench.run(0.1)
    bench.run_until(lambda: not controller.busy, 10)
