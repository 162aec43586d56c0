"""Chapter Stop, discontinue, suspend, kill: 70h to 7Fh by command and by trigger, and the messages of A0h to ACh."""

import pytest

from axistwin.units import MS

from .programs import cruise
from .talking import ask, complete, default, i32, messages, send, send_all

NO_TIME = 0x7FFF_FFFF


def test_stop_ramps_down_at_the_most_recent_acceleration(bench, board):
    """From 10,000 pps at 100,000 pps²: 49 levels of 2 ms, from 9,800 to 200 pps, are 490 pulses in 98 ms."""
    cruise(bench, board)
    motor = board.axes["motor"]
    send(bench, board, 0x70)
    before, began = motor.position, bench.now
    assert ask(bench, board, 0x8F)[1] == 0xFF
    bench.run_until(lambda: not motor.velocity, 1)
    assert bench.now - began == 98 * MS
    assert motor.position - before == pytest.approx(490, abs=1)


def test_events_of_a_move(bench, board):
    default(bench, board, 10_000, 100_000)
    for opcode in range(0xA0, 0xA6):
        send(bench, board, opcode, 1)
    complete(bench, board, 0x33, *i32(3_000))
    assert messages(bench, board) == [f"{code} 00" for code in ("a0", "a1", "a2", "a3", "a4", "a5")]
    complete(bench, board, 0x33, *i32(3_000))
    assert messages(bench, board) == ["a1 00", "a3 00", "a5 00"]
    send(bench, board, 0xAF)
    complete(bench, board, 0x33, *i32(3_000))
    assert messages(bench, board) == []


def test_a_move_that_is_ended_before_its_velocity_sends_no_a3(bench, board):
    send(bench, board, 0xA3, 1)
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x32, 0, seconds=0.05)
    send(bench, board, 0x73, seconds=1)
    assert messages(bench, board) == []


@pytest.mark.parametrize(("pin", "next_", "every"), [("cw_limit", 0xA8, 0xA9), ("ccw_limit", 0xAA, 0xAB)])
def test_hits_of_the_limits(bench, board, pin, next_, every):
    board.pins[pin].drive(True)
    bench.run(0.001)
    send_all(bench, board, (next_, 1), (every, 1))
    for _ in range(2):
        board.pins[pin].drive(False)
        bench.run(0.001)
        board.pins[pin].drive(True)
        bench.run(0.001)
    assert messages(bench, board) == [f"{next_:02x} 00", f"{every:02x} 00", f"{every:02x} 00"]
