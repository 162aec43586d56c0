"""Manual, Appendix A: 70h to 7Fh (stop, discontinue, suspend, kill), by command and by trigger, with messages."""

import pytest

from axistwin.core.units import MS

from ..scripts import scripts
from .programs import about, cruise, rising, sequence, steps
from .scripts import play
from .talking import ask, complete, default, i32, messages, position, send, send_all, until_idle


def by(bench, board, opcode, trigger):
    """Send a command (70h to 7Bh), or the command four opcodes higher with a trigger's edge and a message."""
    if trigger is None:
        send(bench, board, opcode)
        return
    send(bench, board, opcode + 4, trigger, 1, 1)
    rising(bench, board, trigger)
    assert messages(bench, board) == [f"{opcode + 4:02x} {trigger:02x}"]


WAYS = pytest.mark.parametrize("trigger", [None, 1, 6], ids=["command", "trigger 1", "trigger 6"])


@WAYS
def test_stop(bench, board, trigger):
    """70h, 74h: "deceleration to zero is at the most recent acceleration": from 10,000 pps in 0.1 s, 500 pulses."""
    cruise(bench, board)
    before, began = board.axes["motor"].position, bench.now
    by(bench, board, 0x70, trigger)
    until_idle(bench, board)
    last = steps(board)[-1]
    # the command takes 1 ms, the trigger's edge 3 ms more
    assert about(0.1, last - began, 12)
    assert board.axes["motor"].position - before == pytest.approx(500, abs=100)


