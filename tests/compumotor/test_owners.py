"""Command attributes, SINGULAR: the host and the sequence each have a command of their own in progress."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.units import MS

from .programs import continuous, relative, rising, sequence
from .talking import ask, default, i32, messages, position, ready, send, send_all, until_idle


def move(bench, board):
    """Begin the host's preset move of 30,000 pulses at 10,000 pulses/s: two ramps of 0.1 s, and 2.9 s between."""
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x33, *i32(30_000), seconds=0.5)
    assert board.axes["motor"].velocity == 10_000


def beside_a_move(bench, board, *commands):
    """Start a sequence while a move of the host is performed; it is defined before, because a move inhibits D9h."""
    sequence(bench, board, 1, *commands)
    move(bench, board)
    send(bench, board, 0x41, 1, seconds=0.05)


def in_a_sequence(bench, board, *commands):
    sequence(bench, board, 1, *commands)
    send(bench, board, 0x41, 1, seconds=0.05)


# CEh: "a continuous move can only be performed if the motor is not accelerating or decelerating AND a preset move is
# not being performed"


@pytest.mark.parametrize(
    "command", [(0x32, 0), (0x32, 1), (0x40, 5), (0x33, *i32(7)), (0x34, *i32(7)), (0x39, 0), (0x11,)]
)
def test_a_sequence_begins_no_move_while_the_hosts_is_performed(bench, board, command):
    """40h: "If a move is currently being performed this command is ignored"; the sequence continues."""
    send_all(bench, board, continuous(5, 40_000, 1_000_000), (0x38, 1, 0, 50, 0))
    beside_a_move(bench, board, command, (0x01, 9))
    assert messages(bench, board) == ["01 09"]
    assert board.axes["motor"].velocity == 10_000
    bench.run(4)
    assert (board.axes["motor"].position, board.axes["motor"].velocity) == (30_000, 0)
    assert position(bench, board, 0x81) == 0


def test_a_sequence_goes_on_beside_the_hosts_move(bench, board):
    """20h to 2Ch in a sequence do not wait for the host's move."""
    beside_a_move(bench, board, (0x20, 1, 0, 3), (0x01, 1), (0x29, 0, 0, 0, 10), (0x01, 2))
    assert messages(bench, board) == ["01 01", "01 01", "01 01", "01 02"]
    assert board.axes["motor"].velocity == 10_000


def test_a_continuous_move_may_follow_in_a_sequence_when_the_hosts_is_at_its_velocity(bench, board):
    """CEh: a continuous move can "only" be performed if the host's move neither accelerates nor decelerates."""
    send(bench, board, *continuous(5, 20_000, 1_000_000))
    sequence(bench, board, 1, (0x40, 5))
    default(bench, board, 10_000, 100_000)
    send(bench, board, 0x32, 0, seconds=0.2)
    send(bench, board, 0x41, 1, seconds=0.05)
    assert board.axes["motor"].velocity == 20_000


@pytest.mark.parametrize("trigger", [None, 1])
@pytest.mark.parametrize("opcode", [0x79, 0x7A])
def test_what_ends_the_sequences_command_leaves_the_hosts_move_alone(bench, board, opcode, trigger):
    """79h, 7Ah, 7Dh, 7Eh: "Any singular command that is being performed in the sequence buffer"."""
    beside_a_move(bench, board, (0x2B, 0, 60), (0x01, 9))
    if trigger is None:
        send(bench, board, opcode)
    else:
        send(bench, board, opcode + 4, trigger, 1, 0)
        rising(bench, board, trigger)
    bench.run(4)
    assert (board.axes["motor"].position, board.axes["motor"].velocity) == (30_000, 0)
    send(bench, board, 0x48)
    assert messages(bench, board) == (["01 09"] if opcode == 0x7A else [])


@pytest.mark.parametrize("opcode", [0x79, 0x7A])
def test_a_sequence_without_such_a_command_has_none_to_end(bench, board, opcode):
    """79h, 7Ah: a loop of commands that take no time is killed; the host's move is completed."""
    beside_a_move(bench, board, (0x21, 1), (0x08, 1))
    send(bench, board, opcode, seconds=4)
    assert (board.axes["motor"].position, board.axes["motor"].velocity) == (30_000, 0)


