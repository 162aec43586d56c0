"""Decisions of docs/fidelity.md on what happens beside a motion: loops, searches, corrections, cancelled moves."""

from collections import Counter

import pytest

from axistwin.units import US

from .programs import RESOLUTION, TEETH, cruise, enter, number, sequence, start, tracked, velocities
from .talking import MESSAGE, ask, default, i32, messages, position, ready, send, send_all
from .test_home import CCW, CW, define, machine, search

USER_BIT = 0x01
HUNTING = 50_000  # pulses/s: the maximum of B3h
STREAMED = 0x0400  # of the effective clock 4,369,066.67 / 4 Hz, this is 17,066.67 pulses/s


def hunting(bench, *before):
    """Return an 1811 that corrects an error of 4,000 encoder pulses, which takes half a second."""
    board = tracked(bench)
    send_all(bench, board, (0x38, 1, 0, 50, 0), (0x18, 1), *before)
    board.axes["motor"].encoder.displace(-4_000)
    bench.run(0.1)
    assert board.axes["motor"].velocity == HUNTING
    return board


def test_a_loop_is_printed_singular_and_takes_no_time(bench, board):
    """20h is printed SINGULAR. State 02 of 0Fh never shows it, and 73h finds nothing to end."""
    sequence(bench, board, 1, (0x20, 1, 0, 3), (0x01, 7))
    send_all(bench, board, (0x0F, 0, 0x02, 1), (0x41, 1), (0x73,))
    assert not bench.run_until(lambda: board.bus.read(1) & USER_BIT, 0.02)
    assert messages(bench, board) == ["01 07"] * 3


@pytest.mark.parametrize(
    ("place", "begin", "edge", "final", "sent"),
    [
        (-3_000, CW, CW, CCW, {"a1": 1, "a3": 1, "a5": 3}),
        (-3_000, CW, CW, CW, {"a1": 1, "a3": 1, "a5": 4}),
        (-3_000, CCW, CW, CW, {"a1": 1, "a3": 2, "a5": 5}),
        (401, CCW, CW, CW, {"a1": 1, "a5": 3}),
    ],
    ids=["the edge", "through the region", "by way of a limit", "found on the ramp"],
)
def test_what_a_search_for_home_sends(bench, place, begin, edge, final, sent):
    """39h is one move (A1h); A3h, A5h: "every time any move reaches" constant velocity, "every end of motion"."""
    board, _ = machine(bench, place)
    define(bench, board, edge, final)
    send_all(bench, board, (0xA1, 1), (0xA3, 1), (0xA5, 1))
    search(bench, board, int(begin == CCW))
    assert Counter(message[:2] for message in messages(bench, board)) == sent


@pytest.mark.parametrize(
    "command",
    [
        (0x33, *i32(100)), (0x34, *i32(100)), (0x2E, *i32(9)), (0x2F, *i32(9)), (0x30,), (0x11,), (0x12, 1), (0x14, 1),
        (0x39, 0), (0x3A, 0), (0x51, 1, 4, *i32(99)), (0x52, 1, 4, *i32(99), 0, 10), (0x53, 1, 4, *i32(99), 0, 10),
    ],
    ids=lambda command: f"{command[0]:02X}h",
)  # fmt: skip
def test_a_hunting_motor_is_a_moving_one(bench, command):
    """2Eh, 30h, 12h, 14h, 39h, 51h: ignored "if the motor is moving"; 8Ch tells a correction as motion."""
    board = hunting(bench)
    error, pulses = number(bench, board, 0x99), position(bench, board)
    send(bench, board, *command, seconds=0.01)
    assert board.axes["motor"].velocity == HUNTING
    assert 0 < number(bench, board, 0x99) < error
    assert position(bench, board) > pulses
    assert (ask(bench, board, 0x90)[1], board.pins["direction"].level) == (0x50, True)
    assert bench.run_until(lambda: board.axes["motor"].velocity == 0, 5)
    assert number(bench, board, 0x99) == 0


@pytest.mark.parametrize("command", [(0x32, 0), (0x35, *i32(500)), (0x36, *i32(500)), (0x37,)])
def test_a_hunting_motor_begins_these_moves(bench, command):
    """18h: "this excludes ... continuous moves"; the correction gives way to them and to closed-loop moves."""
    board = hunting(bench, (0x35, *i32(0)))
    send(bench, board, *command, seconds=0.02)
    assert board.axes["motor"].velocity == 5_000


def test_a_stream_begins_in_a_correction_and_maintenance_waits_for_its_end(bench):
    """18h acts when "the indexer is not performing a move"; 42h names an empty buffer only."""
    board = tracked(bench)
    send(bench, board, 0x18, 1)
    enter(bench, board, 0x52, 1, 4, rate=10)
    velocities(bench, board, *[STREAMED] * 6, 0)
    board.axes["motor"].encoder.displace(-4_000)
    bench.run(0.1)
    assert board.axes["motor"].velocity == HUNTING
    send(bench, board, 0x42, seconds=0.02)
    assert board.axes["motor"].velocity == pytest.approx(17_066.67)
    bench.run(0.05)
    assert board.axes["motor"].velocity == 0
    assert number(bench, board, 0x99) == 0


