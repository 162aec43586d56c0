"""Commands for sequence buffers that the operator can choose, and subscriptions to commands and messages."""

import pytest

from axistwin.bench import product

from .programs import sequence
from .talking import ask, default, i32, messages, ready, send, until_idle

SAYS = {"perform": 0x41, "suspend": 0x72, "continue": 0x48, "discontinue": 0x71, "kill": 0x79}
"""Command summary: perform, suspend, CONTINUE, discontinue and KILL the sequence buffer."""


def order(program, label):
    return next(each for each in product("1811").orders(program) if each.label == label)


@pytest.mark.parametrize("label", SAYS)
def test_an_order_is_the_command_of_the_summary(label):
    for number in (1, 15):
        behind = bytes([number]) if label == "perform" else b""
        assert order(f"sequence {number}", label).says == bytes([SAYS[label]]) + behind


def test_there_are_fifteen_sequences():
    """41h, D9h: the number of a sequence is "01 -> 0F"."""
    assert product("1811").programs == tuple(f"sequence {number}" for number in range(1, 16))


def test_the_orders_do_to_a_sequence_what_they_say(bench, board):
    """41h, 72h, 48h, 71h and 79h act on a sequence, whose 01h sends a message each time it is performed."""
    default(bench, board, 10_000, 1_000_000)
    sequence(bench, board, 2, (0x21, 2), (0x29, 0, 0, 0, 200), (0x01, 5))

    def say(label, seconds):
        send(bench, board, *order("sequence 2", label).says, seconds=seconds)
        return messages(bench, board)

    assert say("perform", 0.25) == ["01 05"] and say("suspend", 0.5) == []
    assert say("continue", 0.05) == ["01 05"]  # it was suspended in the 29h, and continues after it
    assert say("discontinue", 1) == [] and say("perform", 0.25) == ["01 05"]
    assert say("kill", 1) == [] and not board.registers["sequence"].read()


def test_who_listens_is_told_each_command_and_each_message(bench):
    """Reading and writing: a command is the content of the IDB when CB bit 4 is set; a message has 16 bytes."""
    board = ready(bench)
    told, heard = [], []
    ends = board.bus.subscribe_sent(told.append), board.bus.subscribe_received(heard.append)
    assert ask(bench, board, 0x94)[0] == 0x94
    send(bench, board, 0x40, 0x05, 0, 0)
    assert told == [b"\x94", b"\x40\x05\0\0"]
    assert heard == [bytes([0x94, 0b0011_1100]).ljust(16, b"\0")]
    for end in ends:
        end()
    ask(bench, board, 0x94)
    assert (len(told), len(heard)) == (2, 1)


def test_a_second_command_ready_while_the_idb_is_not_ready_is_no_command(bench, board):
    """Writing commands: only when "the IDB-Ready bit is set" may the host set CB bit 4; otherwise it is ignored."""
    default(bench, board, 10_000, 1_000_000)
    told = []
    board.bus.subscribe_sent(told.append)
    for value in (0x33, *i32(100)):
        board.bus.write(0, value)
    for _ in range(3):
        board.bus.write(1, 0x10)
    until_idle(bench, board)
    assert told == [bytes([0x33, *i32(100)])] and board.axes["motor"].position == 100


def test_a_board_is_called_by_the_name_in_the_manual():
    """Title page: "Model 1810/11 Motor Controller"; Description: the 1811 has the encoder interface."""
    for model in ("1810", "1811"):
        title = product(model).title.lower()
        assert all(word in title for word in ("compumotor", model, "multibus", "motor controller"))
        assert ("encoder" in title) is (model == "1811")