@scripts({
    "70h: it is that of the last continuous move, 50,000 pps², not 100,000 of the first: 0.2 s, 1,000 pulses":
    "cruise 10000 100000; default 10000 50000; 32 00; 0.1 s; 70; mark; idle; moved 985 to 1015",
    '71h: "If the sequence buffer is not being performed this command has no effect"; A5h: no motion has ended':
    "A5 01; {71|72|79|7A|73|70|78}; sequence 1: 01 01, 01 02; 41 01; says 01 01, 01 02",
    '7Dh: "if TRIGGER 1 or 6 goes active when there is no sequence buffer being performed it has no effect"':
    "{75|75|76|76|7D|7D|7E|7E} {01|06|01|06|01|06|01|06} 01 00; trigger {1|6|1|6|1|6|1|6}; sequence 1: 01 01, "
    "01 02; 41 01; says 01 01, 01 02",
    "each trigger has its own function":
    "74 01 01 01; 7C 06 01 01; cruise 10000 100000; trigger 6; at rest; cruise 10000 100000; trigger 1; "
    "velocity 1 to 9999; says 7C 06, 74 01",
    'Trigger inputs: 1 and 6 "must make a low to high transition to be considered active", not a high to low':
    "7C 01 01 01; cruise 10000 100000; trigger1 high; 0.01 s; trigger1 low; 0.05 s; velocity 10000; says nothing",
    '79h ends the SINGULAR command as 73h does: "prematurely ended", so the motion continues; 70h stops it (1)':
    "relative 1 10000 100000 5000; sequence 1: 40 01, 01 01; 41 01; 0.3 s; 79; 1 s; velocity 10000; 70; idle; "
    "81: under 0; says nothing; 48; says nothing",
    '79h ends the SINGULAR command as 73h does: "prematurely ended", so the motion continues; 70h stops it (2)':
    "relative 1 10000 100000 5000; sequence 1: 40 01, 01 01; 41 01; 0.3 s; 7A; 1 s; velocity 10000; 70; idle; "
    "81: under 0; says nothing; 48; says 01 01",
    "78h: the move is ended, but the sequence continues":
    "relative 1 10000 100000 5000; sequence 1: 40 01, 01 01; 41 01; 0.2 s; 78; 0.1 s; says 01 01; at 1 to 4999",
    '71h, 72h, 75h, 76h: the current move is completed; the sequence continues at 48h only after a "suspend" (1)':
    "relative 1 10000 100000 3000; sequence 1: 40 01, 01 01; 41 01; 0.2 s; 71; idle; 1 s; at 3000; says nothing; "
    "48; says nothing; 41 01; idle; says 01 01",
    '71h, 72h, 75h, 76h: the current move is completed; the sequence continues at 48h only after a "suspend" (2)':
    "relative 1 10000 100000 3000; sequence 1: 40 01, 01 01; 41 01; 0.2 s; 72; idle; 1 s; at 3000; says nothing; "
    "48; says 01 01; 41 01; idle; says 01 01",
    '71h, 72h, 75h, 76h: the current move is completed; the sequence continues at 48h only after a "suspend" (3)':
    "relative 1 10000 100000 3000; sequence 1: 40 01, 01 01; 41 01; 0.2 s; 75 {01|06} 01 01; trigger {1|6}; "
    "says 75 {01|06}; idle; 1 s; at 3000; says nothing; 48; says nothing; 41 01; idle; says 01 01",
    '71h, 72h, 75h, 76h: the current move is completed; the sequence continues at 48h only after a "suspend" (4)':
    "relative 1 10000 100000 3000; sequence 1: 40 01, 01 01; 41 01; 0.2 s; 76 {01|06} 01 01; trigger {1|6}; "
    "says 76 {01|06}; idle; 1 s; at 3000; says nothing; 48; says 01 01; 41 01; idle; says 01 01",
    "79h, 7Ah, 7Dh, 7Eh: a wait of an hour is ended; the sequence ends too, or continues after a CONTINUE (1)":
    "sequence 1: 2B 00 3C, 01 01; 41 01; 0.1 s; 79; 0.1 s; says nothing; 48; says nothing; 48; 7200 s; "
    "says nothing",
    "79h, 7Ah, 7Dh, 7Eh: a wait of an hour is ended; the sequence ends too, or continues after a CONTINUE (2)":
    "sequence 1: 2B 00 3C, 01 01; 41 01; 0.1 s; 7A; 0.1 s; says nothing; 48; says 01 01; 48; 7200 s; says nothing",
    "79h, 7Ah, 7Dh, 7Eh: a wait of an hour is ended; the sequence ends too, or continues after a CONTINUE (3)":
    "sequence 1: 2B 00 3C, 01 01; 41 01; 0.1 s; 7D {01|06} 01 01; trigger {1|6}; says 7D {01|06}; 0.1 s; "
    "says nothing; 48; says nothing; 48; 7200 s; says nothing",
    "79h, 7Ah, 7Dh, 7Eh: a wait of an hour is ended; the sequence ends too, or continues after a CONTINUE (4)":
    "sequence 1: 2B 00 3C, 01 01; 41 01; 0.1 s; 7E {01|06} 01 01; trigger {1|6}; says 7E {01|06}; 0.1 s; "
    "says nothing; 48; says 01 01; 48; 7200 s; says nothing",
    '74h: "no other function may be specified for active TRIGGER 1 until the STOP motion function is disabled" (1)':
    "74 01 01 01; {75|76|77|7C|7D|7E} 01 01 01; cruise 10000 100000; trigger 1; says 74 01; idle; {75|76|77|7C|7D|"
    "7E} 01 00 01; cruise 10000 100000; trigger 1; says 74 01; 74 01 00 00; {75|76|77|7C|7D|7E} 01 01 01; "
    "sequence 1: 2B 00 01; idle; 41 01; trigger 1; says {75|76|77|7C|7D|7E} 01",
    '74h: "no other function may be specified for active TRIGGER 1 until the STOP motion function is disabled" (2)':
    "74 01 01 01; AC 01 01; cruise 10000 100000; trigger 1; says 74 01; idle; AC 01 00; cruise 10000 100000; "
    "trigger 1; says 74 01; 74 01 00 00; AC 01 01; sequence 1: 2B 00 01; idle; 41 01; trigger 1; says AC 01",
    "From 10,000 pps at 100,000 pps²: 49 levels of 2 ms, from 9,800 to 200 pps, are 490 pulses in 98 ms":
    "cruise 10000 100000; 70; mark; clock; 8F -> FF; until at rest; 98 ms later; moved 489 to 491",
    "events of a move":
    "default 10000 100000; A0 01; A1 01; A2 01; A3 01; A4 01; A5 01; 33 =3000; idle; says A0 00, A1 00, A2 00, "
    "A3 00, A4 00, A5 00; 33 =3000; idle; says A1 00, A3 00, A5 00; AF; 33 =3000; idle; says nothing",
    "a move that is ended before its velocity sends no A3h":
    "A3 01; default 10000 100000; 32 00; 0.05 s; 73; 1 s; says nothing",
})  # fmt: skip
def test_stop_discontinue_and_kill(bench, script):
    play(bench, script)


