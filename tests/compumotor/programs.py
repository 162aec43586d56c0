"""Programs that many tests send to an 1810 or 1811: moves, triggers, sequences, streams, position tracking."""

from fractions import Fraction

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.core.units import MS, S

from .talking import ask, default, i32, messages, ready, send

NEVER = 0xFFFF  # an alarm value above the size of the buffer

# Moves and sequences


def cruise(
    bench: Bench, board: Controller, velocity: int = 10_000, acceleration: int = 100_000, minus: int = 0
) -> None:
    """Begin a continuous move and run until its velocity is constant."""
    default(bench, board, velocity, acceleration)
    send(bench, board, 0x32, int(minus), seconds=velocity / acceleration + 0.05)
    assert board.axes["motor"].velocity == (-velocity if minus else velocity)


def rising(bench: Bench, board: Controller, trigger: int) -> None:
    """Drive a valid edge of trigger 1 or 6: the input is low for 3 ms and then high for 1 ms."""
    board.pins[f"trigger{trigger}"].drive(False)
    bench.run(0.003)
    board.pins[f"trigger{trigger}"].drive(True)
    bench.run(0.001)


def sequence(bench: Bench, board: Controller, number: int, *commands: tuple[int, ...]) -> None:
    send(bench, board, 0xD9, number)
    for command in commands:
        send(bench, board, *command)
    send(bench, board, 0xD8)


def listing(bench: Bench, board: Controller, number: int) -> list[str]:
    """Return the messages with which 92h lists a sequence."""
    send(bench, board, 0x92, number)
    return messages(bench, board)


def relative(number: int, velocity: int, acceleration: int, distance: int, ranges: int = 0) -> tuple[int, ...]:
    """Return command C8h, which defines a relative move."""
    return (0xC8, number, ranges, *i32(velocity), *i32(acceleration), *i32(distance))


def continuous(number: int, velocity: int, acceleration: int, minus: int = 0, ranges: int = 0) -> tuple[int, ...]:
    """Return command CEh, which defines a continuous move."""
    return (0xCE, number, ranges, *i32(velocity), *i32(acceleration), minus)


def steps(board: Controller, start_ns: int = 0) -> list[int]:
    """Return the times of all pulses from `start_ns`."""
    return [int(t) for t in board.axes["motor"].pulse_times(start_ns)]


def about(seconds: float, got_ns: int, tolerance_ms: float = 4) -> bool:
    """True if a time is right within two ramp updates, which are 2 ms apart."""
    return abs(got_ns - seconds * S) <= tolerance_ms * MS


def joystick_pulses(bench: Bench, board: Controller, pulses: int, cw: bool = True, period_s: float = 0.001) -> None:
    """Let the joystick leave zero velocity and make pulses; `at_zero` then ends its motion."""
    pins = board.pins
    pins["direction_in"].drive(cw)
    pins["at_zero"].drive(False)
    for level in (False, True) * pulses:
        pins["step_in"].drive(level)
        bench.run(period_s / 2)


# Streaming


def words(*numbers: int) -> list[int]:
    """Return 16-bit words as bytes, most significant byte first."""
    return [byte for number in numbers for byte in (number & 0xFFFF).to_bytes(2, "big")]


def enter(
    bench: Bench, board: Controller, mode: int, base: int, divisor: int, *, alarm: int = NEVER, rate: int | None = None
) -> None:
    """Enter streaming mode 51h, 52h or 53h."""
    send(bench, board, mode, base, divisor, *alarm.to_bytes(4, "big"), *(() if rate is None else words(rate)))


def velocities(bench: Bench, board: Controller, *numbers: int) -> None:
    """Send velocities by E1h commands; the last value fills up the last command."""
    for first in range(0, len(numbers), 7):
        seven = numbers[first : first + 7]
        send(bench, board, 0xE1, *words(*seven, *[numbers[-1]] * (7 - len(seven))))


def distances(bench: Bench, board: Controller, *numbers: int) -> None:
    """Send distances by E3h commands."""
    for first in range(0, len(numbers), 7):
        some = numbers[first : first + 7]
        send(bench, board, 0xE3, len(some), *words(*some, *[0] * (7 - len(some))))


def pairs(bench: Bench, board: Controller, *three: tuple[int, int]) -> None:
    """Send three velocity-distance pairs by E0h."""
    send(bench, board, 0xE0, *words(*(number for pair in three for number in pair)))


def free(bench: Bench, board: Controller) -> int:
    """Return the free bytes that E2h reports."""
    return int.from_bytes(ask(bench, board, 0xE2)[1:5], "big")


def accumulated(levels: list[Fraction], start_ns: int, period_ns: int) -> list[int]:
    """Return the overflow times of a phase accumulator that runs at each of `levels` (pulses/s) for `period_ns`."""
    phase, times = Fraction(0), list[int]()
    for level in levels:
        after = phase + level * Fraction(period_ns, S)
        times += [int(start_ns + (n - phase) / level * S) for n in range(int(phase) + 1, int(after) + 1)]
        phase, start_ns = after, start_ns + period_ns
    return times


# Position tracking

AT_ONCE = 0x7FFF_FFFF  # an acceleration that reaches any velocity in one update
RATIO = (0xB0, 0x61, 0xA8, 0x0F, 0xA0)
RESOLUTION = (0xB1, 0, 0, 0x61, 0xA8)
SIGMA = (0xB2, *i32(0))
LAW = (0xB3, 1, 20, 0x00, *i32(50_000))
TEETH = (0xB4, 0, 0, 0, 50)
ALL = (RATIO, RESOLUTION, SIGMA, LAW, TEETH)


def tracked(
    bench: Bench, model: str = "1811", backlash: int = 0, options: dict[str, object] | None = None, **plant: object
) -> Controller:
    """Return an 1811 with encoder, with B0h to B4h defined, and a default velocity of 5,000 pulses/s without a ramp.

    A revolution is 25,000 motor pulses and 4,000 encoder pulses (6.25 to 1); each of 50 rotor teeth is 500 pulses.
    """
    encoder = {"counts_per_rev": 4000, "pulses_per_rev": 25_000, "backlash": backlash}
    board = ready(bench, model, motor={"encoder": encoder, **plant}, **(options or {}))
    for command in ALL:
        send(bench, board, *command)
    default(bench, board, 5_000, AT_ONCE)
    return board


def number(bench: Bench, board: Controller, opcode: int) -> int:
    """Return the number of four bytes that 98h, 99h, 9Ah or 9Bh reports."""
    data = ask(bench, board, opcode)
    assert data[0] == opcode and not any(data[5:])
    return int.from_bytes(data[1:5], "big", signed=True)


def start(bench: Bench, board: Controller, *command: int) -> None:
    """Send a command and run until its motion has just begun."""
    moves = len(board.axes["motor"].train.moves)
    send(bench, board, *command)
    assert bench.run_until(lambda: len(board.axes["motor"].train.moves) > moves, 0.1)
