"""A host of an 1810 or 1811: the handshakes of the manual, at full speed."""

from axistwin import Bench
from axistwin.bench import Controller

DATA, CONTROL = 0, 1
COMMAND_READY, RESET, ENABLE, TAKEN = 0x10, 0x20, 0x40, 0x80
MESSAGE, INPUT_READY, FAIL = 0x08, 0x10, 0x20


def ready(bench: Bench, model: str = "1811", **options: object) -> Controller:
    """A board whose initialisation is over."""
    board = bench.add(model, **options)
    bench.run(1.01)
    assert board.bus.read(CONTROL) == 0x50
    return board


def write(board: Controller, *values: int, control: int = 0) -> None:
    """Command bytes into the IDB, and CB bit 4."""
    for value in values:
        board.bus.write(DATA, value)
    board.bus.write(CONTROL, COMMAND_READY | control)


def tell(bench: Bench, board: Controller, *values: int) -> None:
    """A whole handshake; the command has been read when it returns."""
    assert bench.run_until(lambda: board.bus.read(CONTROL) & INPUT_READY, 1)
    write(board, *values)
    assert bench.run_until(lambda: board.bus.read(CONTROL) & INPUT_READY, 1)


def message(bench: Bench, board: Controller, timeout: float = 0.1) -> bytes:
    """The next message, all sixteen bytes; nothing if there is none in time."""
    if not bench.run_until(lambda: board.bus.read(CONTROL) & MESSAGE, timeout):
        return b""
    data = bytes(board.bus.read(DATA) for _ in range(16))
    board.bus.write(CONTROL, TAKEN)
    return data


def messages(bench: Bench, board: Controller) -> list[str]:
    """All messages there are, as hex without the trailing zeros (but two bytes at least)."""
    found = []
    while data := message(bench, board):
        found.append((data[:2] + data[2:].rstrip(b"\0")).hex(" "))
    return found


def ask(bench: Bench, board: Controller, *values: int) -> bytes:
    """A command and the message it causes."""
    tell(bench, board, *values)
    return message(bench, board)


def i32(number: int) -> tuple[int, ...]:
    """Four bytes, two's complement."""
    return tuple(number.to_bytes(4, "big", signed=True))


def position(bench: Bench, board: Controller, opcode: int = 0x83) -> int:
    """The reply to 80, 81, 82 or 83."""
    data = ask(bench, board, opcode)
    assert data[0] == opcode
    size = 4 if opcode in (0x80, 0x81) else 6
    assert not any(data[1 + size :])
    return int.from_bytes(data[1 : 1 + size], "big", signed=True)


def default(bench: Bench, board: Controller, velocity: int, acceleration: int, ranges: int = 0x00) -> None:
    """Command 31h."""
    tell(bench, board, 0x31, 0, ranges, *i32(velocity), *i32(acceleration))


def rest(bench: Bench, board: Controller, timeout: float = 100) -> None:
    """Let the motion end."""
    bench.run(0.03)
    assert bench.run_until(lambda: board.axes["motor"].velocity == 0, timeout)
    bench.run(0.0001)
