"""Status bits, outputs, state bits (0Fh), joystick, shutdown, direction pin, self test."""

import pytest

from .talking import RESET, ask, complete, default, i32, message, messages, position, ready, send, send_all, until_idle

NO_TIME = 0x7FFF_FFFF


def test_programmable_outputs(bench, board):
    assert ask(bench, board, 0x97)[1] == 0x06
    send(bench, board, 0x0C, 1)
    assert [board.pins[f"output{n}"].level for n in (1, 2)] == [False, True]
    send(bench, board, 0x0D, 0xFB)
    assert ask(bench, board, 0x97)[1] == 0x02
    send_all(bench, board, (0x0B, 2), (0x0B, 3), (0x0B, 0))
    assert ask(bench, board, 0x97)[1] == 0x06


def test_a_bit_shows_whether_the_motor_is_moving(bench, board):
    """The manual's own: `0F 01 01 FF`; and output 2 the other way round."""
    send_all(bench, board, (0x0F, 1, 1, 0xFF), (0x0F, 4, 1, 0))
    default(bench, board, 10_000, 100_000)
    assert (board.bus.read(1) & 2, board.pins["output2"].level) == (0, True)
    send(bench, board, 0x33, *i32(3_000), seconds=0.05)
    assert (board.bus.read(1) & 2, board.pins["output2"].level) == (2, False)
    until_idle(bench, board)
    assert (board.bus.read(1) & 2, board.pins["output2"].level) == (0, True)
    send_all(bench, board, (0x0F, 4, 0, 0), (0x33, *i32(3_000)), seconds=0.05)
    assert board.pins["output2"].level


@pytest.mark.parametrize(("state", "seen"), [(2, [1, 0]), (5, [1, 0]), (6, [1, 0]), (7, [1, 0]), (3, [])])
def test_states_of_a_move(bench, board, state, seen):
    send(bench, board, 0x0F, 3, state, 1)
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append(pin.level))
    default(bench, board, 10_000, 100_000)
    complete(bench, board, 0x33, *i32(3_000))
    assert edges == seen


def test_a_state_that_is_not_defined_is_ignored(bench, board):
    send_all(bench, board, (0x0F, 3, 0x08, 1), (0x0F, 5, 0x01, 1))
    assert board.pins["output1"].level


def test_the_joystick_moves_the_motor_and_is_counted(bench, board):
    pins = board.pins
    pins["step_in"].drive(False)
    send(bench, board, 0x11, seconds=0.01)
    assert pins["remote_acknowledge"].level
    for cw, pulses in ((True, 30), (False, 12)):
        pins["direction_in"].drive(cw)
        bench.run(0.005)
        pins["at_zero"].drive(False)
        for _ in range(pulses):
            pins["step_in"].drive(True)
            bench.run(0.001)
            pins["step_in"].drive(False)
            bench.run(0.001)
        assert ask(bench, board, 0x8C)[1] == 0xFF
        pins["at_zero"].drive(True)
        bench.run(0.005)
    assert board.axes["motor"].position == 18
    assert position(bench, board, 0x80) == -12
    assert position(bench, board, 0x83) == 18
    send(bench, board, 0x30)  # ignored: "equivalent to performing a move"
    send(bench, board, 0x10, seconds=0.01)
    assert not pins["remote_acknowledge"].level
    pins["step_in"].drive(True)
    assert position(bench, board, 0x83) == 18


def test_the_joystick_excludes_moves(bench, board):
    default(bench, board, 10_000, NO_TIME)
    send_all(bench, board, (0x11,), (0x33, *i32(100)), seconds=0.1)
    assert board.axes["motor"].position == 0
    send(bench, board, 0x10)
    complete(bench, board, 0x33, *i32(100))
    assert board.axes["motor"].position == 100


def test_remote_shutdown(bench, board):
    default(bench, board, 10_000, NO_TIME)
    send(bench, board, 0x12, 1)
    assert board.pins["shutdown"].level
    send_all(bench, board, (0x33, *i32(100)), (0x11,), seconds=0.1)
    assert board.axes["motor"].position == 0
    assert not board.pins["remote_acknowledge"].level
    send_all(bench, board, (0x12, 0), (0x33, *i32(5_000)), seconds=0.1)
    send(bench, board, 0x12, 1)
    assert not board.pins["shutdown"].level


def test_the_shutdown_input_takes_the_say_from_the_command(bench, board):
    send_all(bench, board, (0x13, 1), (0x12, 1))
    assert not board.pins["shutdown"].level
    board.pins["shutdown_in"].drive(False)
    assert board.pins["shutdown"].level
    board.pins["shutdown_in"].drive(True)
    assert not board.pins["shutdown"].level


def test_inputs_are_reported(bench, board):
    for number in (2, 3, 4, 5):
        board.pins[f"trigger{number}"].drive(number in (3, 5))
    assert ask(bench, board, 0x94)[1] == 0b101000
    board.pins["remote_enable"].drive(False)
    assert ask(bench, board, 0x95)[1] == 0x00
    board.pins["remote_enable"].drive(True)
    assert ask(bench, board, 0x95)[1] == 0xFF


def test_the_step_pin_is_high_for_half_a_period_of_the_highest_frequency(bench, board):
    """Range 0: 546,133.3 Hz, 915 ns."""
    default(bench, board, 1_000, NO_TIME)
    complete(bench, board, 0x33, *i32(2))
    send(bench, board, 0x33, *i32(2))
    bench.run_until(lambda: board.axes["motor"].velocity, 1)
    bench.run(0.001)
    assert board.pins["step"].level
    bench.run(0.000_001)
    assert not board.pins["step"].level


@pytest.mark.parametrize("how", ["command", "switch", "command during a definition"])
def test_the_test_switch_function(bench, board, how):
    """25,000 pulses CCW at 5,000 Hz, the same CW, then the board monitor alarm."""
    if how == "switch":
        board.pins["test_switch"].drive(True)
    elif how == "command":
        send(bench, board, 0xFF)
    else:
        send_all(bench, board, (0xD9, 1), (0xFF,))
    motor = board.axes["motor"]
    bench.run(5.0)
    assert -25_000 <= motor.position <= -24_990
    bench.run(4.9)
    assert not board.pins["led"].level
    bench.run(0.2)
    assert motor.position == 0
    assert board.pins["led"].level
    assert board.bus.read(1) & 0x20
    board.bus.write(0, 0x90)
    board.bus.write(1, 0x10)
    assert message(bench, board) == b""
    board.bus.write(1, RESET)
    bench.run(1.01)
    assert board.bus.read(1) == 0x50
    assert not board.pins["led"].level


def test_a_failure_interrupts_the_host_until_the_reset(bench):
    board = ready(bench, interrupts=("failed",))
    board.bus.write(0, 0xFF)
    board.bus.write(1, 0x50)
    bench.run(10.1)
    assert board.bus.interrupt
    board.bus.write(1, 0xC0)
    assert board.bus.interrupt
    board.bus.write(1, RESET)
    assert not board.bus.interrupt


def test_the_test_switch_needs_its_jumper(bench):
    board = ready(bench, test_switch=False)
    board.pins["test_switch"].drive(True)
    bench.run(1)
    assert board.axes["motor"].position == 0


def test_the_part_number(bench, board):
    data = ask(bench, board, 0xFD)
    assert data[0] == 0xFD
    assert data[1:].rstrip(b"\0").decode("ascii").startswith("94-")
    assert messages(bench, board) == []
