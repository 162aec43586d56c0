"""Manual, Appendix A: 2Eh to 34h, 40h, 91h, C8h to D7h (definitions and moves)."""

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .programs import continuous, cruise, relative, steps
from .scripts import play
from .talking import ask, complete, default, i32, messages, position, send, send_all

AT_ONCE = 0x7FFF_FFFF


def absolute(number, velocity, acceleration, place):
    return (0xCB, number, 0, *i32(velocity), *i32(acceleration), *i32(place))


def go(bench, board, *command):
    """Perform a command and return the position from absolute zero."""
    complete(bench, board, *command)
    return position(bench, board)


def test_the_default_move_is_move_zero(bench, board):
    """31h: reported by 91h with 00 as type CE; "set to zero" after power up; parameter one is don't care."""
    send(bench, board, 0x31, 0xAB, 0x21, *i32(0x0001_0203), *i32(0x0405_0607))
    data = ask(bench, board, 0x91, 0)
    assert data == bytes([0x91, 0xCE, 0, 0x21, 0, 1, 2, 3, 4, 5, 6, 7]).ljust(16, b"\0")


@pytest.mark.parametrize("wrong", [
    (0x31, 0, 0x60, *i32(1), *i32(1)), (0x31, 0, 0x03, *i32(1), *i32(1)), (0x31, 0, 0, *i32(-1), *i32(1)),
    (0x31, 0, 0, *i32(1), *i32(-1)), (0x31, 0, 0, *i32(1), 0, 0, 0)])  # fmt: skip
def test_a_default_out_of_range_is_ignored(bench, board, wrong):
    """31h: "negative velocity and a negative acceleration are invalid parameters"; such a default is ignored."""
    default(bench, board, 500, 600)
    send(bench, board, *wrong)
    assert ask(bench, board, 0x91, 0)[3:12] == bytes([0, *i32(500), *i32(600)])


