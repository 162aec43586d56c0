"""Specifications, Inputs: how long a limit must be active, and when triggers 1 and 6 act, to the nanosecond."""

import pytest

from axistwin.units import US

from .programs import cruise
from .talking import ask, default, i32, messages, send


def later(bench, ns):
    bench.clock.run_to(bench.now + ns)


@pytest.mark.parametrize(("active_ns", "stopped"), [(75 * US - 1, False), (75 * US + 1, True)])
@pytest.mark.parametrize(("minus", "limit"), [(0, "cw_limit"), (1, "ccw_limit")])
def test_a_limit_must_remain_active_for_75_microseconds(bench, board, minus, limit, active_ns, stopped):
    """CW LIMIT: "the signal must remain active for a minimum duration of 75 microseconds"; it acts within 200 µs."""
    cruise(bench, board, minus=minus)
    board.pins[limit].drive(True)
    later(bench, active_ns)
    board.pins[limit].drive(False)
    later(bench, 200 * US)
    assert (board.axes["motor"].velocity == 0) is stopped


@pytest.mark.parametrize(("trigger", "response"), [(1, 200 * US), (6, 400 * US)])
def test_a_trigger_responds_within_200_or_400_microseconds(bench, board, trigger, response):
    """TRIGGER #1 and #6: "response will be within 200 microseconds for #1 and 400 microseconds" for #6."""
    cruise(bench, board)
    send(bench, board, 0x7C, trigger, 1, 0)
    pin = board.pins[f"trigger{trigger}"]
    pin.drive(False)
    bench.run(0.002)
    pin.drive(True)
    later(bench, response - 1)
    assert board.axes["motor"].velocity
    later(bench, 2)
    assert board.axes["motor"].velocity == 0


def test_a_trigger_must_have_been_low_for_two_milliseconds(bench, board):
    """Trigger inputs: "a dwell period of at least two milliseconds" before the next transition, to the nanosecond."""
    cruise(bench, board)
    send(bench, board, 0x7C, 1, 1, 0)
    pin = board.pins["trigger1"]
    for low_ns, stopped in ((2000 * US - 1, False), (2000 * US, True)):
        pin.drive(False)
        later(bench, low_ns)
        pin.drive(True)
        bench.run(0.001)
        assert (board.axes["motor"].velocity == 0) is stopped


@pytest.mark.parametrize("by", [0x78, "limit"])
def test_nothing_of_a_killed_move_is_still_to_come(bench, board, by):
    """78h: "immediately stopped": A3h sends no message, and there is one end of motion."""
    for event in (0xA3, 0xA5):
        send(bench, board, event, 1)
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x33, *i32(3_000), seconds=0.05)
    if by == 0x78:
        send(bench, board, 0x78)
    else:
        board.pins["cw_limit"].drive(True)
    assert messages(bench, board) == ["a5 00"]
    bench.run(1)
    assert ask(bench, board, 0x88)[1] & 0xF0 == 0
    assert messages(bench, board) == []
