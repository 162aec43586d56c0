"""Chapter Velocity-streaming mode: the three modes, their data, and their pulses."""

from fractions import Fraction

import pytest

from axistwin.units import MS

from .programs import accumulated, distances, enter, free, joystick_pulses, pairs, steps, velocities, words
from .talking import ask, complete, default, i32, messages, position, ready, send, send_all, until_idle

PARABOLA = [(2 * 23_447 * (625 - (k - 25) ** 2) + 625) // 1250 for k in range(1, 50)]
"""From 0 to 5B97h and back in 50 steps, rounded: the 49 values of the manual's worked example."""


def test_the_worked_parabola_pulse_by_pulse(bench, board):
    """1.0923 MHz / 65,536 is 50/3 pulses/s for a velocity number of 1, so V gives V/30 pulses in 2 ms."""
    enter(bench, board, 0x52, 1, 4, alarm=0, rate=2)
    assert free(bench, board) == 600
    velocities(bench, board, *PARABOLA, *[0] * 7)
    assert free(bench, board) == 600 - 8 * 14
    complete(bench, board, 0x42)

    start_ns = board.axes["motor"].train.moves[1].start_ns
    assert steps(board) == accumulated([Fraction(50, 3) * v for v in PARABOLA], start_ns, 2 * MS)
    assert board.axes["motor"].position == sum(PARABOLA) // 30 == 26_041 == position(bench, board, 0x80)
    assert max(PARABOLA) * Fraction(50, 3) == Fraction(1_172_350, 3)  # 390.783 kHz
    assert messages(bench, board) == ["52 01 04 00 00 00 00 00 02"]
    assert free(bench, board) == 600


BASE_CLOCKS = {
    1: Fraction(13_107_200, 3), 2: Fraction(1_310_720, 3), 3: Fraction(131_072, 3),
    4: Fraction(65_536, 15), 5: Fraction(32_768, 75), 6: Fraction(819_200, 3),
    7: Fraction(51_200, 3), 8: Fraction(3_200, 3), 9: Fraction(200, 3),
}  # fmt: skip


@pytest.mark.parametrize("divisor", [1, 3, 16])
@pytest.mark.parametrize(("base", "hertz"), BASE_CLOCKS.items())
def test_every_base_clock_and_divisor(bench, board, base, hertz, divisor):
    enter(bench, board, 0x52, base, divisor, rate=2)
    velocities(bench, board, 0x7FFF)
    send(bench, board, 0x42, seconds=0.1)

    move = board.axes["motor"].train.move
    assert move.profile.rate_at(bench.now - move.start_ns) == hertz / divisor * 0x7FFF / 65_536
    assert ask(bench, board, 0x85)[:4] == b"\x85\x7f\xff\0"
    mode = bytes([0x90, 0x52, base, divisor, 0, 0, 0xFF, 0xFF, 0, 2])
    assert ask(bench, board, 0x90) == mode.ljust(16, b"\0")


@pytest.mark.parametrize(
    "parameters",
    [(0x51, 0, 1), (0x51, 10, 1), (0x51, 1, 0), (0x51, 1, 17), (0x53, 4, 1, 0, 2), (0x52, 1, 1, 0, 0),
     (0x52, 1, 1, 0, 1)],
)  # fmt: skip
def test_a_wrong_clock_divisor_or_update_rate_is_ignored(bench, board, parameters):
    mode, base, divisor, *rate = parameters
    send(bench, board, mode, base, divisor, 0, 0, 0, 0, *rate)
    assert ask(bench, board, 0x90)[:2] == b"\x90\x50"


def test_the_accumulator_goes_on_for_as_long_as_it_is_refilled(bench, board):
    """Three hundred velocities, each a fractional number of pulses, are sent while earlier ones are performed."""
    numbers = [1_000 + 37 * (k % 91) for k in range(301)]
    enter(bench, board, 0x52, 2, 3, rate=7)
    velocities(bench, board, *numbers[:210])
    send(bench, board, 0x42, seconds=0.02)
    for first in range(210, 301, 7):
        bench.run(0.1)
        velocities(bench, board, *numbers[first : first + 7])
    bench.run(3)
    start_ns = board.axes["motor"].train.moves[1].start_ns
    expected = accumulated(
        [BASE_CLOCKS[2] / 3 * v / 65_536 for v in (*numbers, *[numbers[-1]] * 500)], start_ns, 7 * MS
    )
    times = steps(board)
    assert len(board.axes["motor"].train.moves) > 4  # the pulses are several moves, not one long move
    assert times == expected[: len(times)]
    assert board.axes["motor"].position == len(times) > 3_000


def test_the_seven_values_must_all_be_there(bench, board):
    enter(bench, board, 0x52, 3, 1, rate=2)
    send_all(bench, board, (0xE1, *words(0x700, 0x800, 0x900, 0x1000)), (0xE1, *words(*[0x100] * 7), 1))
    assert free(bench, board) == 600


# Velocity-distance


def test_pairs_of_velocity_and_distance(bench, board):
    """Base 3: a velocity number of 1 is 2/3 pulses/s.  1,000 pps for 100 pulses, 2,000 for 50, 500 for 25."""
    enter(bench, board, 0x51, 3, 1)
    pairs(bench, board, (1_500, 100), (3_000, 50), (750, 25))
    pairs(bench, board, (0, 0), (0, 0), (0, 0))
    assert free(bench, board) == 600 - 24
    complete(bench, board, 0x42)

    times = steps(board)
    start_ns = board.axes["motor"].train.move.start_ns
    expected = [100 * MS, 125 * MS, 175 * MS]
    assert len(times) == 175 == board.axes["motor"].position
    assert all(abs(times[n - 1] - start_ns - at) <= 3 for n, at in zip((100, 150, 175), expected, strict=True))
    assert all(times[k] - times[k - 1] in (999_999, 1_000_000, 1_000_001) for k in range(1, 100))


def test_there_and_back_by_the_direction_bit(bench, board):
    enter(bench, board, 0x51, 3, 1)
    pairs(bench, board, (1_500, 300), (0x8000 | 3_000, 500), (0x8000, 9))
    send(bench, board, 0x42, seconds=0.1)
    assert ask(bench, board, 0x85)[:3] == b"\x85\x05\xdc"
    assert ask(bench, board, 0x84)[1] == 0x00
    bench.run(0.3)
    assert ask(bench, board, 0x85)[:3] == b"\x85\x8b\xb8"
    assert ask(bench, board, 0x84)[1] == 0xFF
    until_idle(bench, board)
    assert board.axes["motor"].position == 300 - 500 == position(bench, board, 0x83)
    assert position(bench, board, 0x80) == -500
    assert position(bench, board, 0x81) == 0
    assert ask(bench, board, 0x85)[:3] == b"\x85\0\0"


def test_a_pair_without_distance_is_skipped_and_a_velocity_of_zero_stops(bench, board):
    enter(bench, board, 0x51, 3, 1)
    pairs(bench, board, (1_500, 10), (6_000, 0), (0, 777))
    complete(bench, board, 0x42)
    assert board.axes["motor"].position == 10


def test_a_pair_shorter_than_two_milliseconds_lasts_two(bench, board):
    """2,000 pps for 1 pulse would take 0.5 ms; the pair lasts 2 ms, which are 4 pulses."""
    enter(bench, board, 0x51, 3, 1)
    pairs(bench, board, (3_000, 1), (0, 0), (0, 0))
    complete(bench, board, 0x42)
    assert board.axes["motor"].position == 4


def test_with_ccw_as_plus_the_direction_bit_is_still_physical(bench, board):
    send(bench, board, 0x14, 1)
    enter(bench, board, 0x51, 3, 1)
    pairs(bench, board, (0x8000 | 1_500, 100), (0, 0), (0, 0))
    send(bench, board, 0x42, seconds=0.05)
    assert ask(bench, board, 0x85)[:3] == b"\x85\x85\xdc"
    until_idle(bench, board)
    assert board.axes["motor"].position == -100
    assert position(bench, board) == 100


def test_a_stream_of_zeros_within_the_period_of_a_joystick_is_no_motion(bench, board):
    """The stick's pulses are 0.5 s apart; half a period later the motor is at rest, and 8Ch reports 00."""
    send(bench, board, 0x11)
    joystick_pulses(bench, board, 2, period_s=0.5)
    board.pins["at_zero"].drive(True)
    send(bench, board, 0x10)
    enter(bench, board, 0x52, 3, 1, rate=2)
    velocities(bench, board, 0)
    send(bench, board, 0x42, seconds=0.05)
    assert ask(bench, board, 0x8C)[1] == 0x00


# Distance-time


@pytest.mark.parametrize("sign", [1, -1])
def test_distances_add_up_exactly(bench, board, sign):
    """D pulses in 7 ms are 1000 D / 7 pps, no multiple of the clock; the sum is exact, and 8001h ends it."""
    lengths = [sign * d for d in (1, 5, 13, 29, 13, 5, 1, -3, -40, 0, 6)]
    enter(bench, board, 0x53, 1, 4, rate=7)
    distances(bench, board, *lengths, 0x8001, 1_000)
    assert free(bench, board) == 600 - 2 * 13
    send(bench, board, 0x42, seconds=0.2)

    times = steps(board)
    assert board.axes["motor"].position == sum(lengths)
    assert len(times) == sum(abs(step) for step in lengths)
    start_ns = times[0] - 7 * MS  # the first pulse ends the first period
    for k in range(len(lengths)):
        within = [t for t in times if start_ns + 7 * MS * k < t <= start_ns + 7 * MS * (k + 1)]
        assert len(within) == abs(lengths[k])
    assert free(bench, board) == 598  # data after the end wait for another 42h


def test_as_fast_as_the_clock_allows(bench, board):
    """Base 3 / 16: the maximum is 1365 1/3 pulses/s × 32,767/32,768, that is 136 pulses in 100 ms."""
    enter(bench, board, 0x53, 3, 16, rate=100)
    distances(bench, board, 10_000, 0x8001)
    complete(bench, board, 0x42)
    assert board.axes["motor"].position == 136


def test_data_of_another_mode_are_ignored(bench, board):
    enter(bench, board, 0x53, 1, 1, rate=2)
    velocities(bench, board, 1)
    pairs(bench, board, (1, 1), (1, 1), (1, 1))
    assert free(bench, board) == 600
    distances(bench, board, 1)
    assert free(bench, board) == 598


# Modes


def test_entering_a_streaming_mode_destroys_the_sequences_and_not_the_moves(bench, board):
    send(bench, board, 0xC8, 1, 0, *i32(100), *i32(1_000), *i32(5))
    for values in ((0xD9, 1), (0x40, 1), (0xD8,)):
        send(bench, board, *values)
    enter(bench, board, 0x51, 1, 1)
    send_all(bench, board, (0x40, 1), (0x50,))
    assert free(bench, board) == 600
    send(bench, board, 0x41, 1, seconds=1)
    assert board.axes["motor"].position == 0
    complete(bench, board, 0x40, 1)
    assert board.axes["motor"].position == 5


def test_the_moves_that_streaming_modes_know(bench, board):
    default(bench, board, 1_000, 100_000)
    enter(bench, board, 0x52, 3, 1, rate=2)
    send_all(bench, board, (0x32, 0), (0x33, *i32(120)), seconds=0.06)
    velocities(bench, board, 0)
    send(bench, board, 0x42)  # ignored during a move
    assert ask(bench, board, 0x85)[:3] == b"\x85\x05\xdc"  # 1,000 pps
    until_idle(bench, board)
    complete(bench, board, 0x34, *i32(100))
    assert board.axes["motor"].position == 100
    assert free(bench, board) == 600 - 14


def test_no_other_mode_while_moving_or_performing(bench, board):
    enter(bench, board, 0x52, 3, 1, rate=50)
    velocities(bench, board, *[0] * 6, 1_500)
    send(bench, board, 0x42)
    enter(bench, board, 0x51, 1, 1)  # performing a stream, at rest
    send(bench, board, 0x50)
    assert ask(bench, board, 0x90)[:4] == b"\x90\x52\x03\x01"
    bench.run(1)
    enter(bench, board, 0x51, 1, 1)  # moving, but not performing a stream
    assert ask(bench, board, 0x90)[:4] == b"\x90\x52\x03\x01"
    send(bench, board, 0x50)
    assert ask(bench, board, 0x90)[:2] == b"\x90\x50"
    assert board.axes["motor"].velocity == 1_000
    send(bench, board, 0x70, seconds=0.1)
    assert board.axes["motor"].velocity == 0


def test_entering_a_mode_anew_empties_the_buffer(bench, board):
    enter(bench, board, 0x52, 3, 1, rate=2)
    velocities(bench, board, 5)
    enter(bench, board, 0x52, 2, 1, rate=9)
    assert free(bench, board) == 600
    assert ask(bench, board, 0x90)[:10] == bytes([0x90, 0x52, 2, 1, 0, 0, 0xFF, 0xFF, 0, 9])


def test_no_more_pulses_after_a_reset(bench, board):
    enter(bench, board, 0x52, 3, 1, rate=2)
    velocities(bench, board, 5_000)
    send(bench, board, 0x42, seconds=0.05)
    board.bus.write(1, 0x20)
    before = board.axes["motor"].position
    bench.run(2)
    assert board.axes["motor"].position == before
    assert ask(bench, board, 0x90)[:2] == b"\x90\x50"


def test_a_motor_that_streams_does_not_stall_where_its_strokes_meet(bench):
    """500 velocities are several pulse trains; each begins at the velocity of the one before, not at rest."""
    motor = {"torque": [(0.0, 1.0), (40_000.0, 1.0)], "pull_in": 600.0}
    board = ready(bench, motor={"motor": motor})
    ramp = [150 * k for k in range(1, 100)]
    enter(bench, board, 0x52, 3, 1, rate=2)
    velocities(bench, board, *ramp, *ramp[::-1], *[0] * 5)
    complete(bench, board, 0x42)
    axis = board.axes["motor"]
    assert axis.train.moves[-1].direction == 1
    assert len(axis.train.moves) > 3
    assert axis.position == axis.pulses > 1_000
