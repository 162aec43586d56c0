"""Programs that many tests send to an 1810 or 1811: moves, triggers, sequences, streams, position tracking."""

from fractions import Fraction

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.units import MS, S

from .talking import ask, default, i32, messages, ready, send

NEVER = 0xFFFF  # an alarm value above the size of the buffer

# Moves and sequences


def cruise(
    bench: Bench, board: Controller, velocity: int = 10_000, acceleration: int = 100_000, minus: int = 0
) -> None:
    """A continuous move, at constant velocity when this returns."""
    default(bench, board, velocity, acceleration)
    send(bench, board, 0x32, int(minus), seconds=velocity / acceleration + 0.05)
    assert board.axes["motor"].velocity == (-velocity if minus else velocity)


def rising(bench: Bench, board: Controller, trigger: int) -> None:
    """A valid edge of triggers 1 and 6: 3 ms low, then high for 1 ms."""
    board.pins[f"trigger{trigger}"].drive(False)
    bench.run(0.003)
    board.pins[f"trigger{trigger}"].drive(True)
    bench.run(0.001)


def sequence(bench: Bench, board: Controller, number: int, *commands: tuple[int, ...]) -> None:
    """Define a sequence."""
    send(bench, board, 0xD9, number)
    for command in commands:
        send(bench, board, *command)
    send(bench, board, 0xD8)


def listing(bench: Bench, board: Controller, number: int) -> list[str]:
    """The answers of 92h to a sequence."""
    send(bench, board, 0x92, number)
    return messages(bench, board)


def relative(number: int, velocity: int, acceleration: int, distance: int, ranges: int = 0) -> tuple[int, ...]:
    """Command C8h."""
    return (0xC8, number, ranges, *i32(velocity), *i32(acceleration), *i32(distance))


def continuous(number: int, velocity: int, acceleration: int, minus: int = 0, ranges: int = 0) -> tuple[int, ...]:
    """Command CEh."""
    return (0xCE, number, ranges, *i32(velocity), *i32(acceleration), minus)


def steps(board: Controller, start_ns: int = 0) -> list[int]:
    """The times of all pulses."""
    return [int(t) for t in board.axes["motor"].pulse_times(start_ns)]


def about(seconds: float, got_ns: int, tolerance_ms: float = 4) -> bool:
    """Ramps are updated every two milliseconds: a time is right within two of those."""
    return abs(got_ns - seconds * S) <= tolerance_ms * MS


# Streaming


def words(*numbers: int) -> list[int]:
    """16-bit words, most significant byte first."""
    return [byte for number in numbers for byte in (number & 0xFFFF).to_bytes(2, "big")]


def enter(
    bench: Bench, board: Controller, mode: int, base: int, divisor: int, *, alarm: int = NEVER, rate: int | None = None
) -> None:
    """Enter streaming mode 51h, 52h or 53h."""
    send(bench, board, mode, base, divisor, *alarm.to_bytes(4, "big"), *(() if rate is None else words(rate)))


def velocities(bench: Bench, board: Controller, *numbers: int) -> None:
    """E1h as often as needed, filled up with the last value."""
    for first in range(0, len(numbers), 7):
        seven = numbers[first : first + 7]
        send(bench, board, 0xE1, *words(*seven, *[numbers[-1]] * (7 - len(seven))))


def distances(bench: Bench, board: Controller, *numbers: int) -> None:
    """E3h as often as needed."""
    for first in range(0, len(numbers), 7):
        some = numbers[first : first + 7]
        send(bench, board, 0xE3, len(some), *words(*some, *[0] * (7 - len(some))))


def pairs(bench: Bench, board: Controller, *three: tuple[int, int]) -> None:
    """E0h."""
    send(bench, board, 0xE0, *words(*(number for pair in three for number in pair)))


def free(bench: Bench, board: Controller) -> int:
    """The free bytes: E2h."""
    return int.from_bytes(ask(bench, board, 0xE2)[1:5], "big")


def accumulated(levels: list[Fraction], start_ns: int, period_ns: int) -> list[int]:
    """Overflow times of a phase accumulator that begins at zero: `levels` in pulses/s, `period_ns` each."""
    phase, times = Fraction(0), list[int]()
    for level in levels:
        after = phase + level * Fraction(period_ns, S)
        times += [int(start_ns + (n - phase) / level * S) for n in range(int(phase) + 1, int(after) + 1)]
        phase, start_ns = after, start_ns + period_ns
    return times


# Position tracking

AT_ONCE = 0x7FFF_FFFF  # an acceleration that is over in one update
RATIO = (0xB0, 0x61, 0xA8, 0x0F, 0xA0)
RESOLUTION = (0xB1, 0, 0, 0x61, 0xA8)
SIGMA = (0xB2, *i32(0))
LAW = (0xB3, 1, 20, 0x00, *i32(50_000))
TEETH = (0xB4, 0, 0, 0, 50)
ALL = (RATIO, RESOLUTION, SIGMA, LAW, TEETH)


def tracked(
    bench: Bench, model: str = "1811", backlash: int = 0, options: dict[str, object] | None = None, **plant: object
) -> Controller:
    """An 1811 with an encoder, B0h to B4h, and 5,000 pulses/s without a ramp by default.

    25,000 to 4,000 pulses a revolution, 6.25 to 1; 50 rotor teeth of 500 pulses.
    """
    encoder = {"counts_per_rev": 4000, "pulses_per_rev": 25_000, "backlash": backlash}
    board = ready(bench, model, motor={"encoder": encoder, **plant}, **(options or {}))
    for command in ALL:
        send(bench, board, *command)
    default(bench, board, 5_000, AT_ONCE)
    return board


def number(bench: Bench, board: Controller, opcode: int) -> int:
    """The reply to 98h, 99h, 9Ah, 9Bh: four bytes."""
    data = ask(bench, board, opcode)
    assert data[0] == opcode
    assert not any(data[5:])
    return int.from_bytes(data[1:5], "big", signed=True)


def start(bench: Bench, board: Controller, *command: int) -> None:
    """Send a command and run until its motion has just begun."""
    moves = len(board.axes["motor"].train.moves)
    send(bench, board, *command)
    assert bench.run_until(lambda: len(board.axes["motor"].train.moves) > moves, 0.1)
