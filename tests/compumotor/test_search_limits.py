"""Go HOME and the limit switches in each leg of a search (38h, 39h; Limit switch inputs)."""

import pytest

from ..scripts import scripts
from .scripts import play
from .talking import default, messages, ready, send, send_all, status_word, write

SINGULAR = 1  # the value of user bit 0


@pytest.fixture
def board(bench):
    return prepared(bench)


def prepared(bench, end=9000):
    """Return a board with HOME at 2,000, where an active region begins; a ramp to 5,000 pulses/s is 625 pulses."""
    board = ready(bench, motor={"home": (2000, end)})
    default(bench, board, 5000, 20_000)
    send(bench, board, 0x38, 1, 1, 20, 0)  # active high, CCW edge, 1,000 pulses/s, final approach CW
    send(bench, board, 0x0F, 0, 2, 1)
    return board


def over(bench, board):
    """Run until the search has ended; return the position."""
    assert bench.run_until(lambda: not status_word(bench, board) & SINGULAR, 20)
    return board.axes["motor"].position


@scripts({
    "all of it: the level must last 3 ms, so at 1,000 pulses/s the motor stops 3 pulses beyond the edge":
    "1811 motor={'home':(2000,9000)}; default 5000 20000; 38 01 01 14 00; 0F 00 02 01; 39 00; until SB & 1 is 0; "
    "at 2003; 82: 0",
    '39h: "if an end of limit is encountered the motor will reverse"; HOME is 2,003, as without the limit':
    "1811 motor={'home':(2000,9000)}; default 5000 20000; 38 01 01 14 00; 0F 00 02 01; 39 01; 0.1 s; "
    "ccw_limit high; 0.1 s; ccw_limit low; until SB & 1 is 0; at 2003; 82: 0",
    "Pre-defined moves: less than half of 30 ms for a move that is not calculated; here 1 + 10 + 3 ms":
    "1811 motor={'home':(2000,9000)}; default 5000 20000; 38 01 01 14 00; 0F 00 02 01; clock; IDB 39 00; CB 10; "
    "until moving; 14 ms later",
    '39h: "at the velocity and acceleration specified with command 31h": a later 31h is for the next search':
    "1811 motor={'home':(2000,9000)}; default 5000 20000; 38 01 01 14 00; 0F 00 02 01; 39 00; 0.3 s; "
    "default 500 20000; 0.02 s; velocity 5000; until SB & 1 is 0; at 2003; 33 =-3; idle; 82: -3",
    'Limit switch inputs: "will not allow the motor to move toward that limit switch": HOME is unchanged':
    "1811 motor={'home':(2000,9000)}; default 5000 20000; 38 01 01 14 00; 0F 00 02 01; 39 00; until 8F & FF is FF; "
    "ccw_limit high; until SB & 1 is 0; mark; at 2601 to 2659; 82: marked",
    "Limit switch inputs: a limit stops the overshoot, as 78h does, and the recovery begins at that position":
    "1811 motor={'home':(2000,9000)}; default 5000 20000; 38 01 01 14 00; 0F 00 02 01; 39 00; until 8F & FF is FF; "
    "cw_limit high; 0.001 s; at rest; at under 2500; until velocity under 0; until SB & 1 is 0; at under 2003; "
    "82: not 0",
    "a limit in the recovery is the end of the search: the motor stands within the active region, or behind its "
    "other end, where the final approach CW could begin":
    "1811 motor={'home':(2000,{9000|2100})}; default 5000 20000; 38 01 01 14 00; 0F 00 02 01; 39 00; "
    "until 8F & FF is FF; until velocity under 0; 0.05 s; ccw_limit high; until SB & 1 is 0; mark; "
    "at 2004 to 2659; 1 s; moved 0; 82: marked",
})  # fmt: skip
def test_search_limits(bench, script):
    play(bench, script)


def test_an_edge_of_the_home_input_must_last(bench):
    """38h: level sensitive like triggers 2 to 5, with a response within 3 ms: a level of 2.9 ms is no edge."""
    board = ready(bench)
    home, motor = board.pins["home"], board.axes["motor"]
    home.drive(False)
    default(bench, board, 5000, 20_000)
    send_all(bench, board, (0x38, 1, 1, 20, 0), (0x39, 0), seconds=0.5)
    for seconds, found in ((0.0029, False), (0.0031, True)):
        home.drive(True)
        bench.run(seconds)
        home.drive(False)
        bench.run(0.01)
        assert (motor.velocity < 5000) is found


@pytest.mark.parametrize("opcode", [0x70, 0x78])
def test_a_search_that_is_stopped_at_a_limit_does_not_turn_round(bench, board, opcode):
    """39h: a search ends when both limits have been struck; 70h or 78h ends it at once, at a limit too."""
    send(bench, board, 0x39, 1, seconds=0.1)
    write(board, opcode)
    bench.run(0.001)  # the time until the command acts
    board.pins["ccw_limit"].drive(True)
    stands = over(bench, board)
    bench.run(1)
    assert board.axes["motor"].position == stands < 0


def test_a_search_is_one_move(bench, board):
    """A0h to A5h: a search reports one start, one constant velocity, and the end of motion of each leg."""
    for opcode in (0xA1, 0xA3, 0xA5):
        send(bench, board, opcode, 1)
    send(bench, board, 0x39, 0)
    over(bench, board)
    found = messages(bench, board)
    assert found.count("a1 00") == 1 and found[0] == "a1 00"
    assert found.count("a5 00") >= 3 and found[-1] == "a5 00"


@pytest.mark.parametrize("percent", [20, 50, 100])
def test_the_final_approach_is_at_its_percentage_of_the_default_velocity(bench, board, percent):
    """38h: "the percent of default velocity", with no acceleration to it; 1,000, 2,500 and 5,000 pulses/s."""
    send_all(bench, board, (0x38, 1, 1, percent, 0), (0x39, 0))
    over(bench, board)
    times = board.axes["motor"].pulse_times()
    assert int(times[-1] - times[-2]) == pytest.approx(1_000_000_000 / (50 * percent), rel=0.005)
