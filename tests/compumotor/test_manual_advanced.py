"""Manual, chapter Programming: E.1.a Indexer mode, G Advanced features (pre-defined moves, sequences, move zero)."""

from axistwin.core.units import MS

from ..scripts import scripts
from .programs import relative, steps
from .scripts import play
from .talking import complete, send


def test_a_move_that_is_not_calculated_is_under_way_within_half_of_thirty_milliseconds(bench, board):
    """G.1: "it can do it in less than half that time" of 30 ms."""
    send(bench, board, *relative(1, 10_000, 0x7FFF_FFFF, 100))
    asked = bench.now
    complete(bench, board, 0x40, 1)
    assert steps(board)[0] - asked <= 15 * MS + 100_000


@scripts({
    'G.1: "They will still be there when the indexer is returned to indexer mode"; sequences are lost (E.1.b)':
    "relative 9 10000 100000 700; sequence 1: 40 09; 51 01 04 00 00 00 00; 90 -> 51 01 04; 40 09; 0.5 s; "
    "pulses 0 -- inaccessible in that mode; 50; 41 01; 0.5 s; pulses 0 -- the sequence is lost; 40 09; idle; "
    "at 700",
    'G.3: 33 and 34 "are the only preset moves which may be executed while in velocity streaming mode"':
    "52 01 04 00 00 00 00 00 02; default 10000 100000; 33 =-400; idle; 34 =50; idle; 32 00; 0.5 s; at 50",
    "a continuous move goes on until killed stopped or at a limit (1)":
    "cruise 10000 100000; 20 s; velocity 10000; {70|78}; 0.2 s; at rest",
    "a continuous move goes on until killed stopped or at a limit (2)":
    "cruise 10000 100000; 20 s; velocity 10000; cw_limit high; 0.2 s; at rest",
    'E.1.a: ramps "may be respecified for each change in velocity of a constant velocity move"':
    "continuous 1 10000 100000; continuous 2 20000 1000000; continuous 3 5000 50000; 0.2 s; 40 01; clock; "
    "until velocity 10000; 92 to 108 ms later; 0.02 s; 40 02; clock; until velocity 20000; 2 to 18 ms later; "
    "0.02 s; 40 03; clock; until velocity 5000; 292 to 308 ms later; 0.02 s",
    'G.3: "Unfortunately, move zero cannot be called by the "Perform move X" command"':
    "default 10000 100000; 40 00; 0.5 s; pulses 0; 33 =400; idle; 34 =-100; idle; at -100; steps 900",
    # The acceleration and distance are lost in print. Each ramp takes 0.1 s and 13,107 pulses, the rest 0.0907 s
    "G.1: `C8 12 00 00 04 00 00` is move 12h at 262,144 pulses/second, \"+/- 0.01% of set rate\"":
    "C8 12 00 00 04 00 00 =2621440 =50000; 40 12; until 8D & FF is FF; 85 -> 00 00 04 00 00; "
    "velocity 262117.8 to 262170.2; idle; steps 50000; at 50000; lasts 286.7 to 294.7 ms",
    # Each ramp takes 0.1 s and 5,000 pulses, so 10,000 are the last triangle; 4,000 take 2·√(4,000/1,000,000) s
    "E.1.a: a move has three parts, or no constant part if its velocity is not reached; no overshoot or creeping":
    "default 100000 1000000; 33 ={25000|-25000|10000|4000}; idle; steps {25000|25000|10000|4000}; "
    "at {25000|-25000|10000|4000}; lasts {344|344|194|120.5} to {356|356|206|132.5} ms",
})  # fmt: skip
def test_moves_and_sequences(bench, script):
    play(bench, script)
