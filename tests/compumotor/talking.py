"""A host of an 1810 or 1811: the handshakes of the manual, at full speed."""

from collections.abc import Sequence

import pytest

from axistwin import Bench
from axistwin.bench import Controller

DATA, CONTROL = 0, 1
COMMAND_READY, RESET, ENABLE, TAKEN = 0x10, 0x20, 0x40, 0x80
MESSAGE, INPUT_READY, FAIL = 0x08, 0x10, 0x20


def in_all_ways(seconds: float, slice_s: float, slices: int) -> pytest.MarkDecorator:
    """Return a mark: the test gets `run`, which lets the time pass at once, in slices, or event by event."""
    ways = {
        "at once": lambda bench: bench.run(seconds),
        "in slices": lambda bench: [bench.run(slice_s) for _ in range(slices)],
        "event by event": lambda bench: bench.run_until(lambda: False, seconds),
    }
    return pytest.mark.parametrize("run", ways.values(), ids=ways)


def i32(number: int) -> tuple[int, ...]:
    """Return the four bytes of a number in two's complement."""
    return tuple(number.to_bytes(4, "big", signed=True))


def ready(bench: Bench, model: str = "1811", **options: object) -> Controller:
    """Add a board and run until its initialisation has ended."""
    board = bench.add(model, **options)
    bench.run(1.01)
    assert status_word(bench, board) == 0x50
    return board


def write(board: Controller, *values: int, control: int = 0) -> None:
    """Write a command into the IDB and set CB bit 4."""
    for value in values:
        board.bus.write(DATA, value)
    board.bus.write(CONTROL, COMMAND_READY | control)


def send(bench: Bench, board: Controller, *what: int, seconds: float = 0) -> None:
    """Send a command by the handshake and run for `seconds`; `messages` then reads the messages that it causes."""
    assert bench.run_until(lambda: status_word(bench, board) & INPUT_READY, 1)
    write(board, *what)
    assert bench.run_until(lambda: status_word(bench, board) & INPUT_READY, 1)
    if seconds:
        bench.run(seconds)


def send_all(bench: Bench, board: Controller, *commands: Sequence[int], seconds: float = 0) -> None:
    """Send several commands, then run for `seconds`."""
    for command in commands:
        send(bench, board, *command)
    if seconds:
        bench.run(seconds)


def complete(bench: Bench, board: Controller, *what: int) -> None:
    """Send a command and run until its motion has ended."""
    send(bench, board, *what)
    until_idle(bench, board)


def status_word(bench: Bench, board: Controller) -> int:  # the same arguments in all families
    """Return the status byte."""
    return board.bus.read(CONTROL)


def message(bench: Bench, board: Controller, timeout: float = 0.1) -> bytes:
    """Return the sixteen bytes of the next message, or no bytes if none comes within `timeout` seconds."""
    if not bench.run_until(lambda: status_word(bench, board) & MESSAGE, timeout):
        return b""
    data = bytes(board.bus.read(DATA) for _ in range(16))
    board.bus.write(CONTROL, TAKEN)
    return data


def messages(bench: Bench, board: Controller) -> list[str]:
    """Return all waiting messages in hex, without trailing zeros after the second byte."""
    found = []
    while data := message(bench, board):
        found.append((data[:2] + data[2:].rstrip(b"\0")).hex(" "))
    return found


def ask(bench: Bench, board: Controller, *what: int) -> bytes:
    """Send a command and return the message that it causes."""
    send(bench, board, *what)
    return message(bench, board)


def position(bench: Bench, board: Controller, opcode: int = 0x83) -> int:
    """Return the position that 80h, 81h, 82h or 83h reports."""
    data = ask(bench, board, opcode)
    assert data[0] == opcode
    size = 4 if opcode in (0x80, 0x81) else 6
    assert not any(data[1 + size :])
    return int.from_bytes(data[1 : 1 + size], "big", signed=True)


def default(bench: Bench, board: Controller, velocity: int, acceleration: int, ranges: int = 0x00) -> None:
    """Send command 31h: default velocity and acceleration."""
    send(bench, board, 0x31, 0, ranges, *i32(velocity), *i32(acceleration))


def until_idle(bench: Bench, board: Controller, timeout: float = 100) -> None:
    bench.run(0.03)
    assert bench.run_until(lambda: board.axes["motor"].velocity == 0, timeout)
    bench.run(0.0001)
