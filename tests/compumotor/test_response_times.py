"""Specifications, Inputs: how long a limit must be active, and when triggers 1 and 6 act, to the nanosecond."""

import pytest

from axistwin.core.units import US

from ..scripts import scripts
from .programs import cruise
from .scripts import play
from .talking import send


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


@scripts({
    'TRIGGER #1 and #6: "response will be within 200 microseconds for #1 and 400 microseconds" for #6':
    "cruise 10000 100000; 7C {01|06} 01 00; {trigger1|trigger6} low; 0.002 s; {trigger1|trigger6} high; "
    "{0.000199999|0.000399999} s; moving; 0.000000002 s; at rest",
    '78h: "immediately stopped": A3h sends no message, and there is one end of motion (1)':
    "A3 01; A5 01; default 10000 100000; 33 =3000; 0.05 s; 78; says A5 00; 1 s; 88 & F0 is 00; says nothing",
    '78h: "immediately stopped": A3h sends no message, and there is one end of motion (2)':
    "A3 01; A5 01; default 10000 100000; 33 =3000; 0.05 s; cw_limit high; says A5 00; 1 s; 88 & F0 is 00; "
    "says nothing",
})  # fmt: skip
def test_response_times(bench, script):
    play(bench, script)


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