def test_9bh_calculates_with_the_count_that_9ah_reports(bench):
    """9Bh: B = "current absolute encoder count", of 32 bits in 9Ah; 83h has six bytes, so they part at the wrap."""
    board = ready(bench, motor={"encoder": {"counts_per_rev": 25_000, "pulses_per_rev": 25_000}})
    send_all(bench, board, (0xB0, 0, 1, 0, 1), RESOLUTION, TEETH)
    default(bench, board, 5_000, 100_000)
    send_all(bench, board, (0x2E, *i32(2**31 - 10)), (0x2F, *i32(2**31 - 10)))
    assert number(bench, board, 0x9B) == 0
    send(bench, board, 0x33, *i32(20), seconds=1)
    assert (position(bench, board), number(bench, board, 0x9A)) == (2**31 + 10, -(2**31) + 10)
    assert number(bench, board, 0x9B) == 0xFFFF
    send(bench, board, 0x30)
    assert number(bench, board, 0x9B) == 0


def test_an_1810_stalls_in_each_move_when_its_software_is_told_of_an_encoder(bench):
    """Addendum: "The software used in the 1810 is identical"; its count stays at 0, so 500 pulses are a tooth."""
    board = tracked(bench, "1810")
    send_all(bench, board, (0xA7, 1), (0x33, *i32(5_000)), seconds=2)
    assert messages(bench, board) == ["a7 00"]
    assert position(bench, board) == 5_000
    send_all(bench, board, (0x19, 1), (0x33, *i32(5_000)), seconds=2)
    assert messages(bench, board) == ["a7 00"]
    assert 5_500 <= position(bench, board) <= 5_510, "found at an update, every 2 ms"


def test_an_1810_under_18h_refuses_open_loop_preset_moves_and_corrects_nothing(bench):
    """18h: "an open-loop incremental or absolute move cannot be performed"; an error needs an encoder."""
    board = tracked(bench, "1810")
    send_all(bench, board, (0x18, 1), (0x33, *i32(5_000)), seconds=2)
    assert (position(bench, board), number(bench, board, 0x99)) == (0, 0)
    send(bench, board, 0x32, 0, seconds=0.1)
    assert board.axes["motor"].velocity == 5_000


def test_the_buffer_empty_alarm_of_0_is_not_the_end_of_motion(bench, board):
    """51h: "nearly empty"; it comes as the last velocity begins, and the motor goes on."""
    enter(bench, board, 0x52, 1, 4, alarm=0, rate=100)
    velocities(bench, board, *[STREAMED] * 7)
    send(bench, board, 0x42, seconds=0.55)
    assert not board.bus.read(1) & MESSAGE
    bench.run(0.06)
    assert messages(bench, board) == ["52 01 04 00 00 00 00 00 64"]
    assert board.axes["motor"].velocity == pytest.approx(17_066.67)


def at_a_limit(bench, board, after_ns):
    """Let the limit act `after_ns` after the rising edge of a STEP pulse; return the time of that edge."""
    axis = board.axes["motor"]
    edge = int(axis.pulse_times()[-1]) + 100_000 * 10
    bench.clock.run_to(edge + after_ns - 75 * US)
    board.pins["cw_limit"].drive(True)
    bench.clock.run_to(edge + after_ns)
    assert axis.velocity == 0
    return int(axis.pulse_times()[-1])


def test_a_step_pulse_that_has_begun_has_its_whole_width(bench, board):
    """Specifications: "Pulse width is always one half the period of the maximum frequency": 915 ns in range 0."""
    cruise(bench, board)
    edge = at_a_limit(bench, board, 200)
    assert 0 < bench.now - edge < 915
    assert board.pins["step"].level
    bench.clock.run_to(edge + 916)
    assert not board.pins["step"].level
    bench.run(0.1)
    assert int(board.axes["motor"].pulse_times()[-1]) == edge


def test_a_cancelled_index_changes_the_outputs_that_show_it_and_no_other(bench, board):
    """0Fh: the bit follows its state at once; 0Bh: an output stays as it was programmed."""
    send_all(bench, board, (0x0F, 3, 0x01, 1), (0x0B, 2))
    default(bench, board, 10_000, 100_000)
    start(bench, board, 0x33, *i32(50_000))
    bench.run(0.5)
    assert (board.pins["output1"].level, board.pins["output2"].level) == (True, True)
    at_a_limit(bench, board, 200)
    assert (board.pins["output1"].level, board.pins["output2"].level) == (False, True)
