"""Manual, Appendix A: 20h to 2Ch, 41h, 48h, 92h, D8h to DAh (sequences)."""

import pytest

from axistwin.units import MS

from .programs import about, listing, relative, rising, sequence
from .talking import ask, complete, messages, send, send_all


def perform(bench, board, *commands):
    sequence(bench, board, 1, *commands)
    send(bench, board, 0x41, 1)


@pytest.mark.parametrize("times", [1, 2, 255, 256, 1000])
def test_repeat_x_commands_y_times(bench, board, times):
    """20h: the following X commands are repeated Y times; Y has two bytes, the most significant first."""
    send(bench, board, *relative(1, 500_000, 0x7FFF_FFFF, 3))
    perform(bench, board, (0x20, 1, *divmod(times, 256)), (0x40, 1), (0x01, 9))
    bench.run(10)
    assert messages(bench, board) == ["01 09"]
    assert board.axes["motor"].position == 3 * times


@pytest.mark.parametrize("wrong", [(0x20, 0, 0, 5), (0x20, 2, 0, 0), (0x21, 0)])
def test_a_loop_of_nothing_is_ignored(bench, board, wrong):
    """20h: "If zero is specified for either X or Y the command is ignored"."""
    perform(bench, board, wrong, (0x01, 1), (0x01, 2))
    bench.run(0.1)
    assert messages(bench, board) == ["01 01", "01 02"]


def test_the_inner_loop_is_ignored(bench, board):
    """20h: "There is no nesting of loops ... the inner loop command is ignored"."""
    perform(bench, board, (0x20, 4, 0, 2), (0x20, 1, 0, 9), (0x01, 1), (0x20, 1, 0, 9), (0x01, 2), (0x01, 3))
    bench.run(0.2)
    found = messages(bench, board)
    assert found.count("01 02") == 2
    assert found[-1] == "01 03"
    assert found.count("01 01") == 2


def test_a_loop_until_continue(bench, board):
    """21h: "the current loop iteration will be completed and the next command ... following the loop is performed"."""
    send(bench, board, *relative(1, 10_000, 1_000_000, 100))
    perform(bench, board, (0x21, 2), (0x40, 1), (0x29, *(0, 0, 0, 100)), (0x01, 7))
    bench.run(1)
    assert messages(bench, board) == []
    send(bench, board, 0x48, seconds=0.3)
    assert messages(bench, board) == ["01 07"]
    rounds = board.axes["motor"].position
    assert rounds % 100 == 0
    assert 600 <= rounds <= 1_100
    bench.run(1)
    assert board.axes["motor"].position == rounds


@pytest.mark.parametrize("parameter", [0x00, 0x01, 0xFF])
def test_wait_for_a_continue(bench, board, parameter):
    """28h: "this command (28h) followed by fifteen zeroes"; "Other commands may be issued and performed"."""
    perform(bench, board, (0x28, parameter), (0x01, 1))
    bench.run(1)
    assert messages(bench, board) == (["28 00"] if parameter else [])
    assert ask(bench, board, 0x97)[1] == 6
    send(bench, board, 0x48, seconds=0.1)
    assert messages(bench, board) == ["01 01"]


@pytest.mark.parametrize(
    ("command", "seconds"),
    [
        ((0x29, 0, 0, 0, 1), 0.001), ((0x29, 0, 0, 1, 0), 0.256), ((0x29, 0, 1, 0, 0), 65.536), ((0x2A, 0, 1), 1),
        ((0x2A, 1, 0), 256), ((0x2A, 0xFF, 0xFF), 65_535), ((0x2B, 0, 1), 60), ((0x2B, 0xFF, 0xFF), 65_535 * 60),
        ((0x29, 0xFF, 0xFF, 0xFF, 0xFF), 4_294_967.295), ((0x29, 0x80, 0, 0, 0), 2_147_483.648),
    ],
)  # fmt: skip
def test_waits(bench, board, command, seconds):
    """29h to 2Bh: times are absolute numbers without a sign, up to "approximately 50 days!"."""
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append(bench.now))
    perform(bench, board, (0x0C, 1), command, (0x0B, 1))
    bench.run(seconds + 1)
    assert len(edges) == 2
    assert about(seconds, edges[1] - edges[0], 5)


@pytest.mark.parametrize("wrong", [(0x29, 0, 0, 0, 0), (0x2A, 0, 0), (0x2B, 0, 0), (0x2C, 0, 1), (0x2C, 7, 1)])
def test_waits_out_of_range_are_ignored(bench, board, wrong):
    """29h: "A time delay of zero is invalid and will be ignored"; 2Ch: a trigger "outside of the given range"."""
    perform(bench, board, wrong, (0x01, 1))
    bench.run(0.1)
    assert messages(bench, board) == ["01 01"]


@pytest.mark.parametrize("trigger", [2, 3, 4, 5])
@pytest.mark.parametrize("high", [0x00, 0x01, 0xFF])
def test_wait_for_a_level_of_a_trigger(bench, board, trigger, high):
    """2Ch: "00 means the TRIGGER bit is active at 0 volts and nonzero means it is active at +5 volts"."""
    pin = board.pins[f"trigger{trigger}"]
    pin.drive(not high)
    perform(bench, board, (0x2C, trigger, high), (0x01, 1))
    bench.run(1)
    assert messages(bench, board) == []
    pin.drive(bool(high))
    bench.run(0.004)  # "must be active for at least 4 milliseconds"
    pin.drive(not high)
    assert messages(bench, board) == ["01 01"]