@scripts({
    '32h: "If the default move has not been defined no move will be performed"; the same holds for 40h':
    "{32|33|34|40|40|40} {00|=50|=50|01|33|00}; 0.5 s; pulses 0; 8C -> 00",
    '33h: "A distance of 80000000h is invalid"; 34h: valid are only C0000001h through 3FFFFFFFh':
    "default 10000 at_once; {33|34|34} {80|40|C0} 00 00 00; 0.5 s; pulses 0",
    'C8h: ""performing a move" is synonymous with the "motor moving""; 40h: "this command is ignored" then':
    "relative 1 10000 100000 2000; default 10000 100000; 40 01; 0.05 s; 40 01; 33 =9; 34 =9; 32 00; idle; "
    "at 2000; 1 s; at 2000; cruise 10000 100000; 40 01; 33 =9; 1 s; velocity 10000",
    'CEh: "can only be performed if the motor is not accelerating or decelerating"':
    "continuous 1 10000 50000; continuous 2 20000 100000; 0.1 s; 40 01; 0.1 s; 40 02; 1 s; velocity 10000; 40 02; "
    "1 s; velocity 19980.0 to 20020.0",
    "a continuous move may be slower":
    "cruise 10000 100000; continuous 2 5000 50000; 40 02; 0.05 s; 8F -> FF; 0.2 s; velocity 5000; "
    "81: 0 -- the end position of a continuous move is undefined",
    "C8h: velocity units per second, per ten seconds or per hundred seconds, here always 10,000 pps²":
    "continuous 1 5000 {10000|100000|1000000} 0 {0|1|2}; 0.05 s; 40 01; until moving; clock; until velocity 5000; "
    "496 to 504 ms later; 86 -> {00|01|02} 00 {00|01|0F} {27|86|42} {10|A0|40}",
    "delete a move: D7h deletes a move, which then is not performed":
    "relative 4 10000 100000 25; D7 05; D7 04; 40 04; 0.2 s; pulses 0",
    'Inputs: "stop any motor motion in the clockwise direction": motion in the other direction continues':
    "cruise -10000 100000; cw_limit high; 0.2 s; velocity -10000",
    "2Eh: \"the absolute position is set to the known offset of the sensor\"; two's complement; not while moving":
    "default 100000 at_once; 2E =-5; 83: -5; 2E =at_once; 83: 2147483647; 2E =-2147483648; 83: -2147483648; "
    "2E =1234; 83: 1234; 34 =1000; idle; 83: 1000; at -234; 82: -234 -- the home reference is another matter; "
    "33 =100000; 2E =0; idle; 83: 101000",
    '30h: "the absolute zero position and the position of the HOME limit switch are two independent locations"':
    "default 10000 at_once; 33 =-77; idle; 30; 83: 0; 82: -77; 33 =5000; 0.1 s; 30; idle; "
    "83: 5000 -- ignored while moving",
    '34h: "X pulses away from the absolute zero position", from any position':
    "default 100000 10000000; 34 =100; idle; 83: 100; 34 =-100; idle; 83: -100; 34 =0; idle; 83: 0; 34 =5000; "
    "idle; 83: 5000; 34 =5000; idle; 83: 5000; 34 =-12345; idle; 83: -12345; at -12345",
    '34h: "one must perform a relative move to reposition the motor within the valid absolute positioning range"':
    "default 100000 at_once; 2E =1073741833; 34 =1073741823; 0.2 s; pulses 0; 33 =-10; idle; 83: 1073741823; "
    "34 =1073741808; idle; 83: 1073741808",
    "C8h: the maxima are 546,133.3, 54,613.33, 5,461.333, 546.1333, 9,102.222 and 1,092,266.67 Hz":
    "continuous 1 {546133|546133|546133|546133|546133|1092266} at_once 0 {0|16|32|48|64|80}; 0.05 s; 40 01; "
    "0.1 s; velocity {546078.687|54607.869|5460.787|546.079|9101.312|1092157.443} to {546187.913|54618.791|"
    "5461.879|546.188|9103.132|1092375.897}",
    "CBh: the target is relative to absolute zero; outside the absolute range the move is not performed":
    "absolute 2 100000 at_once -500; 40 02; idle; 83: -500; 40 02; idle; 83: -500; 2E =600; 40 02; idle; "
    "83: -500; at -1600; 2E =-1073741825; 40 02; 0.2 s; at -1600",
})  # fmt: skip
def test_definitions_and_moves(bench, script):
    play(bench, script)


@pytest.mark.parametrize(("parameter", "velocity"), [(0, 10_000), (1, -10_000), (0xFF, -10_000)])
def test_the_default_move_continuous(bench, board, parameter, velocity):
    """32h: "in the + direction if the parameter byte is 00, otherwise, in the - direction"."""
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x32, parameter, seconds=5)
    assert board.axes["motor"].velocity == velocity
    # a ramp of 0.1 s with 500 pulses, and 4.9 s at speed, less the delay of the start
    assert abs(board.axes["motor"].position) == pytest.approx(49_500, abs=200)


@pytest.mark.parametrize("distance", [1, -1, 2, 255, -256, 65_536, -1_000_000])
def test_go_relative(bench, board, distance):
    """33h: signed pulses from the present position; another 33h adds to them."""
    default(bench, board, 500_000, 50_000_000)
    for times in (1, 2, 3):
        assert go(bench, board, 0x33, *i32(distance)) == times * distance
        assert position(bench, board, 0x80) == distance and position(bench, board, 0x81) == 0


@pytest.mark.parametrize("string", [
    (0x33, 0x80, 0, 0, 1), (0x33, *i32(0x7FFF_FFFF)), (0x34, *i32(0x3FFF_FFFF)), (0x34, 0xC0, 0, 0, 1)])  # fmt: skip
