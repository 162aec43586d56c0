"""Chapter Sequence buffers: the manual's example, loops, waits, listing, memory, discontinuing and killing."""

import pytest

from .talking import ask, complete, default, i32, message, messages, send, send_all

NO_TIME = 0x7FFF_FFFF


def define(bench, board, number, *commands):
    send(bench, board, 0xD9, number)
    for command in commands:
        send(bench, board, *command)
    send(bench, board, 0xD8)


def move(bench, board, number, distance, velocity=500_000):
    send(bench, board, 0xC8, number, 0, *i32(velocity), *i32(NO_TIME), *i32(distance))


def test_the_manuals_example(bench, board):
    """Two moves with an output around them, then fifteen times move 8, two seconds, request position.

    The listing's `2A 02` lacks a byte and `83` has no printed attributes (X13, X15).
    """
    for number, distance in ((0x12, 25_000), (0x05, 50_000), (0x08, 1_000)):
        move(bench, board, number, distance)
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append((pin.level, board.axes["motor"].position)))
    send(bench, board, 0x0C, 1)
    define(
        bench, board, 8,
        (0x40, 0x12), (0x0B, 1), (0x40, 5), (0x0C, 1), (0x20, 3, 0, 15), (0x40, 8), (0x2A, 0, 2), (0x83,),
    )  # fmt: skip
    assert board.axes["motor"].position == 0
    send(bench, board, 0x41, 8, seconds=32)
    assert edges == [(False, 0), (True, 25_000), (False, 75_000)]
    expected = [f"83 {(75_000 + 1_000 * n).to_bytes(6, 'big').hex(' ')}" for n in range(1, 16)]
    assert [text.ljust(20) for text in messages(bench, board)] == [text.removesuffix(" 00") for text in expected]
    assert board.axes["motor"].position == 90_000


def test_nothing_is_performed_while_a_sequence_is_defined(bench, board):
    """Commands that is not allowed in a sequence are ignored, requests among them."""
    default(bench, board, 10_000, NO_TIME)
    send(bench, board, 0xD9, 1)
    for command in ((0x08, 7), (0x90,), (0x33, *i32(100)), (0x70,), (0x41, 2), (0xDA, 1), (0xD9, 2)):
        send(bench, board, *command)
    bench.run(0.1)
    assert board.bus.read(1) == 0x50
    send_all(bench, board, (0xD8,), (0x92, 1))
    assert messages(bench, board) == ["92 08 07", "92 33 00 00 00 64", "92 00"]


def test_the_listing_forgets_messages_that_are_waiting(bench, board):
    define(bench, board, 3, (0x0B, 1, 0, 0))
    send_all(bench, board, (0x01, 1), (0x01, 2), seconds=0.05)
    send(bench, board, 0x92, 3)
    assert messages(bench, board) == ["92 0b 01", "92 00"]


def test_all_sequences_share_one_memory(bench, board):
    free = int.from_bytes(ask(bench, board, 0xE2)[1:5], "big")
    assert free == 600
    for number in range(1, 16):
        define(bench, board, number, *[(0x08, 1)] * 21)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 0
    send(bench, board, 0xDA, 1)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 42


def test_a_loop_until_continue_completes_its_round(bench, board):
    define(bench, board, 1, (0x21, 2), (0x01, 1), (0x29, 0, 0, 0, 100), (0x01, 2))
    send(bench, board, 0x41, 1, seconds=0.55)
    send(bench, board, 0x48, seconds=1)
    seen = messages(bench, board)
    assert seen[-1] == "01 02"
    assert 5 <= seen.count("01 01") <= 7


def test_loops_do_not_nest(bench, board):
    define(bench, board, 1, (0x20, 2, 0, 3), (0x20, 1, 0, 50), (0x01, 1), (0x01, 2))
    send(bench, board, 0x41, 1)
    assert messages(bench, board) == ["01 01"] * 3 + ["01 02"]


def test_wait_for_continue(bench, board):
    define(bench, board, 1, (0x28, 1), (0x01, 1))
    send(bench, board, 0x41, 1)
    assert messages(bench, board) == ["28 00"]
    send(bench, board, 0x48)
    assert messages(bench, board) == ["01 01"]


