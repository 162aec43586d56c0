"""What tests by the manual's chapters do again and again: a motor at speed, a trigger's edge, a sequence, a tally."""

from axistwin import Bench
from axistwin.bench import Controller
from axistwin.units import MS

from .talking import default, i32, messages, tell


def cruise(
    bench: Bench, board: Controller, velocity: int = 10_000, acceleration: int = 100_000, minus: int = 0
) -> None:
    """A continuous move, at constant velocity when this returns."""
    default(bench, board, velocity, acceleration)
    tell(bench, board, 0x32, int(minus))
    bench.run(velocity / acceleration + 0.05)
    assert board.axes["motor"].velocity == (-velocity if minus else velocity)


def rising(bench: Bench, board: Controller, trigger: int) -> None:
    """An edge that is good enough for triggers 1 and 6: 3 ms low, then high for 1 ms."""
    board.pins[f"trigger{trigger}"].drive(False)
    bench.run(0.003)
    board.pins[f"trigger{trigger}"].drive(True)
    bench.run(0.001)


def sequence(bench: Bench, board: Controller, number: int, *commands: tuple[int, ...]) -> None:
    """Define a sequence."""
    tell(bench, board, 0xD9, number)
    for command in commands:
        tell(bench, board, *command)
    tell(bench, board, 0xD8)


def listing(bench: Bench, board: Controller, number: int) -> list[str]:
    """What 92h says of a sequence."""
    tell(bench, board, 0x92, number)
    return messages(bench, board)


def relative(number: int, velocity: int, acceleration: int, distance: int, ranges: int = 0) -> tuple[int, ...]:
    """Command C8h."""
    return (0xC8, number, ranges, *i32(velocity), *i32(acceleration), *i32(distance))


def continuous(number: int, velocity: int, acceleration: int, minus: int = 0, ranges: int = 0) -> tuple[int, ...]:
    """Command CEh."""
    return (0xCE, number, ranges, *i32(velocity), *i32(acceleration), minus)


def steps(board: Controller, start_ns: int = 0) -> list[int]:
    """When pulses were issued."""
    return [int(t) for t in board.axes["motor"].pulse_times(start_ns)]


def about(seconds: float, got_ns: int, tolerance_ms: float = 4) -> bool:
    """Ramps are updated every two milliseconds: a time is right within two of those."""
    return abs(got_ns - seconds * 1_000_000_000) <= tolerance_ms * MS
