"""Emergency stop and limit inputs: the limit switches, and moving off a limit."""

import pytest

from axistwin.units import MS

from .talking import (
    command,
    edges,
    moves,
    number,
    positions,
    ready,
    send,
    status,
    status_word,
    times,
    until_idle,
    write,
)

TRAVEL = {"limits": (-100, 2000)}
"""The minus switch opens below -100, the plus switch above 2000."""


def test_the_limit_switch_stops_a_slow_move_where_it_opens(bench):
    """Clearing: "any axis in motion will stop"; below the start/stop speed at once."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X9000@400$", seconds=10.0)
    assert positions(if1) == (2001, 0, 0)
    assert number(bench, if1, "I") == 200 + 16
    assert (number(bench, if1, "N"), status_word(bench, if1)) == (2001, 64)


def test_the_negative_limit_stops_a_negative_move(bench):
    """Emergency stop and limit inputs: "and vice versa"."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X-9000@400$", seconds=10.0)
    assert positions(if1) == (-101, 0, 0)
    assert number(bench, if1, "I") == 200 + 32
    assert status_word(bench, if1) == 64


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


def test_the_system_can_be_driven_off_the_limit_after_the_request(bench):
    """Clearing: "driven off the limit in the opposite direction and no further status request need be made"."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X9000@400$", seconds=8.0)
    assert status_word(bench, if1) == 64
    write(if1, "X-500$")
    until_idle(bench, if1)
    assert positions(if1) == (1501, 0, 0)
    write(if1, "X100$")
    until_idle(bench, if1)
    assert (positions(if1), status_word(bench, if1)) == ((1601, 0, 0), 0)


def test_no_movement_before_the_limit_has_been_read(bench):
    """Digest 14: "further movement refused until read"; the manual: "after a status request has been made"."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X9000@400$", seconds=8.0)
    command(bench, if1, "X-500$", "Z-5$", seconds=2.0)
    assert (positions(if1), status_word(bench, if1)) == ((2001, 0, 0), 64)
    bench.run(2.0)
    assert positions(if1) == (2001, 0, 0)


def test_one_request_clears_the_limit_though_the_switch_is_still_open(bench):
    """Clearing: "a status request will be necessary ... and this will serve to reset the fault bit"."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X9000@400$", seconds=8.0)
    assert ([status_word(bench, if1) for _ in range(3)], status(bench, if1, "E")) == ([64, 0, 0], "C")
    assert number(bench, if1, "I") == 216
    assert if1.pins["led"].level


def test_the_led_goes_out_when_the_limit_has_been_read_and_left(bench):
    """Inputs: "It will turn off after Motion Status has been read and the input removed"."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X9000@400$", seconds=8.0)
    assert if1.pins["led"].level
    status_word(bench, if1)
    write(if1, "X-1$")  # at 2000 the switch is closed again
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
    assert positions(if1) == (0, 51, 0)  # X and Y are asked for positively


def test_other_axes_may_move_away_from_a_limit_too(bench):
    """Limit inputs: common: negative movement is allowed while the positive limit is open."""
    if1 = ready(bench)
    if1.pins["limit_plus"].drive(False)
    bench.run(0.1)
    status_word(bench, if1)
    for text in ("X-10@400$", "Y-20$", "X-Y-Z-5$"):
        write(if1, text)
        until_idle(bench, if1)
    assert positions(if1) == (-15, -25, -5)


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


def test_the_opposite_limit_does_stop_a_move_away(bench):
    """Both switches open at once (a broken wire common to both): nothing may move."""
    if1 = ready(bench)
    for name in ("limit_plus", "limit_minus"):
        if1.pins[name].drive(False)
    bench.run(0.1)
    assert number(bench, if1, "I") == 248
    for text in ("X10$", "X-10$", "Y10$", "Z-10$"):
        status_word(bench, if1)
        command(bench, if1, text, seconds=0.3)
    assert positions(if1) == (0, 0, 0)
    status_word(bench, if1)
    if1.pins["limit_minus"].release()
    bench.run(0.1)
    status_word(bench, if1)
    write(if1, "X-10$")
    until_idle(bench, if1)
    assert positions(if1) == (-10, 0, 0)


