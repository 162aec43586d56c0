"""Chapter Sequence buffers: definition, memory, trigger levels, and commands during a sequence."""

import pytest

from .programs import sequence
from .talking import ask, complete, default, i32, message, messages, send, send_all

NO_TIME = 0x7FFF_FFFF


def test_nothing_is_performed_while_a_sequence_is_defined(bench, board):
    """Requests and other commands that are not valid in a sequence are ignored while a sequence is defined."""
    default(bench, board, 10_000, NO_TIME)
    send(bench, board, 0xD9, 1)
    for command in ((0x08, 7), (0x90,), (0x33, *i32(100)), (0x70,), (0x41, 2), (0xDA, 1), (0xD9, 2)):
        send(bench, board, *command)
    bench.run(0.1)
    assert board.bus.read(1) == 0x50
    send_all(bench, board, (0xD8,), (0x92, 1))
    assert messages(bench, board) == ["92 08 07", "92 33 00 00 00 64", "92 00"]


def test_all_sequences_share_one_memory(bench, board):
    free = int.from_bytes(ask(bench, board, 0xE2)[1:5], "big")
    assert free == 600
    for number in range(1, 16):
        sequence(bench, board, number, *[(0x08, 1)] * 21)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 0
    send(bench, board, 0xDA, 1)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 42


@pytest.mark.parametrize(("trigger", "level"), [(2, 1), (3, 0), (4, 1), (5, 0)])
def test_wait_for_a_level(bench, board, trigger, level):
    board.pins[f"trigger{trigger}"].drive(not level)
    sequence(bench, board, 1, (0x2C, trigger, level), (0x08, 1))
    send(bench, board, 0x41, 1, seconds=1)
    board.pins[f"trigger{trigger}"].drive(bool(level))
    bench.run(0.001)
    board.pins[f"trigger{trigger}"].drive(not level)  # too short to act
    bench.run(0.1)
    assert board.bus.read(1) & 1 == 0
    board.pins[f"trigger{trigger}"].drive(bool(level))
    bench.run(0.005)
    assert board.bus.read(1) & 1 == 1


def test_who_is_heard_while_a_sequence_is_performed(bench, board):
    """Only commands that are valid concurrent with a sequence are performed: requests, but no move, sequence or 12h."""
    default(bench, board, 10_000, NO_TIME)
    sequence(bench, board, 1, (0x28, 0))
    sequence(bench, board, 2, (0x08, 7))
    send(bench, board, 0x41, 1)
    for command in ((0x33, *i32(100)), (0x41, 2), (0x12, 1), (0xD9, 1), (0x92, 1)):
        send(bench, board, *command)
    assert message(bench, board) == b""
    assert board.bus.read(1) == 0x50
    assert board.axes["motor"].position == 0
    assert not board.pins["shutdown"].level
    assert ask(bench, board, 0x90)[:2] == b"\x90\x50"


def test_an_undefined_sequence_or_move_is_ignored(bench, board):
    send(bench, board, 0x41, 4)
    sequence(bench, board, 5, (0x40, 9), (0x08, 1))
    complete(bench, board, 0x41, 5)
    assert board.bus.read(1) & 7 == 1