def test_73h_ends_any_singular_command(bench, board):
    """73h: "Any singular command being performed at the time": both the host's move and the sequence's wait."""
    beside_a_move(bench, board, (0x2B, 0, 60), (0x01, 9))
    send(bench, board, 0x73, seconds=5)
    assert board.axes["motor"].velocity == 10_000
    assert messages(bench, board) == ["01 09"]


def test_the_state_of_a_singular_command_is_that_of_both(bench, board):
    """0Fh, code 02: the bit stays set when a wait in the sequence ends, while the host's move continues."""
    send(bench, board, 0x0F, 3, 2, 1)
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append((bench.now, pin.level)))
    beside_a_move(bench, board, (0x29, 0, 0, 0, 10), (0x01, 1))
    assert [level for _, level in edges] == [True]
    until_idle(bench, board)
    assert [level for _, level in edges] == [True, False]


def test_the_state_is_set_by_a_wait_alone(bench, board):
    send(bench, board, 0x0F, 3, 2, 1)
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append((bench.now, pin.level)))
    in_a_sequence(bench, board, (0x29, 0, 0, 0, 10), (0x01, 1))
    assert [level for _, level in edges] == [True, False]
    assert edges[1][0] - edges[0][0] == 10 * MS


STEPS = st.sampled_from([
    (0x32, 0), (0x32, 1), (0x40, 5), (0x33, *i32(-50)), (0x39, 1), (0x11,), (0x20, 2, 0, 3), (0x21, 1), (0x28, 0),
    (0x29, 0, 0, 0, 40), (0x2C, 2, 0), (0x2C, 6, 1), (0x7D, 6, 1, 0), (0x7E, 1, 1, 0), (0x31, 0, 0, *i32(9), *i32(9)),
    (0x09, 1),
])  # fmt: skip
ACTS = st.sampled_from([0x48, 0x71, 0x72, 0x79, 0x7A, "trigger1", "trigger6", "trigger2"])


@settings(max_examples=20, deadline=None)
@given(st.lists(STEPS, min_size=1, max_size=6), st.lists(st.tuples(ACTS, st.integers(0, 400)), max_size=6))
def test_nothing_that_is_done_with_a_sequence_touches_the_hosts_move(steps, acts):
    """Whatever a sequence contains, and however it is suspended, killed and continued, the host's move is completed."""
    bench = Bench()
    board = ready(bench)
    send_all(bench, board, continuous(5, 40_000, 1_000_000), (0x38, 1, 0, 50, 0))
    beside_a_move(bench, board, *steps)
    for act, milliseconds in acts:
        if isinstance(act, int):
            send(bench, board, act)
        else:
            rising(bench, board, int(act[-1]))
        bench.run(milliseconds / 1000)
        if not board.axes["motor"].moving:
            break  # from here the sequence may begin moves
        assert board.axes["motor"].position <= 30_000
    for opcode in (0x79, 0x10):
        send(bench, board, opcode)
    assert bench.run_until(lambda: not board.axes["motor"].moving, 4)
    if not acts or sum(milliseconds for _, milliseconds in acts) < 2_000:
        assert board.axes["motor"].position == 30_000


# 7Ah, 7Eh


@pytest.mark.parametrize("trigger", [None, 1, 6])
@pytest.mark.parametrize("wait", [(0x28, 0), (0x2C, 2, 0), (0x29, 0, 0, 0x10, 0)])
def test_a_wait_that_is_killed_suspends_the_sequence(bench, board, wait, trigger):
    """7Ah, 7Eh: "prematurely ended. The sequence buffer is temporarily suspended until a CONTINUE"."""
    in_a_sequence(bench, board, wait, (0x01, 9))
    if trigger is None:
        send(bench, board, 0x7A)
    else:
        send(bench, board, 0x7E, trigger, 1, 0)
        rising(bench, board, trigger)
    bench.run(1)
    assert messages(bench, board) == []
    send(bench, board, 0x48)
    assert messages(bench, board) == ["01 09"]


def test_a_move_is_not_begun_when_7ah_comes_as_the_processor_turns_to_it(bench):
    """7Ah: between the KILL and the CONTINUE no command begins."""
    board = ready(bench, step_ms=20)
    send(bench, board, *relative(1, 10_000, 100_000, 500))
    sequence(bench, board, 1, (0x40, 1), (0x01, 9))
    send_all(bench, board, (0x41, 1), (0x7A,), seconds=1)
    assert board.axes["motor"].pulses == 0
    assert messages(bench, board) == []
    send(bench, board, 0x48)
    assert messages(bench, board) == ["01 09"]
    assert board.axes["motor"].pulses == 0