def test_a_limit_open_at_power_up(bench):
    """Limit inputs "must remain connected to +24v for the interface to run"; off the limit it can be driven."""
    if1 = bench.add("if1")
    if1.pins["limit_minus"].drive(False)
    bench.run(1.5)
    send(bench, if1, "(U61", seconds=1.5)
    command(bench, if1, "X-10$", seconds=0.5)
    assert (positions(if1), status_word(bench, if1)) == ((0, 0, 0), 64)
    write(if1, "X10$")
    until_idle(bench, if1)
    assert positions(if1) == (10, 0, 0)


def test_a_run_is_stopped_by_a_limit(bench):
    """Run mode ends at a limit as an index does."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, "X@400G$", seconds=10.0)
    assert positions(if1) == (2001, 0, 0)
    assert (status_word(bench, if1), status_word(bench, if1)) == (64, 0)
    command(bench, if1, "X-G$", seconds=10.0)
    assert (positions(if1), status_word(bench, if1)) == ((-101, 0, 0), 64)


def test_a_limit_stops_both_axes_of_an_interpolated_move(bench):
    """Clearing: "any axis in motion will stop"; here the minor axis finds its limit."""
    if1 = ready(bench, Y={"limits": (-10, 100)})
    command(bench, if1, "X4000/Y1000@400$", seconds=5.0)
    x, y, _ = positions(if1)
    assert y == 101 and x in (404, 405)
    assert status_word(bench, if1) == 64


def test_a_sequence_ends_at_a_limit(bench):
    """R22: "ended, outputs as they are"; after the request it can be run again from the beginning."""
    if1 = ready(bench, X=TRAVEL)
    command(bench, if1, ":S1:X1500@400:R1:X-1000:=3,1:$", seconds=30.0)
    # 1500, 500, 2000, 1000 and on towards 2500
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
    """Backlash and limit: the overshoot opens the switch; there is no correction after a fault."""
    if1 = ready(bench, X={"limits": (-100, 105)})
    command(bench, if1, "B-20", "X100@400B$", seconds=2.0)
    assert (positions(if1), moves(if1.axes["X"]), status_word(bench, if1)) == ((106, 0, 0), [106], 64)


def test_a_limit_touched_at_rest_is_told_and_lights_the_led(bench, if1):
    """Inputs: "Emergency stop or limit inputs will light the LED (red)"."""
    if1.pins["limit_minus"].drive(False)
    bench.run(0.1)
    assert if1.pins["led"].level
    assert status_word(bench, if1) == 64
    if1.pins["limit_minus"].release()
    bench.run(0.1)
    assert (status_word(bench, if1), if1.pins["led"].level) == (0, False)


def test_a_limit_that_was_touched_and_left_is_still_told(bench, if1):
    """Clearing: the bit stays until the request."""
    if1.pins["limit_plus"].drive(False)
    bench.run(0.005)
    if1.pins["limit_plus"].release()
    bench.run(5.0)
    assert [status_word(bench, if1) for _ in range(2)] == [64, 0]


def test_emergency_stop_and_limit_at_once(bench, if1):
    """Clearing: each bit by its own rule: the limit by any request, the emergency stop only when it is gone."""
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
    assert positions(if1) == (120, 0, 0)  # the way there; 20 steps back would go into the open switch
    assert status_word(bench, if1) == 64


def test_a_backlash_correction_comes_back_once_the_limit_has_closed(bench, if1):
    """Limit inputs: the level counts, not what it was when the index began."""
    write(if1, "B-20")
    if1.pins["limit_minus"].drive(False)
    bench.run(0.1)
    status_word(bench, if1)
    command(bench, if1, "X100B$", seconds=0.1)
    if1.pins["limit_minus"].release()
    until_idle(bench, if1)
    assert (positions(if1), status_word(bench, if1)) == ((100, 0, 0), 0)


def test_a_limit_that_opens_in_the_pause_of_a_backlash_correction_stops_it(bench, if1):
    """Backlash: "a pause of at least 3mS"; nothing moves then, and the way back is refused."""
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
    """Clearing: "further movement is inhibited", in a sequence as in a direct move."""
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
    """Clearing: "driven off the limit in the opposite direction", in a sequence as in a direct move."""
    command(bench, if1, text, seconds=0.5)
    if1.pins[pin].drive(False)
    bench.run(0.1)
    assert status_word(bench, if1) == 64
    if1.pins["input1"].drive(True)
    bench.run(1.0)
    assert positions(if1) == (made, 0, 0)
    assert status_word(bench, if1) == (0 if made else 64)


def settle_or_fault(bench, controller):
    """Until it neither moves nor waits; E may be F."""
    bench.run(0.1)
    bench.run_until(lambda: not controller.busy, 10)
