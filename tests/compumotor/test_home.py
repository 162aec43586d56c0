"""Chapter Home (38h, 39h, 3Ah): the HOME that a search finds is compared with the physical position of the switch."""

import pytest

from axistwin.plant.switches import PositionSwitch, in_series

from ..scripts import scripts
from .scripts import play
from .talking import ask, default, messages, position, ready, send, send_all

CW, CCW = +1, -1
WIDTH = 400  # half of the active region, in pulses
TRAVEL = 6_000  # from the centre to each limit
FINAL = 500  # pulses/s: 5 % of the default velocity, a multiple of its resolution


def machine(bench, place, active_high=True, **options):
    """Return a board whose motor is `place` pulses from the centre of the home region, and the centre's position."""
    centre = -place
    board = ready(bench, motor={"limits": (centre - TRAVEL, centre + TRAVEL)}, **options)
    switch = PositionSwitch(board.axes["motor"], centre - WIDTH, centre + WIDTH)
    in_series([switch], board.pins["home"], closed=active_high)
    default(bench, board, 10_000, 200_000)
    return board, centre


def define(bench, board, edge, final, active_high=True, percent=5):
    send(bench, board, 0x38, int(active_high), int(edge == CCW), percent, int(final == CCW))


def done(bench, board):
    assert bench.run_until(lambda: board.pins["output1"].level is False, 100)


def search(bench, board, minus, opcode=0x39):
    send(bench, board, 0x0F, 3, 2, 1)  # output 1 is set while a SINGULAR command is performed
    send(bench, board, opcode, minus)
    done(bench, board)
    bench.run(0.01)


def where(centre, edge, final, late):
    """Return the position `late` pulses after the first pulse beyond the edge, in the final direction."""
    inside = final == -edge
    last = centre + edge * WIDTH
    return last - edge * late if inside else last + edge * (1 + late)


@pytest.mark.parametrize("place", [-3_000, -WIDTH, 0, WIDTH + 1, 3_000, TRAVEL + 1])
@pytest.mark.parametrize("start", [CW, CCW])
@pytest.mark.parametrize("final", [CW, CCW])
@pytest.mark.parametrize("edge", [CW, CCW])
@pytest.mark.parametrize(("home_ms", "late"), [(0, 0), (3, 1)])
def test_every_edge_final_direction_start_and_place(bench, edge, final, start, place, home_ms, late):
    """A level that must last 3 ms (option home_ms) is detected one pulse later, at 500 pulses/s."""
    board, centre = machine(bench, place, home_ms=home_ms)
    define(bench, board, edge, final)
    search(bench, board, int(start == CCW))
    axis = board.axes["motor"]
    assert axis.position == where(centre, edge, final, late) and axis.train.move.direction == final
    assert axis.train.move.profile.segments[0].rate == FINAL
    assert position(bench, board, 0x82) == 0 and position(bench, board, 0x83) == axis.position


@pytest.mark.parametrize("active_high", [True, False])
@pytest.mark.parametrize("sense", [0, 1])
@pytest.mark.parametrize("edge", [CW, CCW])
def test_edges_are_physical_and_the_start_is_in_plus_and_minus(bench, edge, sense, active_high):
    board, centre = machine(bench, -2_000, active_high)
    send(bench, board, 0x14, sense)
    define(bench, board, edge, CW, active_high)
    assert ask(bench, board, 0x8A)[1] == 0x00
    search(bench, board, minus=0)
    axis = board.axes["motor"]
    first = axis.train.moves[1]
    assert first.direction == (CCW if sense else CW) and axis.position == where(centre, edge, CW, 1)
    assert position(bench, board, 0x83) == (-axis.position if sense else axis.position)
    assert position(bench, board, 0x82) == 0 and ask(bench, board, 0x8A)[1] == (0xFF if edge == CCW else 0x00)


def test_the_legs_of_a_search(bench):
    """From 3,000 to the CW edge, approached CW, with a start CCW: search and overshoot, recovery, approach.

    The edge is detected at pulse WIDTH; from 10,000 to 0 pps at 200,000 pps² are 25 updates of 2 ms, 24 of them
    with pulses: 2 ms x 400 x (1 + ... + 24) = 240 pulses of overshoot.
    """
    board, centre = machine(bench, 3_000, home_ms=0)
    define(bench, board, CW, CW)
    search(bench, board, minus=1)
    legs = [(move.direction, move.profile.pulses) for move in list(board.axes["motor"].train.moves)[1:]]
    assert legs == [(CCW, 2_600 + 240), (CW, 240), (CW, 1)]
    assert board.axes["motor"].position == centre + WIDTH + 1


def test_an_edge_found_while_still_accelerating(bench):
    board, centre = machine(bench, WIDTH + 20, home_ms=0)
    define(bench, board, CW, CCW)
    search(bench, board, minus=1)
    assert board.axes["motor"].position == centre + WIDTH
    assert max(s.rate for move in board.axes["motor"].train.moves for s in move.profile.segments) < 10_000