@pytest.mark.parametrize(
    ("command", "seconds"), [((0x29, 0, 0, 0x03, 0xE8), 1), ((0x2A, 0, 5), 5), ((0x2B, 0, 2), 120)]
)
def test_waits(bench, board, command, seconds):
    define(bench, board, 1, command, (0x08, 1))
    send(bench, board, 0x41, 1, seconds=seconds - 0.01)
    assert board.bus.read(1) & 1 == 0
    bench.run(0.02)
    assert board.bus.read(1) & 1 == 1


@pytest.mark.parametrize(("trigger", "level"), [(2, 1), (3, 0), (4, 1), (5, 0)])
def test_wait_for_a_level(bench, board, trigger, level):
    board.pins[f"trigger{trigger}"].drive(not level)
    define(bench, board, 1, (0x2C, trigger, level), (0x08, 1))
    send(bench, board, 0x41, 1, seconds=1)
    board.pins[f"trigger{trigger}"].drive(bool(level))
    bench.run(0.001)
    board.pins[f"trigger{trigger}"].drive(not level)  # too short
    bench.run(0.1)
    assert board.bus.read(1) & 1 == 0
    board.pins[f"trigger{trigger}"].drive(bool(level))
    bench.run(0.005)
    assert board.bus.read(1) & 1 == 1


@pytest.mark.parametrize("trigger", [1, 6])
def test_wait_for_an_edge(bench, board, trigger):
    define(bench, board, 1, (0x2C, trigger, 0), (0x08, 1))
    send(bench, board, 0x41, 1)
    board.pins[f"trigger{trigger}"].drive(False)
    bench.run(0.01)
    assert board.bus.read(1) & 1 == 0
    board.pins[f"trigger{trigger}"].drive(True)
    bench.run(0.003)
    assert board.bus.read(1) & 1 == 1


ENDING = [  # opcode, positions after it: at once, and after CONTINUE; is the motor still moving?
    (0x71, 30_000, 30_000),
    (0x72, 30_000, 60_000),
]


@pytest.mark.parametrize(("opcode", "then", "after_continue"), ENDING)
@pytest.mark.parametrize("by_trigger", [False, True])
def test_discontinue_and_suspend_finish_the_present_command(bench, board, opcode, then, after_continue, by_trigger):
    move(bench, board, 1, 30_000, 100_000)
    define(bench, board, 1, (0x40, 1), (0x40, 1))
    if by_trigger:
        send(bench, board, opcode + 4, 1, 1, 1)
    send(bench, board, 0x41, 1, seconds=0.1)
    if by_trigger:
        board.pins["trigger1"].drive(False)
        bench.run(0.003)
        board.pins["trigger1"].drive(True)
    else:
        send(bench, board, opcode)
    bench.run(2)
    assert board.axes["motor"].position == then
    assert messages(bench, board) == ([f"{opcode + 4:02x} 01"] if by_trigger else [])
    send(bench, board, 0x48, seconds=2)
    assert board.axes["motor"].position == after_continue


@pytest.mark.parametrize(("opcode", "goes_on"), [(0x79, False), (0x7A, True)])
def test_kill_ends_the_move_at_its_velocity(bench, board, opcode, goes_on):
    move(bench, board, 1, 30_000, 100_000)
    define(bench, board, 1, (0x40, 1), (0x08, 1))
    send(bench, board, 0x41, 1, seconds=0.1)
    send(bench, board, opcode, seconds=1)
    assert board.axes["motor"].velocity == 100_000
    send(bench, board, 0x78)
    assert board.bus.read(1) & 1 == 0
    send(bench, board, 0x48, seconds=0.1)
    assert board.bus.read(1) & 1 == goes_on


def test_who_is_heard_while_a_sequence_is_performed(bench, board):
    """Only what is valid concurrent with it: not a move, nor another sequence, nor 12h; requests are."""
    default(bench, board, 10_000, NO_TIME)
    define(bench, board, 1, (0x28, 0))
    define(bench, board, 2, (0x08, 7))
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
    define(bench, board, 5, (0x40, 9), (0x08, 1))
    complete(bench, board, 0x41, 5)
    assert board.bus.read(1) & 7 == 1
