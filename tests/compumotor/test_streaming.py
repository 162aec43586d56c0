"""Chapter Velocity-streaming mode: the three modes, their data, and their pulses."""

from fractions import Fraction

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .programs import accumulated, distances, enter, free, pairs, steps, velocities, words
from .scripts import play
from .talking import ask, complete, messages, position, ready, send, send_all, until_idle

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
    assert messages(bench, board) == ["52 01 04 00 00 00 00 00 02"] and free(bench, board) == 600


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


@pytest.mark.parametrize("parameters", [
    (0x51, 0, 1), (0x51, 10, 1), (0x51, 1, 0), (0x51, 1, 17), (0x53, 4, 1, 0, 2), (0x52, 1, 1, 0, 0),
    (0x52, 1, 1, 0, 1)])  # fmt: skip
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
    assert times == expected[: len(times)] and board.axes["motor"].position == len(times) > 3_000


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
    times, start_ns = steps(board), board.axes["motor"].train.move.start_ns
    expected = [100 * MS, 125 * MS, 175 * MS]
    assert len(times) == 175 == board.axes["motor"].position
    assert all(abs(times[n - 1] - start_ns - at) <= 3 for n, at in zip((100, 150, 175), expected, strict=True))
    assert all(times[k] - times[k - 1] in (999_999, 1_000_000, 1_000_001) for k in range(1, 100))


def test_there_and_back_by_the_direction_bit(bench, board):
    enter(bench, board, 0x51, 3, 1)
    pairs(bench, board, (1_500, 300), (0x8000 | 3_000, 500), (0x8000, 9))
    send(bench, board, 0x42, seconds=0.1)
    assert ask(bench, board, 0x85)[:3] == b"\x85\x05\xdc" and ask(bench, board, 0x84)[1] == 0x00
    bench.run(0.3)
    assert ask(bench, board, 0x85)[:3] == b"\x85\x8b\xb8" and ask(bench, board, 0x84)[1] == 0xFF
    until_idle(bench, board)
    assert board.axes["motor"].position == 300 - 500 == position(bench, board, 0x83)
    assert position(bench, board, 0x80) == -500 and position(bench, board, 0x81) == 0
    assert ask(bench, board, 0x85)[:3] == b"\x85\0\0"


@scripts({
    "a pair without distance is skipped and a velocity of zero stops":
    "51 03 01 =never; pairs 1500 10 6000 0 0 777; 42; idle; at 10",
    "a pair shorter than two milliseconds lasts two: 2,000 pps for 1 pulse would take 0.5 ms; the pair lasts 2 "
    "ms, which are 4 pulses": "51 03 01 =never; pairs 3000 1 0 0 0 0; 42; idle; at 4",
    "with ccw as plus the direction bit is still physical":
    "14 01; 51 03 01 =never; pairs 34268 100 0 0 0 0; 42; 0.05 s; 85 -> 85 DC; idle; at -100; 83: 100",
    "a stream of zeros within the period of a joystick is no motion: the stick's pulses are 0.5 s apart; half a "
    "period later the motor is at rest, and 8Ch reports 00":
    "11; joystick 2 500 ms; at_zero high; 10; 52 03 01 =never #2; velocities 0; 42; 0.05 s; 8C -> 00",
})  # fmt: skip
def test_velocity_distance(bench, script):
    play(bench, script)


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
    assert board.axes["motor"].position == sum(lengths) and len(times) == sum(abs(step) for step in lengths)
    start_ns = times[0] - 7 * MS  # the first pulse ends the first period
    for k in range(len(lengths)):
        within = [t for t in times if start_ns + 7 * MS * k < t <= start_ns + 7 * MS * (k + 1)]
        assert len(within) == abs(lengths[k])
    assert free(bench, board) == 598  # data after the end wait for another 42h


@scripts({
    "Base 3 / 16: the maximum is 1365 1/3 pulses/s × 32,767/32,768, that is 136 pulses in 100 ms":
    "53 03 10 =never #100; distances 10000 32769; 42; idle; at 136",
    "data of another mode are ignored":
    "53 01 01 =never #2; velocities 1; pairs 1 1 1 1 1 1; E2: 600; distances 1; E2: 598",
})  # fmt: skip
def test_distance_time(bench, script):
    play(bench, script)


# Modes


@scripts({
    "entering a streaming mode destroys the sequences and not the moves":
    "C8 01 00 =100 =1000 =5; D9 01; 40 01; D8; 51 01 01 =never; 40 01; 50; E2: 600; 41 01; 1 s; at 0; 40 01; "
    "idle; at 5",
    "the moves that streaming modes know":
    "default 1000 100000; 52 03 01 =never #2; 32 00; 33 =120; 0.06 s; velocities 0; 42; 85 -> 05 DC; idle; "
    "34 =100; idle; at 100; E2: 586",
    "no other mode while moving or performing":
    "52 03 01 =never #50; velocities 0 0 0 0 0 0 1500; 42; 51 01 01 =never; 50; 90 -> 52 03 01 =never #50; 1 s; "
    "51 01 01 =never; 90 -> 52 03 01 =never #50; 50; 90 -> 50; velocity 1000; 70; 0.1 s; at rest",
    "entering a mode anew empties the buffer":
    "52 03 01 =never #2; velocities 5; 52 02 01 =never #9; E2: 600; 90 -> 52 02 01 00 00 FF FF 00 09",
    "no more pulses after a reset":
    "52 03 01 =never #2; velocities 5000; 42; 0.05 s; CB 20; mark; 2 s; moved 0; 90 -> 50",
})  # fmt: skip
def test_modes(bench, script):
    play(bench, script)


def test_a_motor_that_streams_does_not_stall_where_its_strokes_meet(bench):
    """500 velocities are several pulse trains; each begins at the velocity of the one before, not at rest."""
    motor = {"torque": [(0.0, 1.0), (40_000.0, 1.0)], "pull_in": 600.0}
    board = ready(bench, motor={"motor": motor})
    ramp = [150 * k for k in range(1, 100)]
    enter(bench, board, 0x52, 3, 1, rate=2)
    velocities(bench, board, *ramp, *ramp[::-1], *[0] * 5)
    complete(bench, board, 0x42)
    axis = board.axes["motor"]
    assert axis.train.moves[-1].direction == 1 and len(axis.train.moves) > 3
    assert axis.position == axis.pulses > 1_000