@WAYS
def test_kill(bench, board, trigger):
    """78h, 7Ch: "Pulses are stopped immediately, there is no deceleration"; by trigger within 200 or 400 µs."""
    cruise(bench, board)
    if trigger:
        send(bench, board, 0x7C, trigger, 1, 1)
        board.pins[f"trigger{trigger}"].drive(False)
        bench.run(0.005)
        board.pins[f"trigger{trigger}"].drive(True)
        edge = bench.now
        bench.run(0.01)
        assert max(steps(board)) <= edge + {1: 0.2, 6: 0.4}[trigger] * MS
        assert messages(bench, board) == [f"7c {trigger:02x}"]
    else:
        send(bench, board, 0x78)
        assert board.axes["motor"].velocity == 0
    assert ask(bench, board, 0x88)[1] & 0xF0 == 0


@pytest.mark.parametrize("opcode", [0x70, 0x78])
def test_a_killed_move_is_short_of_its_end(bench, board, opcode):
    """81h: "if an undershoot occurs ... the position returned is a positive number"."""
    default(bench, board, 10_000, 100_000)
    for distance in (5_000, -5_000):
        send(bench, board, 0x33, *i32(distance), seconds=0.2)
        complete(bench, board, opcode)
        done = abs(position(bench, board, 0x80))
        assert 0 < done < 5_000 and position(bench, board, 0x81) == 5_000 - done


@WAYS
def test_discontinue_a_singular_command(bench, board, trigger):
    """73h, 77h: "neither STOPPED, KILLED, nor finished"; 81h: for a move beyond its end "a negative number"."""
    default(bench, board, 10_000, 20_000)
    send(bench, board, 0x33, *i32(-8_000), seconds=0.25)
    by(bench, board, 0x73, trigger)
    velocity = board.axes["motor"].velocity
    assert -6_500 < velocity < -4_500
    bench.run(3)
    assert board.axes["motor"].velocity == velocity
    send(bench, board, 0x78)
    done = -board.axes["motor"].position
    assert done > 8_000 and position(bench, board, 0x81) == 8_000 - done
    assert position(bench, board, 0x80) == -done


ON_TRIGGER = [0x74, 0x75, 0x76, 0x77, 0x7C, 0x7D, 0x7E]


@pytest.mark.parametrize("opcode", ON_TRIGGER)
@pytest.mark.parametrize("trigger", [1, 6])
def test_messages_of_triggers(bench, board, opcode, trigger):
    """74h: the third parameter: "zero = do not send a message"; the second: "00 = disable this function".

    A sequence is waiting and a motor is running, so each function has an effect.
    """
    other = 7 - trigger
    sequence(bench, board, 1, (0x2B, 0, 1))
    for parameters, expected in (
        ((trigger, 1, 1), [f"{opcode:02x} {trigger:02x}"]), ((trigger, 0xFF, 0), []), ((trigger, 0, 1), []),
        ((trigger, 0x80, 0x80), [f"{opcode:02x} {trigger:02x}"]),
    ):  # fmt: skip
        send_all(bench, board, (0x79,), (0x78,), (0x41, 1))
        default(bench, board, 10_000, 100_000)
        send_all(bench, board, (opcode, trigger, 0, 0), (opcode, *parameters))
        rising(bench, board, other)
        assert messages(bench, board) == []
        rising(bench, board, trigger)
        assert messages(bench, board) == expected


@pytest.mark.parametrize("opcode", [*ON_TRIGGER, 0xAC])
@pytest.mark.parametrize("trigger", [0, 2, 3, 4, 5, 7, 0x81])
def test_only_triggers_one_and_six(bench, board, opcode, trigger):
    """74h: the trigger is "01 or 06"; with another one the command is ignored."""
    send(bench, board, opcode, trigger, *((1,) if opcode == 0xAC else (1, 1)))
    for number in range(1, 7):
        rising(bench, board, number)
    assert messages(bench, board) == []
