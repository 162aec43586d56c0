"""Chapter Sequence buffers: definition, memory, trigger levels, and commands during a sequence."""

from ..scripts import scripts
from .programs import sequence
from .scripts import play
from .talking import ask, send


@scripts(
    {
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
    }
)  # fmt: skip
def test_sequence_buffers(bench, script):
    play(bench, script)


def test_all_sequences_share_one_memory(bench, board):
    free = int.from_bytes(ask(bench, board, 0xE2)[1:5], "big")
    assert free == 600
    for number in range(1, 16):
        sequence(bench, board, number, *[(0x08, 1)] * 21)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 0
    send(bench, board, 0xDA, 1)
    assert int.from_bytes(ask(bench, board, 0xE2)[1:5], "big") == 42
