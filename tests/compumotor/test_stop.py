"""Chapter Stop, discontinue, suspend, kill: 70h to 7Fh by command and by trigger, and the messages of A0h to ACh."""

import pytest

from axistwin.units import MS, US

from .talking import ask, complete, default, i32, message, messages, position, send, send_all, until_idle

NO_TIME = 0x7FFF_FFFF


def edge(bench, board, trigger):
    """Low for 2 ms and more, then high for 1 ms."""
    pin = board.pins[f"trigger{trigger}"]
    pin.drive(False)
    bench.run(0.003)
    pin.drive(True)
    bench.run(0.001)


def run(bench, board, velocity=10_000, acceleration=100_000):
    """A continuous move of 0.1 s ramp, at constant velocity when this returns."""
    default(bench, board, velocity, acceleration)
    send(bench, board, 0x32, 0, seconds=0.2)
    assert board.axes["motor"].velocity == velocity


def test_stop_ramps_down_at_the_most_recent_acceleration(bench, board):
    """From 10,000 pps at 100,000 pps²: 49 levels of 2 ms, 9,800 to 200 pps: 490 pulses in 98 ms."""
    run(bench, board)
    motor = board.axes["motor"]
    send(bench, board, 0x70)
    before, began = motor.position, bench.now
    assert ask(bench, board, 0x8F)[1] == 0xFF
    bench.run_until(lambda: not motor.velocity, 1)
    assert bench.now - began == 98 * MS
    assert motor.position - before == pytest.approx(490, abs=1)


def test_kill_ends_the_pulses_at_once(bench, board):
    run(bench, board)
    send(bench, board, 0x78)
    assert board.axes["motor"].velocity == 0
    assert ask(bench, board, 0x8C)[1] == 0


def test_a_discontinued_move_keeps_the_velocity_of_that_instant(bench, board):
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x33, *i32(3_000), seconds=0.06)
    send(bench, board, 0x73)
    held = board.axes["motor"].velocity
    assert 4_000 < held < 6_000
    bench.run(2)
    assert board.axes["motor"].velocity == held
    send(bench, board, 0x78)
    beyond = board.axes["motor"].position - 3_000
    assert beyond > 0
    assert position(bench, board, 0x81) == -beyond  # "if an overshoot occurs ... a negative number"


def test_a_stopped_preset_move_falls_short(bench, board):
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x33, *i32(-30_000), seconds=0.5)
    complete(bench, board, 0x70)
    assert position(bench, board, 0x81) == 30_000 + board.axes["motor"].position > 0


@pytest.mark.parametrize(("trigger", "most_us"), [(1, 200), (6, 400)])
def test_motion_is_killed_by_a_trigger_within_its_response_time(bench, board, trigger, most_us):
    run(bench, board)
    send(bench, board, 0x7C, trigger, 1, 1)
    board.pins[f"trigger{trigger}"].drive(False)
    bench.run(0.003)
    board.pins[f"trigger{trigger}"].drive(True)
    edge_ns = bench.now
    assert bench.run_until(lambda: not board.axes["motor"].velocity, 1)
    assert 0 < bench.now - edge_ns <= most_us * US
    assert message(bench, board)[:3] == bytes([0x7C, trigger, 0])


def test_stop_on_trigger_ramps_down(bench, board):
    run(bench, board)
    send(bench, board, 0x74, 6, 1, 0)
    edge(bench, board, 6)
    assert ask(bench, board, 0x8F)[1] == 0xFF
    until_idle(bench, board)
    assert messages(bench, board) == []


def test_a_trigger_has_one_function_at_a_time(bench, board):
    send(bench, board, 0x74, 1, 1, 0)
    send(bench, board, 0x7C, 1, 1, 1)  # refused
    send(bench, board, 0x7C, 1, 0, 0)  # nor does it end the other one
    run(bench, board)
    edge(bench, board, 1)
    assert ask(bench, board, 0x8F)[1] == 0xFF
    until_idle(bench, board)
    send_all(bench, board, (0x74, 1, 0, 0), (0xAC, 1, 1))
    edge(bench, board, 1)
    assert messages(bench, board) == ["ac 01"]


def test_a_trigger_that_was_low_for_less_than_two_milliseconds_does_not_count(bench, board):
    send(bench, board, 0xAC, 6, 1)
    edge(bench, board, 6)
    board.pins["trigger6"].drive(False)
    bench.run(0.001)
    board.pins["trigger6"].drive(True)
    bench.run(0.01)
    assert messages(bench, board) == ["ac 06"]


@pytest.mark.parametrize("trigger", [0, 2, 3, 4, 5, 7])
def test_only_triggers_1_and_6_have_functions(bench, board, trigger):
    send(bench, board, 0xAC, trigger, 1)
    if 1 <= trigger <= 6:
        edge(bench, board, trigger)
    assert messages(bench, board) == []


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


def test_a_move_during_which_a_message_was_asked_for_does_not_count(bench, board):
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x33, *i32(3_000), seconds=0.05)
    send_all(bench, board, (0xA0, 1), (0xA2, 1))
    complete(bench, board, 0xA4, 1)
    assert messages(bench, board) == ["a4 00"]


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
