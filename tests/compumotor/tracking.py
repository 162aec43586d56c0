"""An 1811 whose motor has an encoder: 25,000 to 4,000 pulses a revolution, 6.25 to 1; 50 rotor teeth of 500 pulses."""

from axistwin import Bench
from axistwin.bench import Controller

from .talking import ask, default, i32, ready, tell

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
    """With B0h to B4h, and 5,000 pulses/s without a ramp by default."""
    encoder = {"counts_per_rev": 4000, "pulses_per_rev": 25_000, "backlash": backlash}
    board = ready(bench, model, motor={"encoder": encoder, **plant}, **(options or {}))
    for command in ALL:
        tell(bench, board, *command)
    default(bench, board, 5_000, AT_ONCE)
    return board


def number(bench: Bench, board: Controller, opcode: int) -> int:
    """The reply to 98h, 99h, 9Ah, 9Bh: four bytes."""
    data = ask(bench, board, opcode)
    assert data[0] == opcode
    assert not any(data[5:])
    return int.from_bytes(data[1:5], "big", signed=True)


def start(bench: Bench, board: Controller, *command: int) -> None:
    """A command, and time until its motion has just begun."""
    strokes = len(board.axes["motor"].train.moves)
    tell(bench, board, *command)
    assert bench.run_until(lambda: len(board.axes["motor"].train.moves) > strokes, 0.1)