def test_the_longest_distances(bench, board, string):
    """33h, 34h: the ends of the ranges are valid."""
    default(bench, board, 10_000, AT_ONCE)
    send(bench, board, *string, seconds=0.5)
    minus = string[1] >= 0x80
    assert board.axes["motor"].velocity == (-10_000 if minus else 10_000)
    send(bench, board, 0x78)
    done = board.axes["motor"].position
    assert position(bench, board, 0x81) == abs(int.from_bytes(bytes(string[1:]), "big", signed=True)) - abs(done)


RANGES = [(0, 1, 16.667), (1, 10, 1.6667), (2, 100, 0.16667), (3, 1000, 0.016667), (4, 60, 0.27778), (5, 1, 33.333)]


@pytest.mark.parametrize(("x", "unit", "resolution"), RANGES)
def test_velocity_ranges(bench, board, x, unit, resolution):
    """C8h has six ranges, in which the number 1 means 1, 0.1, 0.01, 0.001 or 1/60 pulses per second."""
    number = 500 * unit
    send(bench, board, *continuous(1, number, AT_ONCE, ranges=x << 4), seconds=0.05)
    send(bench, board, 0x40, 1, seconds=0.1)
    assert board.axes["motor"].velocity == pytest.approx(500, abs=resolution / 2 + 1e-9)
    assert ask(bench, board, 0x85)[:6] == bytes([0x85, x << 4, *i32(number)])


def test_a_definition_comes_back_as_it_was_sent(bench, board):
    """91h: "the returned bytes match the format of the bytes that were sent"; a number has one move, of any type."""
    for definition in (
        relative(9, 1_000, 2_000, -3_000, ranges=0x11), absolute(9, 4_000, 5_000, 6_000), continuous(9, 7, 8, 0x7F),
    ):  # fmt: skip
        send(bench, board, *definition)
        assert ask(bench, board, 0x91, 9) == bytes([0x91, *definition]).ljust(16, b"\0")


@pytest.mark.parametrize("wrong", [
    relative(0, 1, 1, 1), relative(4, -1, 1, 1), relative(4, 1, -1, 1), relative(4, 1, 1, -0x8000_0000),
    relative(4, 1, 1, 1, ranges=0x60), relative(4, 1, 1, 1, ranges=0x03), relative(4, 1, 1, 1)[:-1],
    absolute(4, 1, 1, 0x4000_0000), absolute(4, 1, 1, -0x4000_0000), absolute(0, 1, 1, 1), continuous(0, 1, 1),
    continuous(4, 1, 1)[:-1], continuous(4, -1, 1), continuous(4, 1, 1, ranges=0x1F)])  # fmt: skip
def test_definitions_out_of_range_are_ignored(bench, board, wrong):
    """C8h: "If one fails to specify a defined range the move definition is invalid"; the old definition stays."""
    old = relative(4, 10_000, 100_000, 25)
    send_all(bench, board, old, wrong)
    assert ask(bench, board, 0x91, 4) == bytes([0x91, *old])
    complete(bench, board, 0x40, 4)
    assert board.axes["motor"].position == 25


@pytest.mark.parametrize(("pin", "sign"), [("cw_limit", 1), ("ccw_limit", -1)])
def test_limits(bench, board, pin, sign):
    """Inputs: "stop any motor motion in the clockwise direction within 200 microseconds", and refuse new moves."""
    cruise(bench, board, 50_000, 1_000_000, minus=sign < 0)
    hit = bench.now
    board.pins[pin].drive(True)
    bench.run(1)
    assert max(steps(board)) <= hit + 0.2 * MS
    stopped = board.axes["motor"].position
    send(bench, board, 0x33, *i32(sign * 10), seconds=0.2)
    assert board.axes["motor"].position == stopped
    complete(bench, board, 0x33, *i32(-sign * 10))
    assert board.axes["motor"].position == stopped - sign * 10
    board.pins[pin].drive(False)
    bench.run(0.01)
    complete(bench, board, 0x33, *i32(sign * 10))
    assert board.axes["motor"].position == stopped and messages(bench, board) == []
