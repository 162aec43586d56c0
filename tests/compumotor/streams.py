"""What the tests of the streaming modes have in common."""

from fractions import Fraction

from .talking import ask, tell

NEVER = 0xFFFF  # an alarm value above the size of the buffer
S = 1_000_000_000


def words(*numbers):
    return [byte for number in numbers for byte in (number & 0xFFFF).to_bytes(2, "big")]


def enter(bench, board, mode, base, divisor, *, alarm=NEVER, rate=None):
    tell(bench, board, mode, base, divisor, *alarm.to_bytes(4, "big"), *(() if rate is None else words(rate)))


def velocities(bench, board, *numbers):
    """E1h as often as needed, filled up with the last value."""
    for first in range(0, len(numbers), 7):
        seven = numbers[first : first + 7]
        tell(bench, board, 0xE1, *words(*seven, *[numbers[-1]] * (7 - len(seven))))


def distances(bench, board, *numbers):
    """E3h as often as needed."""
    for first in range(0, len(numbers), 7):
        some = numbers[first : first + 7]
        tell(bench, board, 0xE3, len(some), *words(*some, *[0] * (7 - len(some))))


def pairs(bench, board, *three):
    """E0h."""
    tell(bench, board, 0xE0, *words(*(number for pair in three for number in pair)))


def free(bench, board):
    return int.from_bytes(ask(bench, board, 0xE2)[1:5], "big")


def pulse_times(board):
    return [int(time_ns) for time_ns in board.axes["motor"].pulse_times()]


def accumulated(levels, start_ns, period_ns):
    """When a phase accumulator that begins at zero overflows: `levels` in pulses/s, `period_ns` each."""
    phase, times = Fraction(0), []
    for level in levels:
        after = phase + level * Fraction(period_ns, S)
        times += [int(start_ns + (n - phase) / level * S) for n in range(int(phase) + 1, int(after) + 1)]
        phase, start_ns = after, start_ns + period_ns
    return times
