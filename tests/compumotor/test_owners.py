"""Command attributes, SINGULAR: the host and the sequence each have a command of their own in progress."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench
from axistwin.core.units import MS

from ..scripts import scripts
from .programs import continuous, rising, sequence
from .scripts import play
from .talking import default, i32, messages, ready, send, send_all, until_idle


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


@scripts({
    '40h: "If a move is currently being performed this command is ignored"; the sequence continues (1)':
    "continuous 5 40000 1000000; 38 01 00 32 00; sequence 1: {32|32|40|39} {00|01|05|00}, 01 09; "
    "default 10000 100000; 33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; says 01 09; velocity 10000; 4 s; "
    "at 30000; at rest; 81: 0",
    '40h: "If a move is currently being performed this command is ignored"; the sequence continues (2)':
    "continuous 5 40000 1000000; 38 01 00 32 00; sequence 1: {33|34} 00 00 00 07, 01 09; default 10000 100000; "
    "33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; says 01 09; velocity 10000; 4 s; at 30000; at rest; 81: 0",
    '40h: "If a move is currently being performed this command is ignored"; the sequence continues (3)':
    "continuous 5 40000 1000000; 38 01 00 32 00; sequence 1: 11, 01 09; default 10000 100000; 33 =30000; 0.5 s; "
    "velocity 10000; 41 01; 0.05 s; says 01 09; velocity 10000; 4 s; at 30000; at rest; 81: 0",
    "a sequence goes on beside the hosts move: 20h to 2Ch in a sequence do not wait for the host's move":
    "sequence 1: 20 01 00 03, 01 01, 29 00 00 00 0A, 01 02; default 10000 100000; 33 =30000; 0.5 s; "
    "velocity 10000; 41 01; 0.05 s; says 01 01, 01 01, 01 01, 01 02; velocity 10000",
    "CEh: a continuous move can \"only\" be performed if the host's move neither accelerates nor decelerates":
    "continuous 5 20000 1000000; sequence 1: 40 05; default 10000 100000; 32 00; 0.2 s; 41 01; 0.05 s; "
    "velocity 20000",
    "79h, 7Ah: a loop of commands that take no time is killed; the host's move is completed":
    "sequence 1: 21 01, 08 01; default 10000 100000; 33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; {79|7A}; "
    "4 s; at 30000; at rest",
    "73h: \"Any singular command being performed at the time\": both the host's move and the sequence's wait":
    "sequence 1: 2B 00 3C, 01 09; default 10000 100000; 33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; 73; 5 s; "
    "velocity 10000; says 01 09",
    "7Ah: between the KILL and the CONTINUE no command begins":
    "1811 step_ms=20; relative 1 10000 100000 500; sequence 1: 40 01, 01 09; 41 01; 7A; 1 s; pulses 0; "
    "says nothing; 48; says 01 09; pulses 0",
    '72h: "Upon receipt of a CONTINUE command the next command that was to be performed ... is performed"':
    "sequence 1: 28 00, 01 01, 01 02; 41 01; 0.05 s; 72; 0.1 s; says nothing; 48; says 01 01, 01 02",
    "a continue before the suspension takes it back: 72h, and then 48h before the present command has ended: the "
    "sequence is not suspended": "sequence 1: 29 00 00 00 C8, 01 01; 41 01; 0.05 s; 72; 48; 0.3 s; says 01 01",
    "71h in a 28h leaves the sequence: 71h ends a sequence that waits in a 28h; CONTINUE does not bring it back":
    "sequence 1: 28 00, 01 01; 41 01; 0.05 s; 71; 48; says nothing; 41 01; 48; 0.05 s; 48; says 01 01",
    'The lists of these commands have no "concurrent-with-SEQUENCE-buffer-execution", so they are ignored (1)':
    "sequence 2: 01 02; sequence 1: 28 00, 01 01; 41 01; 0.05 s; 72; {41|D9|DA|92} 02; 0.05 s; says nothing; 48; "
    "says 01 01; 41 02; says 01 02; 90 -> 50",
    'The lists of these commands have no "concurrent-with-SEQUENCE-buffer-execution", so they are ignored (2)':
    "sequence 2: 01 02; sequence 1: 28 00, 01 01; 41 01; 0.05 s; 72; 50; 0.05 s; says nothing; 48; says 01 01; "
    "41 02; says 01 02; 90 -> 50",
    'The lists of these commands have no "concurrent-with-SEQUENCE-buffer-execution", so they are ignored (3)':
    "sequence 2: 01 02; sequence 1: 28 00, 01 01; 41 01; 0.05 s; 72; 51 01 04 00 00 00 00; 0.05 s; says nothing; "
    "48; says 01 01; 41 02; says 01 02; 90 -> 50",
    "singular commands about sequences are ignored during a move but 41h is not: 92h, D9h and DAh are SINGULAR "
    "and so ignored during a move; 41h is not SINGULAR":
    "sequence 2: 01 02; default 10000 100000; 33 =30000; 0.5 s; velocity 10000; {D9|DA|92} 02; 0.05 s; "
    "says nothing; 41 02; says 01 02",
    'D9h: until D8h, "if they are not valid sequence buffer commands they are ignored", e.g. 41h, 92h, D9h':
    "sequence 2: 01 02; D9 01; 41 02; 92 02; D9 03; DA 02; 48; 72; 01 01; D8; 92 01; says 92 01 01, 92 00; 92 02; "
    "says 92 01 02, 92 00",
    "CEh: a continuous move of the host is not refused by its own end":
    "cruise 10000 100000; 32 01; 1 s; velocity -10000",
    '79h, 7Ah, 7Dh, 7Eh: "Any singular command that is being performed in the sequence buffer" (1)':
    "sequence 1: 2B 00 3C, 01 09; default 10000 100000; 33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; 79; 4 s; "
    "at 30000; at rest; 48; says nothing",
    '79h, 7Ah, 7Dh, 7Eh: "Any singular command that is being performed in the sequence buffer" (2)':
    "sequence 1: 2B 00 3C, 01 09; default 10000 100000; 33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; 7A; 4 s; "
    "at 30000; at rest; 48; says 01 09",
    '79h, 7Ah, 7Dh, 7Eh: "Any singular command that is being performed in the sequence buffer" (3)':
    "sequence 1: 2B 00 3C, 01 09; default 10000 100000; 33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; "
    "7D 01 01 00; trigger 1; 4 s; at 30000; at rest; 48; says nothing",
    '79h, 7Ah, 7Dh, 7Eh: "Any singular command that is being performed in the sequence buffer" (4)':
    "sequence 1: 2B 00 3C, 01 09; default 10000 100000; 33 =30000; 0.5 s; velocity 10000; 41 01; 0.05 s; "
    "7E 01 01 00; trigger 1; 4 s; at 30000; at rest; 48; says 01 09",
})  # fmt: skip
def test_whose_command(bench, script):
    play(bench, script)


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
    assert [level for _, level in edges] == [True, False] and edges[1][0] - edges[0][0] == 10 * MS


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


# 72h, 28h, 48h, 41h, D9h, 92h together


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
