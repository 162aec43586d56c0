"""Manual, Appendix A: 20h to 2Ch, 41h, 48h, 92h, D8h to DAh (sequences)."""

import pytest

from ..scripts import scripts
from .programs import relative, sequence
from .scripts import play
from .talking import ask, messages, send


def perform(bench, board, *commands):
    sequence(bench, board, 1, *commands)
    send(bench, board, 0x41, 1)


@scripts({
    "20h: the following X commands are repeated Y times; Y has two bytes, the most significant first":
    "relative 1 500000 at_once 3; sequence 1: 20 01 {00|00|00|01|03} {01|02|FF|00|E8}, 40 01, 01 09; 41 01; 10 s; "
    "says 01 09; at {3|6|765|768|3000}",
    '20h: "If zero is specified for either X or Y the command is ignored" (1)':
    "sequence 1: 20 {00|02} 00 {05|00}, 01 01, 01 02; 41 01; 0.1 s; says 01 01, 01 02",
    '20h: "If zero is specified for either X or Y the command is ignored" (2)':
    "sequence 1: 21 00, 01 01, 01 02; 41 01; 0.1 s; says 01 01, 01 02",
    '28h: "this command (28h) followed by fifteen zeroes"; "Other commands may be issued and performed" (1)':
    "sequence 1: 28 00, 01 01; 41 01; 1 s; says nothing; 97 -> 06; 48; 0.1 s; says 01 01",
    '28h: "this command (28h) followed by fifteen zeroes"; "Other commands may be issued and performed" (2)':
    "sequence 1: 28 {01|FF}, 01 01; 41 01; 1 s; says 28 00; 97 -> 06; 48; 0.1 s; says 01 01",
    '29h: "A time delay of zero is invalid and will be ignored"; 2Ch: a trigger "outside of the given range" (1)':
    "sequence 1: 29 00 00 00 00, 01 01; 41 01; 0.1 s; says 01 01",
    '29h: "A time delay of zero is invalid and will be ignored"; 2Ch: a trigger "outside of the given range" (2)':
    "sequence 1: {2A|2B|2C|2C} {00|00|00|07} {00|00|01|01}, 01 01; 41 01; 0.1 s; says 01 01",
    "2Ch: for 1 and 6 the level is \"don't care\": only a low to high transition during the wait ends it":
    "{trigger1|trigger1|trigger6|trigger6} high; sequence 1: 2C {01|01|06|06} {00|01|00|01}, 01 01; 41 01; 1 s; "
    "{trigger1|trigger1|trigger6|trigger6} low; says nothing; trigger {1|1|6|6}; says 01 01",
    '20h to 2Ch: outside a sequence "it has no meaning anywhere else"; such a command does not delay later ones':
    "20 01 00 05; 21 01; 28 01; 29 00 00 01 00; 2A 00 09; 2B 00 09; 2C 02 01; 01 01; says 01 01",
    "48h: without anything to continue it is ignored, and not kept for later":
    "48; sequence 1: 28 00, 01 01; 41 01; 0.5 s; says nothing",
    '41h: "If a sequence buffer has not been defined this command is ignored" (1)':
    "sequence 1: 01 01; 41; 0.1 s; says nothing",
    '41h: "If a sequence buffer has not been defined this command is ignored" (2)':
    "sequence 1: 01 01; 41 {00|10|02}; 0.1 s; says nothing",
    '41h: "If a sequence buffer has not been defined this command is ignored" (3)':
    "sequence 1: 01 01; 41 01 01; 0.1 s; says nothing",
    'D9h: "no commands are performed after this command ... they are considered for insertion"':
    "D9 03; 0C 01; 83; 0A 09; 0.1 s; says nothing; output1 is high; D8; 92 03; says 92 0C 01, 92 83, 92 00; "
    "41 03; says 83 00; output1 is low",
    '92h: "If there are any messages waiting in the message queue ... they will be lost"':
    "01 01; 01 02; 01 03; 01 04; 01 05; sequence 1: 09 02; 92 01; 0.1 s; says 92 09 02, 92 00",
    "a definition in a sequence defines when it is performed: C8h within a sequence defines the move when it is "
    "performed, not when it is stored":
    "sequence 1: relative 7 10000 1000000 40, 40 07; 40 07; 0.2 s; pulses 0; 41 01; 0.2 s; pulses 40",
    "redefining replaces and deleting removes":
    "sequence 1: 01 01; sequence 1: 01 02; 92 01; says 92 01 02, 92 00; DA 01; 41 01; says nothing",
    'G.2: "any sequence can call on any pre-defined move"':
    "sequence 4: 40 20; relative 32 10000 100000 -33; 41 04; idle; at -33",
    "20h with 2Ah: ten repetitions of one second take ten seconds":
    "sequence 1: 20 01 00 0A, 2A 00 01, 01 01; 41 01; clock; until SB & 8 is 8; 10000 to 10050 ms later",
    "nothing is performed while a sequence is defined: Requests and other commands that are not valid in a "
    "sequence are ignored while a sequence is defined":
    "default 10000 at_once; D9 01; 08 07; 90; 33 =100; 70; 41 02; DA 01; D9 02; 0.1 s; SB 50; D8; 92 01; "
    "says 92 08 07, 92 33 00 00 00 64, 92 00",
    "who is heard while a sequence is performed: Only commands that are valid concurrent with a sequence are "
    "performed: requests, but no move, sequence or 12h":
    "default 10000 at_once; sequence 1: 28 00; sequence 2: 08 07; 41 01; 33 =100; 41 02; 12 01; D9 01; 92 01; "
    "next nothing; SB 50; at 0; shutdown is low; 90 -> 50",
    "an undefined sequence or move is ignored": "41 04; sequence 5: 40 09, 08 01; 41 05; idle; SB & 7 is 1",
    "wait for a level":
    "{trigger2|trigger3|trigger4|trigger5} {low|high|low|high}; sequence 1: 2C {02|03|04|05} {01|00|01|"
    "00}, 08 01; 41 01; 1 s; {trigger2|trigger3|trigger4|trigger5} {high|low|high|low}; 0.001 s; {trigger2|"
    "trigger3|trigger4|trigger5} {low|high|low|high}; 0.1 s; SB & 1 is 0; {trigger2|trigger3|trigger4|"
    "trigger5} {high|low|high|low}; 0.005 s; SB & 1 is 1",
    # ramps of 0.1 s, two for each move
    "E.2: a SINGULAR move ends before the next command: 1,000 pulses, 1,000 back, and then the message":
    "relative 1 10000 100000 1000; relative 2 10000 100000 -1000; sequence 1: 40 01, 40 02, 01 01; 41 01; 0.3 s; "
    "says nothing; until SB & 8 is 8; at 0; steps 2000; at rest; lasts 375 to 425 ms",
    '92h: "padded with zeroes to make it sixteen bytes long"; "92h followed by fifteen zeroes"':
    "sequence 15: relative 7 1000 2000 -3, 09 02; 92 0F; "
    "says 92 C8 07 00 00 00 03 E8 00 00 07 D0 FF FF FF FD, 92 09 02, 92 00",
    '29h to 2Bh: times are absolute numbers without a sign, up to "approximately 50 days!"':
    "sequence 1: 0C 01, {29 00 00 00 01|29 00 00 01 00|29 00 01 00 00|2A 00 01|2A 01 00|2A FF FF|2B 00 01|"
    "2B FF FF|29 FF FF FF FF|29 80 00 00 00}, 0B 01; 41 01; until output1 is low; {0|0.251|65.531|0.995|255.995|"
    "65534.995|59.995|3932099.995|4294967.29|2147483.643} s; output1 is low; 0.01 s; output1 is high",
})  # fmt: skip
def test_sequences(bench, script):
    play(bench, script)


def test_the_inner_loop_is_ignored(bench, board):
    """20h: "There is no nesting of loops ... the inner loop command is ignored"."""
    perform(bench, board, (0x20, 4, 0, 2), (0x20, 1, 0, 9), (0x01, 1), (0x20, 1, 0, 9), (0x01, 2), (0x01, 3))
    bench.run(0.2)
    found = messages(bench, board)
    assert found.count("01 02") == 2 and found[-1] == "01 03"
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
    assert rounds % 100 == 0 and 600 <= rounds <= 1_100
    bench.run(1)
    assert board.axes["motor"].position == rounds


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


def test_all_sequences_share_one_memory(bench, board):
    """G.2: "up to fifteen sequence buffers", "about 600 decimal bytes long"; deleting one by DAh makes room."""
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 600
    for number in range(1, 16):
        sequence(bench, board, number, *[(0x08, 1)] * 21)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 0
    send(bench, board, 0xDA, 1)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 42