@pytest.mark.parametrize("trigger", [1, 6])
@pytest.mark.parametrize("level", [0, 1])
def test_wait_for_an_edge(bench, board, trigger, level):
    """2Ch: for 1 and 6 the level is "don't care": only a low to high transition after the start of the wait ends it."""
    pin = board.pins[f"trigger{trigger}"]
    pin.drive(True)
    perform(bench, board, (0x2C, trigger, level), (0x01, 1))
    bench.run(1)
    pin.drive(False)
    assert messages(bench, board) == []
    rising(bench, board, trigger)
    assert messages(bench, board) == ["01 01"]


def test_sequence_commands_have_no_meaning_outside(bench, board):
    """20h to 2Ch: outside a sequence "it has no meaning anywhere else"; such a command does not delay later ones."""
    for command in (
        (0x20, 1, 0, 5),
        (0x21, 1),
        (0x28, 1),
        (0x29, 0, 0, 1, 0),
        (0x2A, 0, 9),
        (0x2B, 0, 9),
        (0x2C, 2, 1),
    ):
        send(bench, board, *command)
    send(bench, board, 0x01, 1)
    assert messages(bench, board) == ["01 01"]


def test_continue_without_anything_that_waits_is_ignored(bench, board):
    """48h: without anything to continue it is ignored, and not kept for later."""
    send(bench, board, 0x48)
    perform(bench, board, (0x28, 0), (0x01, 1))
    bench.run(0.5)
    assert messages(bench, board) == []


@pytest.mark.parametrize("wrong", [(0x41,), (0x41, 0), (0x41, 0x10), (0x41, 2), (0x41, 1, 1)])
def test_no_such_sequence(bench, board, wrong):
    """41h: "If a sequence buffer has not been defined this command is ignored"."""
    sequence(bench, board, 1, (0x01, 1))
    send(bench, board, *wrong, seconds=0.1)
    assert messages(bench, board) == []


def test_nothing_is_performed_between_d9_and_d8(bench, board):
    """D9h: "no commands are performed after this command ... they are considered for insertion"."""
    send_all(bench, board, (0xD9, 3), (0x0C, 1), (0x83,))
    send(bench, board, 0x0A, 9)  # out of range, so not stored
    bench.run(0.1)
    assert (messages(bench, board), board.pins["output1"].level) == ([], True)
    send(bench, board, 0xD8)
    assert listing(bench, board, 3) == ["92 0c 01", "92 83", "92 00"]
    send(bench, board, 0x41, 3)
    assert messages(bench, board) == ["83 00"]
    assert not board.pins["output1"].level


def test_listing_pads_with_zeros_and_ends_with_the_null_command(bench, board):
    """92h: "padded with zeroes to make it sixteen bytes long"; "92h followed by fifteen zeroes"."""
    definition = relative(7, 1_000, 2_000, -3)
    sequence(bench, board, 15, definition, (0x09, 2))
    send(bench, board, 0x92, 15)
    rows = messages(bench, board)
    assert rows == ["92 " + bytes(definition).hex(" "), "92 09 02", "92 00"]


def test_listing_loses_the_messages_that_wait(bench, board):
    """92h: "If there are any messages waiting in the message queue ... they will be lost"."""
    for identifier in range(1, 6):
        send(bench, board, 0x01, identifier)
    sequence(bench, board, 1, (0x09, 2))
    send(bench, board, 0x92, 1, seconds=0.1)
    assert messages(bench, board) == ["92 09 02", "92 00"]


def test_a_definition_in_a_sequence_defines_when_it_is_performed(bench, board):
    """C8h within a sequence defines the move when it is performed, not when it is stored."""
    sequence(bench, board, 1, relative(7, 10_000, 1_000_000, 40), (0x40, 7))
    send(bench, board, 0x40, 7, seconds=0.2)
    assert board.axes["motor"].pulses == 0
    send(bench, board, 0x41, 1, seconds=0.2)
    assert board.axes["motor"].pulses == 40


def test_moves_of_a_sequence_wait_for_one_another(bench, board):
    """E.2: a SINGULAR move ends before the next command: 1,000 pulses, 1,000 back, and then the message."""
    send_all(bench, board, relative(1, 10_000, 100_000, 1_000), relative(2, 10_000, 100_000, -1_000))
    perform(bench, board, (0x40, 1), (0x40, 2), (0x01, 1))
    bench.run(0.3)
    assert messages(bench, board) == []
    assert bench.run_until(lambda: board.bus.read(1) & 8, 1)
    motor = board.axes["motor"]
    assert (motor.position, len(motor.pulse_times()), motor.velocity) == (0, 2_000, 0)
    # ramps of 0.1 s, two for each move
    assert about(0.4, int(motor.pulse_times()[-1]) - int(motor.pulse_times()[0]), 25)


def test_redefining_replaces_and_deleting_removes(bench, board):
    sequence(bench, board, 1, (0x01, 1))
    sequence(bench, board, 1, (0x01, 2))
    assert listing(bench, board, 1) == ["92 01 02", "92 00"]
    send_all(bench, board, (0xDA, 1), (0x41, 1))
    assert messages(bench, board) == []


def test_a_sequence_performs_a_move_that_is_defined_afterwards(bench, board):
    """G.2: "any sequence can call on any pre-defined move"."""
    sequence(bench, board, 4, (0x40, 0x20))
    send(bench, board, *relative(0x20, 10_000, 100_000, -33))
    complete(bench, board, 0x41, 4)
    assert board.axes["motor"].position == -33


def test_waiting_for_seconds_takes_no_longer_however_often(bench, board):
    """20h with 2Ah: ten repetitions of one second take ten seconds."""
    perform(bench, board, (0x20, 1, 0, 10), (0x2A, 0, 1), (0x01, 1))
    began = bench.now
    assert bench.run_until(lambda: board.bus.read(1) & 8, 20)
    assert 10_000 * MS <= bench.now - began <= 10_050 * MS
