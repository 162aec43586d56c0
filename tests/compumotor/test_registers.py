"""Chapters Reading and writing, Control byte and status byte, Interrupts."""

import pytest

from axistwin import Bench
from axistwin.core.errors import UsageError

from ..scripts import scripts
from .scripts import play
from .talking import ENABLE, RESET, TAKEN, ask, default, i32, ready, send, send_all, write


@scripts({
    "bit four clears with the command and is set again about a millisecond later":
    "IDB 01 07; CB 10; SB 40; 0.0009 s; SB 40; 0.0002 s; SB 50",
    "asking takes about five milliseconds": "clock; 8C -> 00; 5 to 6 ms later",
    "messages come out one at a time in order":
    "01 00; 01 01; 01 02; 01 03; 01 04; 01 05; 01 06; 01 07; 01 08; 01 09; says 01 00, 01 01, 01 02, 01 03, "
    "01 04, 01 05, 01 06, 01 07, 01 08, 01 09",
    "user bits are seen in the status byte":
    "08 {00|01|02|03|04|05|06|07}; SB {50|51|52|53|54|55|56|57}; ju19 is low",
    '"The interrupt mask bit is always the negative of the current value of the interrupt enable bit"':
    "IDB 01 07; CB 50; 0.01 s; interrupt; SB 98; CB 00; no interrupt; SB 58; CB 40; interrupt; CB C0; "
    "no interrupt; SB 10",
    "power that is on already is no reset": "08 05; power on; SB 55",
    "power up takes about one second and leaves 50h": "new 1811; SB 40; 0.9 s; SB 40; 0.11 s; SB 50",
    "bytes that were not read are overwritten by the next message":
    "01 11; 01 22; 0.02 s; ODB 01; CB 80; SB & 8 is 0; next 01 22",
    "commands queue up and are obeyed in order": "08 05; 90; 08 02; SB & 7 is 5; next 90 50; 0.0001 s; SB & 7 is 2",
    "a board without power does not drive the bus": "power off; IDB 01; CB 10; ODB FF; SB FF",
    "a fifo holds sixteen bytes: the seventeenth byte is lost, so the command of sixteen bytes is still valid":
    "IDB 01 07 00 00 00 00 00 00 00 00 00 00 00 00 00 00 55; CB 10; next 01 07",
})  # fmt: skip
def test_registers(bench, script):
    play(bench, script)


def test_a_message_has_sixteen_bytes_and_is_taken_with_bit_seven(bench, board):
    write(board, 0x01, 0x07)
    bench.run(0.01)
    assert board.bus.read(1) == 0x58 and bytes(board.bus.read(0) for _ in range(16)) == bytes([0x01, 0x07]) + bytes(14)
    assert board.bus.read(1) == 0x58
    board.bus.write(1, 0x0F)  # bits 0 to 3 of the control byte are not used
    assert board.bus.read(1) == 0x58
    board.bus.write(1, TAKEN)
    assert board.bus.read(1) == 0x50


def test_the_input_ready_interrupt_is_cleared_by_bit_four(bench):
    board, seen = ready(bench, interrupts=("input_ready",)), []
    board.bus.interrupt_line.subscribe(lambda pin: seen.append(pin.level))
    board.bus.write(1, ENABLE)
    write(board, 0x00, control=ENABLE)
    bench.run(0.01)
    assert seen == [True, False, True]


def test_the_first_interrupt_masks_those_after_it_until_it_is_cleared(bench):
    board = ready(bench, interrupts=("message_ready", "input_ready"))
    board.bus.write(1, ENABLE)
    seen = []
    board.bus.interrupt_line.subscribe(lambda pin: seen.append(pin.level))
    tell_with_interrupts = (0x01, 0x07)
    write(board, *tell_with_interrupts, control=ENABLE)
    bench.run(0.02)
    assert seen == [False, True]  # ready for input again; a message does not matter
    board.bus.write(1, TAKEN | ENABLE)
    assert seen == [False, True]