# 72h, 28h, 48h, 41h, D9h, 92h together


def test_one_continue_is_enough_after_72h_in_a_28h(bench, board):
    """72h: "Upon receipt of a CONTINUE command the next command that was to be performed ... is performed"."""
    in_a_sequence(bench, board, (0x28, 0), (0x01, 1), (0x01, 2))
    send(bench, board, 0x72, seconds=0.1)
    assert messages(bench, board) == []
    send(bench, board, 0x48)
    assert messages(bench, board) == ["01 01", "01 02"]


def test_a_continue_before_the_suspension_takes_it_back(bench, board):
    """72h, and then 48h before the present command has ended: the sequence is not suspended."""
    in_a_sequence(bench, board, (0x29, 0, 0, 0, 200), (0x01, 1))
    send_all(bench, board, (0x72,), (0x48,), seconds=0.3)
    assert messages(bench, board) == ["01 01"]


def test_71h_in_a_28h_leaves_the_sequence(bench, board):
    """71h ends a sequence that waits in a 28h; CONTINUE does not bring it back."""
    in_a_sequence(bench, board, (0x28, 0), (0x01, 1))
    send_all(bench, board, (0x71,), (0x48,))
    assert messages(bench, board) == []
    send_all(bench, board, (0x41, 1), (0x48,), seconds=0.05)
    send(bench, board, 0x48)
    assert messages(bench, board) == ["01 01"]


@pytest.mark.parametrize("command", [(0x41, 2), (0xD9, 2), (0xDA, 2), (0x92, 2), (0x50,), (0x51, 1, 4, 0, 0, 0, 0)])
def test_what_is_not_valid_beside_a_sequence_is_ignored_while_it_is_suspended_too(bench, board, command):
    """The lists of these commands have no "concurrent-with-SEQUENCE-buffer-execution", so they are ignored."""
    sequence(bench, board, 2, (0x01, 2))
    in_a_sequence(bench, board, (0x28, 0), (0x01, 1))
    send_all(bench, board, (0x72,), command, seconds=0.05)
    assert messages(bench, board) == []
    send(bench, board, 0x48)
    assert messages(bench, board) == ["01 01"]
    send(bench, board, 0x41, 2)
    assert messages(bench, board) == ["01 02"]
    assert ask(bench, board, 0x90)[1] == 0x50


@pytest.mark.parametrize("command", [(0xD9, 2), (0xDA, 2), (0x92, 2)])
def test_singular_commands_about_sequences_are_ignored_during_a_move_but_41h_is_not(bench, board, command):
    """92h, D9h and DAh are SINGULAR and so ignored during a move; 41h is not SINGULAR."""
    sequence(bench, board, 2, (0x01, 2))
    move(bench, board)
    send(bench, board, *command, seconds=0.05)
    assert messages(bench, board) == []
    send(bench, board, 0x41, 2)
    assert messages(bench, board) == ["01 02"]


def test_a_sequence_without_commands_is_not_performed(bench, board):
    """D9h and then D8h define a sequence without commands: 41h performs nothing, and 92h lists nothing."""
    sequence(bench, board, 3)
    send(bench, board, 0x0F, 3, 3, 1)
    edges = []
    board.pins["output1"].subscribe(lambda pin: edges.append(pin.level))
    send(bench, board, 0x41, 3, seconds=0.05)
    assert edges == []
    send(bench, board, 0x92, 3)
    assert messages(bench, board) == ["92 00"]


def test_between_d9_and_d8_neither_41h_nor_92h_nor_d9h_means_anything(bench, board):
    """D9h: until D8h, "if they are not valid sequence buffer commands they are ignored", e.g. 41h, 92h, D9h."""
    sequence(bench, board, 2, (0x01, 2))
    send(bench, board, 0xD9, 1)
    for command in ((0x41, 2), (0x92, 2), (0xD9, 3), (0xDA, 2), (0x48,), (0x72,), (0x01, 1)):
        send(bench, board, *command)
    send_all(bench, board, (0xD8,), (0x92, 1))
    assert messages(bench, board) == ["92 01 01", "92 00"]
    send(bench, board, 0x92, 2)
    assert messages(bench, board) == ["92 01 02", "92 00"]
