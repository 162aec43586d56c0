"""Undefined states of 0Fh, the shutdown input, the STEP output, and the jumper of the test switch."""

from .talking import complete, default, i32, ready, send, send_all

NO_TIME = 0x7FFF_FFFF


def test_a_state_that_is_not_defined_is_ignored(bench, board):
    send_all(bench, board, (0x0F, 3, 0x08, 1), (0x0F, 5, 0x01, 1))
    assert board.pins["output1"].level


def test_the_shutdown_input_takes_the_say_from_the_command(bench, board):
    send_all(bench, board, (0x13, 1), (0x12, 1))
    assert not board.pins["shutdown"].level
    board.pins["shutdown_in"].drive(False)
    assert board.pins["shutdown"].level
    board.pins["shutdown_in"].drive(True)
    assert not board.pins["shutdown"].level


def test_the_step_pin_is_high_for_half_a_period_of_the_highest_frequency(bench, board):
    """STEP is high for half a period of the highest frequency: in range 0, 546,133.3 Hz, this is 915 ns."""
    default(bench, board, 1_000, NO_TIME)
    complete(bench, board, 0x33, *i32(2))
    send(bench, board, 0x33, *i32(2))
    bench.run_until(lambda: board.axes["motor"].velocity, 1)
    bench.run(0.001)
    assert board.pins["step"].level
    bench.run(0.000_001)
    assert not board.pins["step"].level


def test_the_test_switch_needs_its_jumper(bench):
    board = ready(bench, test_switch=False)
    board.pins["test_switch"].drive(True)
    bench.run(1)
    assert board.axes["motor"].position == 0