def test_interrupt_lines_that_are_wired_directly_know_no_mask(bench, board):
    """Installation: JU18 to JU20, right side: such lines are "not affected by the 1810/11's interrupt mask"."""
    lines = {name: board.pins[name] for name in ("ju18", "ju20", "ju19")}
    seen = []
    for line in lines.values():
        line.subscribe(lambda pin: seen.append((pin.name, pin.level)))
    send(bench, board, 0x01, 7)
    assert seen == [("ju20", False), ("ju20", True)]
    bench.run(0.02)
    assert not board.bus.interrupt
    assert [line.level for line in lines.values()] == [True, True, False]
    board.bus.write(1, TAKEN)
    assert not lines["ju18"].level
    send(bench, board, 0xFF, seconds=10.1)
    assert lines["ju19"].level
    board.power(False)
    assert not any(line.level for line in lines.values())


RESETS = {
    "register": lambda board: board.bus.write(1, RESET),
    "bus": lambda board: board.bus.init(),
    "power": lambda board: board.power_cycle(),
}


@pytest.mark.parametrize("reset", RESETS.values(), ids=RESETS)
def test_a_reset_forgets_everything(bench, board, reset):
    send_all(bench, board, (0x08, 0x07), (0x0C, 1), (0x31, 0, 0, *(0, 0, 1, 0) * 2))
    reset(board)
    assert board.bus.read(1) == 0x40 and board.pins["output1"].level
    bench.run(1.01)
    assert board.bus.read(1) == 0x50 and ask(bench, board, 0x91, 0) == b"\x91\xce".ljust(16, b"\0")


@pytest.mark.parametrize("reset", RESETS.values(), ids=RESETS)
def test_a_reset_ends_a_calculation_a_request_and_a_command_that_waits(bench, board, reset):
    """Of a move that begins 14 ms after its command, a request and 0Ch, nothing comes after a reset in between."""
    default(bench, board, 10_000, 100_000)
    send_all(bench, board, (0x33, 0, 0, 0, 10), (0x8C,), (0x0C, 1))
    reset(board)
    bench.run(0.1)
    assert (board.bus.read(1), board.pins["output1"].level, board.axes["motor"].pulses) == (0x40, True, 0)


@pytest.mark.parametrize(("command", "place"), [((0x33, *i32(1_000)), 0), ((0xFF,), -25_000)])
def test_a_reset_at_an_edge_that_the_board_causes_comes_before_the_next_pulse(bench, board, command, place):
    """A host resets the board as DIRECTION becomes CW: before a move, or in the test function after its CCW turn."""
    default(bench, board, 10_000, 100_000)
    hosts = [board.pins["direction"].subscribe(lambda pin: hosts and (hosts.pop()(), board.bus.write(1, RESET)))]
    send(bench, board, *command, seconds=11)
    assert not hosts
    assert (board.bus.read(1), board.pins["led"].level, board.axes["motor"].position) == (0x50, False, place)


def test_a_reset_just_after_the_power_goes_leaves_it_off(bench, board):
    """Both happen at an edge that the board causes, so they take effect when its procedure waits."""
    board.pins["output1"].subscribe(lambda pin: (board.power(False), board.bus.write(1, RESET)))
    write(board, 0x0C, 1)
    bench.run(2)
    assert (board.bus.read(1), board.registers["phase"].read()) == (0xFF, "off")


def test_a_host_may_reset_the_board_as_soon_as_the_status_byte_appears(bench, board):
    board.power(False)
    hosts = [board.bus.status_changes.subscribe(lambda: hosts and (hosts.pop()(), board.bus.write(1, RESET)))]
    board.power(True)
    assert not hosts
    bench.run(1.01)
    assert board.bus.read(1) == 0x50


def test_one_who_asks_the_wrong_plug_is_told(bench, board):
    with pytest.raises(UsageError, match="bus"):
        _ = board.serial
    with pytest.raises(UsageError, match="serial"):
        _ = Bench().add("if1").bus
    with pytest.raises(UsageError, match="line"):
        bench.add("1810", line="9600 8N2")
    with pytest.raises(UsageError, match="0 to 1"):
        board.bus.read(2)
    with pytest.raises(UsageError, match="0 to 255"):
        board.bus.write(0, 256)
    with pytest.raises(UsageError, match="message_ready"):
        bench.add("1811", interrupts=("nonsense",))
