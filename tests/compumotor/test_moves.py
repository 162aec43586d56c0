"""Chapters Indexer mode, Pre-defined moves, Move zero; the velocity and acceleration ranges of command C8h."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.core.units import MS, US

from ..scripts import scripts
from .programs import steps
from .scripts import play
from .talking import ask, complete, default, i32, message, messages, position, ready, send, send_all

NO_TIME = 0x7FFF_FFFF  # an acceleration that reaches any velocity in one update


def define(bench, board, opcode, number, velocity, acceleration, target, ranges=0):
    send(bench, board, opcode, number, ranges, *i32(velocity), *i32(acceleration), *target)


def test_a_preset_move_is_a_trapezoid_that_ends_on_the_pulse(bench, board):
    """100,000 pps at 1,000,000 pps²: each update, every 2 ms, adds 2,000 pps: 49 levels up to 98,000 pps.

    Each ramp is 2 ms x 2,000 x (1 + ... + 49) = 4,900 pulses in 98 ms; 15,200 pulses in 152 ms remain: 348 ms in all.
    """
    default(bench, board, 100_000, 1_000_000)
    complete(bench, board, 0x33, *i32(25_000))
    times, motor = steps(board), board.axes["motor"]
    assert motor.position == len(times) == 25_000
    began = motor.train.move.start_ns
    assert times[-1] - began == 348 * MS and sum(t - began <= 98 * MS for t in times) == 4_900
    assert sum(t - began <= 250 * MS for t in times) == 20_100


def test_a_short_move_is_a_triangle(bench, board):
    """1,000 pulses: 15 levels up and down are 960 pulses (2 x 4 x 120); 40 remain at 32,000 pps: 61.25 ms in all."""
    default(bench, board, 100_000, 1_000_000)
    send(bench, board, 0xA3, 1)
    complete(bench, board, 0x33, *i32(-1_000))
    times = steps(board)
    assert board.axes["motor"].position == -1_000 and times[-1] - board.axes["motor"].train.move.start_ns == 61_250 * US
    assert messages(bench, board) == []  # "no interrupt will be received"


RESOLUTIONS = [
    (0, Fraction(50, 3), 1), (1, Fraction(5, 3), 10), (2, Fraction(1, 6), 100), (3, Fraction(1, 60), 1000),
    (4, Fraction(5, 18), 60), (5, Fraction(100, 3), 1),
]  # fmt: skip


@pytest.mark.parametrize(("x", "resolution", "units"), RESOLUTIONS)
def test_a_velocity_is_rounded_to_the_resolution_of_its_range_and_reported_as_asked(bench, board, x, resolution, units):
    number = 12_345 * units if x in (0, 5) else 123 * units + 1
    asked = Fraction(number, units)
    send_all(bench, board, (0x31, 0, x << 4, *i32(number), *i32(NO_TIME)), (0x32, 0), seconds=1)
    move = board.axes["motor"].train.move
    rate = move.profile.rate_at(bench.now - move.start_ns)
    assert rate % resolution == 0 and abs(rate - asked) <= resolution / 2
    assert ask(bench, board, 0x85)[:6] == bytes([0x85, x << 4, *i32(number)])


@pytest.mark.parametrize(("x", "maximum"), list(enumerate([546_133] * 5 + [1_092_267])))
def test_a_velocity_beyond_the_range_is_no_definition(bench, board, x, maximum):
    """C8h: the maxima of its ranges are 546,133.3; 54,613.33; 5,461.333; 546.1333; 9,102.222; 1,092,266.67.

    Specifications: "to 1,092,267 steps/sec", which is 1,092,266.67 in range 5.
    """
    for velocity, reply in ((maximum, 0x91), (maximum + 1, None)):
        define(bench, board, 0xC8, 1, velocity, 1, i32(1), ranges=x << 4)
        data = ask(bench, board, 0x91, 1)
        assert (data[0] if data else None) == reply
        send(bench, board, 0xD7, 1)


@pytest.mark.parametrize(("y", "divisor"), [(0, 1), (1, 10), (2, 100)])
def test_acceleration_ranges(bench, board, y, divisor):
    """50,000 pps at 500,000 pps² is reached after 0.1 s, that is after 49 updates of 2 ms and the last one."""
    send_all(bench, board, (0x31, 0, y, *i32(50_000), *i32(500_000 * divisor)), (0xA3, 1), (0xA1, 1), (0x32, 0))
    assert message(bench, board, 1)[0] == 0xA1
    began = board.axes["motor"].train.move.start_ns
    assert bench.run_until(lambda: board.bus.read(1) & 0x08, 1) and bench.now - began == 98 * MS


def test_a_slow_ramp_stays_on_each_level_of_the_resolution(bench, board):
    """1,000 pps² in range 0 is 2 pps per update, but the resolution is 16.667 pps: the error is at most half of it."""
    default(bench, board, 1_000, 1_000)
    send(bench, board, 0x32, 0, seconds=2)
    move = board.axes["motor"].train.move
    rates = [segment.rate for segment in move.profile.segments]
    assert rates == sorted(rates) and all(rate % Fraction(50, 3) == 0 for rate in rates)
    for ns in range(0, 1000 * MS, 10 * MS):
        assert abs(move.profile.rate_at(ns) - ns / MS) <= Fraction(50, 6) + 12


def test_the_start_stop_velocity(bench, board):
    """A move that begins at 1,000 pps has its first pulse after 1 ms; a slower move has no ramp."""
    send(bench, board, 0xD6, *i32(1_000))
    default(bench, board, 10_000, 100_000)
    complete(bench, board, 0x33, *i32(5_000))
    motor, times = board.axes["motor"], steps(board)
    assert times[0] - motor.train.move.start_ns == 1 * MS and times[-1] - times[-2] == 1 * MS
    assert motor.position == 5_000
    default(bench, board, 500, 1)
    complete(bench, board, 0x33, *i32(100))
    assert steps(board)[-1] - motor.train.move.start_ns == 200 * MS


@scripts({
    "moves are crunched one after the other":
    "93 -> FF; C8 01 00 =1000 =1000 00 00 00 01; C8 02 00 =1000 =1000 00 00 00 01; "
    "C8 03 00 =1000 =1000 00 00 00 01; C8 04 00 =1000 =1000 00 00 00 01; C8 05 00 =1000 =1000 00 00 00 01; "
    "93 -> 00; 0.1 s; 93 -> FF",
    # "one must perform a relative move"
    "absolute moves and positions":
    "default 500000 at_once; 33 =3000; idle; 30; 34 =-1000; idle; 83: -1000; 82: 2000; 80: -1000; 81: 0; at 2000; "
    "2E =-2147483648; 83: -2147483648; 34 =0; 0.1 s; at 2000",
    "a stop during a reversal is the end of it":
    "CE 01 00 =50000 =100000 00; CE 02 00 =50000 =100000 01; A1 01; 40 01; 1 s; 40 02; 0.2 s; {70|78}; 2 s; "
    "at rest; says A1 00, A1 00",
    "a continuous move is refused during a ramp and during a preset move":
    "CE 01 00 =50000 =50000 00; CE 02 00 =10000 =50000 01; C8 03 00 =10000 =1000000 00 00 27 10; 0.1 s; 40 01; "
    "0.5 s; 40 02; 1 s; velocity 50000; 78; 40 03; 0.5 s; 40 02; idle; 80: 10000",
})  # fmt: skip
def test_moves_of_indexer_mode(bench, script):
    play(bench, script)


def test_fifty_moves_are_kept(bench, board):
    """X2: move numbers up to FFh are valid, but only moves 1 to 50 (32h) are kept."""
    for number in (0x32, 0x33, 0xFF):
        define(bench, board, 0xC8, number, 100, 100, i32(5))
    assert ask(bench, board, 0x91, 0x32) and not ask(bench, board, 0x91, 0x33)
    assert not ask(bench, board, 0x91, 0xFF)


def test_continuous_moves_change_speed_and_direction(bench, board):
    motor = board.axes["motor"]
    define(bench, board, 0xCE, 1, 10_000, 1_000_000, (0,))
    define(bench, board, 0xCE, 2, 40_000, 1_000_000, (0,))
    define(bench, board, 0xCE, 3, 20_000, 1_000_000, (1,))
    bench.run(0.1)
    for number, velocity in ((1, 10_000), (2, 40_000), (1, 10_000), (3, -20_000)):
        send(bench, board, 0x40, number, seconds=0.2)
        assert motor.velocity == velocity
    send(bench, board, 0x33, *i32(5))  # a preset move begins at rest only
    bench.run(0.2)
    assert motor.velocity == -20_000
    send(bench, board, 0x70, seconds=0.1)
    assert motor.velocity == 0 and position(bench, board) == motor.position == motor.pulses


def test_limit_switches_at_positions(bench):
    board = ready(bench, motor={"limits": (-500, 1_000)})
    default(bench, board, 10_000, NO_TIME)
    send(bench, board, 0x33, *i32(5_000), seconds=1)
    assert 1_000 < board.axes["motor"].position <= 1_003  # within 200 us at 10,000 pps
    assert position(bench, board, 0x81) == 5_000 - board.axes["motor"].position


@settings(max_examples=20, deadline=None)
@given(
    distance=st.integers(-20_000, 20_000),
    velocity=st.integers(1, 546_133),
    slope=st.integers(1, 0x7FFF_FFFF),
    start_stop=st.integers(0, 10_000),
)
def test_pulses_issued_are_the_distance_commanded(distance, velocity, slope, start_stop):
    bench = Bench()
    board = ready(bench)
    send_all(bench, board, (0xD6, *i32(start_stop)), (0x31, 0, 0, *i32(max(velocity, 17)), *i32(slope)))
    send(bench, board, 0x33, *i32(distance), seconds=100_000)
    motor = board.axes["motor"]
    assert motor.position == motor.pulses == position(bench, board) == distance and motor.velocity == 0