def test_a_limit_reverses_the_search_and_the_second_one_ends_it(bench):
    board = ready(bench, motor={"limits": (-3_000, 2_000)})
    board.pins["home"].drive(False)
    default(bench, board, 10_000, 200_000)
    define(bench, board, CW, CW)
    send_all(bench, board, (0xA1, 1), (0xA5, 1), (0xA9, 1), (0xAB, 1))
    search(bench, board, minus=0)
    axis = board.axes["motor"]
    assert [move.direction for move in list(axis.train.moves)[1:]] == [CW, CCW]
    assert axis.position == -3_001  # 75 us at 10,000 pps contain no further pulse
    assert messages(bench, board) == ["a1 00", "a5 00", "a9 00", "a5 00", "ab 00"]
    assert position(bench, board, 0x82) == -3_001


@scripts({
    "a search without room in either direction":
    "cw_limit high; ccw_limit high; default 10000 200000; 38 01 00 05 00; 0F 03 02 01; 39 00; "
    "until output1 is low; 0.01 s; at 0; moves 1",
    "without default velocity or definition nothing happens": "38 01 00 05 00; 39 00; 1 s; moves 1",
    "an 1810 has no encoder home": "1810; default 10000 200000; 38 01 00 05 00; 18 01; 3A 00; 1 s; at 0",
    "a percentage out of range leaves home undefined":
    "1811 motor={'limits':(-9000,3000),'home':(-3400,-2600)}; default 10000 200000; 38 01 00 {00|65} 00; 39 01; "
    "2 s; at 0",
    "not while moving":
    "1811 motor={'limits':(-9000,3000),'home':(-3400,-2600)}; default 10000 200000; 38 01 00 05 00; 32 00; 0.1 s; "
    "39 01; 0.1 s; velocity 10000",
    "in a streaming mode and in a sequence":
    "1811 motor={'limits':(-9000,3000),'home':(-3400,-2600)}; default 10000 200000; 51 01 01 00 00 00 00; "
    "38 01 00 05 01; 0F 03 02 01; 39 01; until output1 is low; 0.01 s; at -2601; 50; D9 01; 38 01 01 05 00; "
    "39 01; 33 =100; D8; 0F 03 03 01; 41 01; until output1 is low; at -3299; 82: 100",
})  # fmt: skip
def test_home(bench, script):
    play(bench, script)


@pytest.mark.parametrize(("opcode", "velocity"), [(0x70, 0), (0x78, 0), (0x73, -10_000)])
def test_stop_kill_and_discontinue_end_a_search(bench, opcode, velocity):
    board, _ = machine(bench, 3_000)
    define(bench, board, CW, CW)
    send_all(bench, board, (0x0F, 3, 2, 1), (0x39, 1), seconds=0.15)
    send(bench, board, opcode, seconds=0.1)
    assert board.axes["motor"].velocity == velocity and not board.pins["output1"].level
    send(bench, board, 0x78)
    assert position(bench, board, 0x82) == position(bench, board, 0x83) and len(board.axes["motor"].train.moves) == 2


@pytest.mark.parametrize("delay_s", [0.31, 0.35, 0.42])
def test_a_kill_in_a_later_leg_ends_the_search_too(bench, delay_s):
    board, _ = machine(bench, 3_000)
    define(bench, board, CW, CW)
    send_all(bench, board, (0x0F, 3, 2, 1), (0x39, 1), seconds=delay_s)
    send(bench, board, 0x78, seconds=0.1)
    assert board.axes["motor"].velocity == 0 and not board.pins["output1"].level
    assert position(bench, board, 0x82) == position(bench, board, 0x83)


# Encoder home

REVOLUTION, MARK = 1_000, 4


def encoder_machine(bench, z_high=True, enable_high=True, **options):
    """Marks of 4 pulses are 1,000 apart, from 500 on; HOME ENABLE is active only around the mark at 2,500."""
    board = ready(bench, motor={"limits": (-3_000, 5_000), "encoder": {}}, **options)
    axis = board.axes["motor"]
    marks = [PositionSwitch(axis, at, at + MARK - 1) for at in range(-2_500, 5_000, REVOLUTION)]

    def update():
        board.pins["channel_z"].set(any(mark.on for mark in marks) is z_high)

    for mark in marks:
        mark.on_change = update
    update()
    in_series([PositionSwitch(axis, 2_300, 2_700)], board.pins["home_enable"], closed=enable_high)
    default(bench, board, 10_000, 200_000)
    send(bench, board, 0x18, 1)
    return board


@pytest.mark.parametrize("minus", [0, 1])
@pytest.mark.parametrize("enable_high", [True, False])
@pytest.mark.parametrize(("z_high", "invert", "final", "found"), [
    (True, False, CW, 2_500), (True, False, CCW, 2_503), (False, True, CW, 2_500), (False, True, CCW, 2_503),
    (True, True, CW, 2_504), (True, True, CCW, 2_499)])  # fmt: skip
def test_the_mark_of_channel_z_while_home_enable_is_active(bench, z_high, invert, final, found, enable_high, minus):
    board = encoder_machine(bench, z_high, enable_high, invert_z=invert)
    define(bench, board, CW, final, enable_high)
    search(bench, board, minus, opcode=0x3A)
    assert board.axes["motor"].position == found and board.axes["motor"].train.move.direction == final
    assert position(bench, board, 0x82) == 0 and ask(bench, board, 0x96)[1] == 0xFF


def test_not_unless_position_is_maintained(bench):
    board = encoder_machine(bench)
    define(bench, board, CW, CW)
    send_all(bench, board, (0x18, 0), (0x3A, 0), seconds=1)
    assert board.axes["motor"].position == 0
