"""Decisions of docs/fidelity.md on what happens beside a motion: loops, searches, corrections, cancelled moves."""

from collections import Counter

import pytest

from axistwin.core.units import US

from ..scripts import scripts
from .programs import cruise, number, sequence, start, tracked
from .scripts import play
from .talking import ask, default, i32, messages, position, send, send_all
from .test_home import CCW, CW, define, machine, search

USER_BIT = 0x01
HUNTING = 50_000  # pulses/s: the maximum of B3h


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
    assert not bench.run_until(lambda: board.bus.read(1) & USER_BIT, 0.02) and messages(bench, board) == ["01 07"] * 3


@pytest.mark.parametrize(("place", "begin", "edge", "final", "sent"), [
    (-3_000, CW, CW, CCW, {"a1": 1, "a3": 1, "a5": 3}), (-3_000, CW, CW, CW, {"a1": 1, "a3": 1, "a5": 4}),
    (-3_000, CCW, CW, CW, {"a1": 1, "a3": 2, "a5": 5}), (401, CCW, CW, CW, {"a1": 1, "a5": 3})
], ids=["the edge", "through the region", "by way of a limit", "found on the ramp"])  # fmt: skip
def test_what_a_search_for_home_sends(bench, place, begin, edge, final, sent):
    """39h is one move (A1h); A3h, A5h: "every time any move reaches" constant velocity, "every end of motion"."""
    board, _ = machine(bench, place)
    define(bench, board, edge, final)
    send_all(bench, board, (0xA1, 1), (0xA3, 1), (0xA5, 1))
    search(bench, board, int(begin == CCW))
    assert Counter(message[:2] for message in messages(bench, board)) == sent


@pytest.mark.parametrize("command", [
    (0x33, *i32(100)), (0x34, *i32(100)), (0x2E, *i32(9)), (0x2F, *i32(9)), (0x30,), (0x11,), (0x12, 1), (0x14, 1),
    (0x39, 0), (0x3A, 0), (0x51, 1, 4, *i32(99)), (0x52, 1, 4, *i32(99), 0, 10), (0x53, 1, 4, *i32(99), 0, 10)
], ids=lambda command: f"{command[0]:02X}h")  # fmt: skip
def test_a_hunting_motor_is_a_moving_one(bench, command):
    """2Eh, 30h, 12h, 14h, 39h, 51h: ignored "if the motor is moving"; 8Ch tells a correction as motion."""
    board = hunting(bench)
    error, pulses = number(bench, board, 0x99), position(bench, board)
    send(bench, board, *command, seconds=0.01)
    assert board.axes["motor"].velocity == HUNTING and 0 < number(bench, board, 0x99) < error
    assert position(bench, board) > pulses
    assert (ask(bench, board, 0x90)[1], board.pins["direction"].level) == (0x50, True)
    assert bench.run_until(lambda: board.axes["motor"].velocity == 0, 5) and number(bench, board, 0x99) == 0


@scripts({
    '18h: "this excludes ... continuous moves"; the correction gives way to them and to closed-loop moves (1)':
    "tracked; 38 01 00 32 00; 18 01; 35 =0; displace -4000; 0.1 s; velocity 50000; {32|35|36} {00|=500|=500}; "
    "0.02 s; velocity 5000",
    '18h: "this excludes ... continuous moves"; the correction gives way to them and to closed-loop moves (2)':
    "tracked; 38 01 00 32 00; 18 01; 35 =0; displace -4000; 0.1 s; velocity 50000; 37; 0.02 s; velocity 5000",
    '18h acts when "the indexer is not performing a move"; 42h names an empty buffer only':
    "tracked; 18 01; 52 01 04 =never #10; velocities 1024 1024 1024 1024 1024 1024 0; displace -4000; 0.1 s; "
    "velocity 50000; 42; 0.02 s; velocity about 17066.67; 0.05 s; at rest; 99: 0",
    '9Bh: B = "current absolute encoder count", of 32 bits in 9Ah; 83h has six bytes, so they part at the wrap':
    "1811 motor={'encoder':{'counts_per_rev':25000,'pulses_per_rev':25000}}; B0 00 01 00 01; B1 00 00 61 A8; "
    "B4 00 00 00 32; default 5000 100000; 2E =2147483638; 2F =2147483638; 9B: 0; 33 =20; 1 s; 83: 2147483658; "
    "9A: -2147483638; 9B: 65535; 30; 9B: 0",
    'Addendum: "The software used in the 1810 is identical"; its count stays at 0, so 500 pulses are a tooth':
    "tracked 1810; A7 01; 33 =5000; 2 s; says A7 00; 83: 5000; 19 01; 33 =5000; 2 s; says A7 00; "
    "83: 5500 to 5510 -- found at an update, every 2 ms",
    '18h: "an open-loop incremental or absolute move cannot be performed"; an error needs an encoder':
    "tracked 1810; 18 01; 33 =5000; 2 s; 83: 0; 99: 0; 32 00; 0.1 s; velocity 5000",
    '51h: "nearly empty"; it comes as the last velocity begins, and the motor goes on':
    "52 01 04 =0 #100; velocities 1024 1024 1024 1024 1024 1024 1024; 42; 0.55 s; SB & 8 is 0; 0.06 s; "
    "says 52 01 04 00 00 00 00 00 64; velocity about 17066.67",
})  # fmt: skip
def test_decisions_on_motion(bench, script):
    play(bench, script)


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
    assert 0 < bench.now - edge < 915 and board.pins["step"].level
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
