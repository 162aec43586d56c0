"""Chapter 9: mode cam."""

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import EXAMPLE, TABLE, cam, relative, start_cam, turn_through, turn_to
from .scripts import play, scripts
from .talking import SAMPLE_NS, advance, ready, send, value

FIGURE = {
    0: 0, 500: 125, 1000: 250, 2000: 500, 2500: 375, 4000: 0, 6000: 1000, 7000: 750, 8000: 500, 9000: 500, 9999: 500,
}  # fmt: skip
SECOND = {10_000 + at: 500 + position for at, position in FIGURE.items()}


# 9.3, example 2, figure 9.2


def test_there_and_back_ends_where_it_began(bench, motor):
    """9.3: the same positions in both directions, over many cycles."""
    start_cam(bench, motor)
    there = turn_through(bench, motor, list(range(-20_000, 30_001, 1000)))
    assert turn_through(bench, motor, list(range(30_000, -20_001, -1000))) == there[::-1]


# Dwell


def test_dwell_zero_overlaps_the_last_entry_with_the_first(bench, motor):
    """9.4: with D=0, at BASE counts the position is aw[SIZE], the new origin, plus aw[0]."""
    start_cam(bench, motor, dwell=0)
    assert turn_through(bench, motor, [7000, 8000, 9000, 16_000, -1000]) == [750, 500, 750, 1000, 250]
    assert [value(bench, motor, "CX")] == [7]


# The multiplier


EXAMPLE_3 = """MF4
BASE=20000 ' Will go less than 1/4 BASE in a Sample.
SIZE=5 ' SIZE is at least 4.
aw[0] 0 700 1100 2200 3300 2200. ' SIZE + 1 entries.
D=9878
F=16 ' Must be in cam relative position mode at cam initialization.
MC2 ' Set to mode cam, encoder input pulses are multiplied by 2.
G
D=9802 ' buffer new dwell.
CI ' use new dwell.
END
"""


MULTIPLIERS = ("MC", 1), ("MC2", 2), ("MC4", 4), ("MC8", 8)


@scripts({
    # 9.2, example 1, figure 9.1
    "1.1: after any number of cycles, position and counter are relative to the start of the present cycle":
    f"{cam('F=128')}; turn 1000000 by 1000: 50000; RP RCTR RBw -> 0 0 0",
    # 9.3, example 2, figure 9.2
    '9.3: "Reversing the direction of the external encoder will reverse the process": first a dwell at 0':
    f"load {EXAMPLE.format(f='F=16')}END; RUN; 0.05 s; RMODE RBs RP RCTR -> C 0 0 0; "
    "turn -1 -1999 -2000 -3000 -4000 -6000 -9000 -10000 -11000 -12000 -20000: 0 0 0 250 500 -500 -250 -500 "
    "-500 -500 -1000; RP RCTR -> -1000 -20000",
    "9.5, example 4: F=144 sets both F=16 and F=128":
    f"{cam('F=144')}; turn 8000 10000 12000 20000 26000: 500 500 1000 1000 2000; RP RCTR -> 1000 6000",
    # Absolute positions (F=0)
    '9.5: "F must be bit-wise equal to 16 or 128 for dwell to be operative"; without them the index wraps at '
    "SIZE":
    f"{cam('F=0')}; "
    "turn 0 1000 2000 6000 7000 8000 9000 14000 16000 -1000 -2000 -8000: 0 250 500 1000 750 0 250 1000 0 750 "
    "1000 0; turn 7500: 375",
    "9.4: at position 3000 with a first entry of 1 the motor attempts to move to 1, or to 3001 if F=16":
    [f"MF4 F={f} BASE=8000 SIZE=8 D=0 O=3000 aw[0] 1 250 500 250 0 500 1000 750 500. MC G; 3 samples; "
     f"@P is {position}"
     for f, position in ((0, 1), (16, 3001), (144, 3001))],
    '9.4: "the motor would immediately attempt to move": 2999 counts are more than E=1000':
    "with frame23; MF4 F=0 BASE=8000 SIZE=8 O=3000 aw[0] 1 1 1 1 1 1 1 1 1. MC G; 0.1 s; RBe RBo RMODE -> 1 1 B",
    # Dwell
    '9.4: "there is no external encoder value that will result in position aw[SIZE] exactly, unless aw[0] is '
    '0"':
    "MF4 F=16 D=0 BASE=40 SIZE=4 aw[0] 70 0 0 0 1000. MC G; turn 39 by 1: 900; turn 40 by 1: 1070; "
    "turn 39 by 1: 900",
    '9.1: "Dwell is the number of external encoder counts the motor remains at the last cam table position"':
    [f"MF4 {f} D=7 BASE=8 SIZE=8 aw[0] 0 1 2 3 4 5 6 7 100. O=0 MC G; "
     "turn 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 by 1: 0 1 2 3 4 5 6 7 100 100 100 100 100 100 100 "
     "100 101 102; "
     "turn 17 16 15 14 13 12 11 10 9 8 7 6 5 4 3 2 1 0 by 1: 102 101 100 100 100 100 100 100 100 100 7 6 "
     "5 4 3 2 1 0"
     for f in ("F=16", "F=128")],
    # CX
    "9.1: CX lets a program avoid the active area; a changed entry is used in the next pass":
    f"{cam()}; turn 1500; CX is 1; aw[6]=-32768 aw[8]=32767; at 375; turn 6000 8000 11000: -32768 32767 33017",
    # The multiplier
    # from the first crossing on D is 9802
    '9.4, example 3: "encoder input pulses are multiplied by 2": BASE is passed in 10000 counts, D in 4939':
    f"load {EXAMPLE_3}; RUN; 0.05 s; RMODE RBs -> C 0; "
    "turn 2000 4000 6000 8000 10000 14938 14939 16939: 700 1100 2200 3300 2200 2200 2200 2900; "
    "turn 24939 29840 31840: 4400 4400 5100",
    'Option cam_multiplier="table" is the other reading of MC2: it doubles positions, not BASE and D':
    f"with cam_multiplier=table; load {EXAMPLE_3}; RUN; 0.05 s; RMODE RBs -> C 0; "
    "turn 4000 8000 12000 16000 20000 29877 29878 33878: 1400 2200 4400 6600 4400 4400 4400 5800; "
    "turn 49878 59680 63680: 8800 8800 10200",
    # Speed of the master
    '9.4, example 3: "Will go less than 1/4 BASE in a Sample"':
    [f"{cam()}; turn 36000 by {per_sample}: 2500; turn -24000 by {per_sample}: -500"
     for per_sample in (1, 333, 1999)],
    "More than BASE in one sample is not allowed; the motor still executes commands, and CTR counts":
    f"{cam()}; master 10000000 in {SAMPLE_NS / 1000000000.0} s; 4 samples; RMODE RBo RCTR -> C 0 10000000",
    # With other things
    '1.2: F=128 resets the counter only in a cam, "at modulo cam BASE plus dwell"':
    "F=128 BASE=100 SIZE=4 D=0 MF4; turn 1000: 1000; RCTR RP -> 1000 1000",
    '7.1: "in the opposite direction for any given mode"; the reported positions stay those of the table':
    f"{cam('F=18')}; turn 1000 6000 12000: -250 -1000 -1000; RP RCTR -> 1000 12000",
    "MP and G during a cam at 25 counts per sample: the shaft decelerates to a stop and returns to the target":
    f"{cam()}; master 2000 in {20 * SAMPLE_NS / 1000000000.0} s; 10 samples; "
    "MP RMODE A=65536 V=65536*5 P=0 G RMODE -> C P; turn 6000; 300 samples; RP RBt RMODE -> 0 0 P",
    "5: the cam starts with G, or with G on pin G":
    "MF0 F=16 D=0 BASE=8000 SIZE=8 aw[0] 0 250 500 250 0 500 1000 750 500. MC; turn 16000 by 500: 0; MF0; "
    "G low; 20 samples; RMODE -> C; turn 17000: 250",
    "9.0: the largest table is aw[0] to aw[101]":
    f"MF4 F=16 D=0 BASE=10100 SIZE=101 aw[0] {' '.join(str(index * 10) for index in range(102))}. MC G; "
    "turn 5000 10099 10100 10200: 500 1009 1010 1020; turn 10099; CX is 100",
    # Started in the middle of a cycle (9.3, 9.4)
    '9.3: CX is "the current index … as controlled by the external encoder value"; 9.4: relative to where it '
    "is. BASE is 8000 with 8 intervals, so a cam started at 6000 counts starts at entry 6; MC2 doubles counts "
    "or the table":
    [f"with cam_multiplier={option}; MF4; turn {counts}; "
     f"BASE=8000 SIZE=8 D=0 F=16 aw[0] {' '.join(map(str, TABLE))}. O=100 {mc} G; 2 samples; CX is 6; "
     f"@P is {100 + times * TABLE[6]}"
     for option, mc, counts, times in (
         ("master", "MC", 6000, 1), ("master", "MC2", 3000, 1), ("table", "MC", 6000, 1),
         ("table", "MC2", 6000, 2),
     )],
    # 9.2, example 1, figure 9.1
    '9.2: "@P" and "RP", and CTR, are reset to zero when the encoder reaches BASE plus D; the shaft moves on':
    f"load {EXAMPLE.format(f='F=128')}END; RUN; 0.05 s; RMODE RBs RP RCTR -> C 0 0 0; "
    + "; ".join(f"turn {count}: {physical}; RP RCTR -> {FIGURE[count % 10000]} {count % 10000}; "
                f"@P is {FIGURE[count % 10000]}; CTR is {count % 10000}"
                for (count, physical) in (FIGURE | SECOND).items()),
    "Figure 9.1 from right to left: one count before zero is the end of the dwell, CTR 9999 and position 500":
    f"load {EXAMPLE.format(f='F=128')}END; RUN; 0.05 s; RMODE RBs RP RCTR -> C 0 0 0; turn 10500; "
    + "; ".join(f"turn {count}: {(FIGURE | SECOND)[count]}; "
                f"RP RCTR -> {FIGURE[count % 10000]} {count % 10000}"
                for count in (10000, 9999, 8000, 7000, 4000, 500, 0))
    + "; turn -1: 0; RP RCTR -> 500 9999; turn -3000: 250; RP RCTR -> 750 7000",
    "9.2: in every sample CTR is below BASE plus D, and the shaft moves without a jump":
    f"{cam('F=128', dwell=100)}; master 25000 in 500 samples; "
    + "; ".join("1 sample; CTR > -1; CTR < 8100" for _ in range(503))
    + "; CTR is 700; at 1675",
    # 9.3, example 2, figure 9.2
    "9.3: the second cycle begins at the last position of the first; CTR and RP are not reset":
    f"load {EXAMPLE.format(f='F=16')}END; RUN; 0.05 s; RMODE RBs RP RCTR -> C 0 0 0; "
    + "; ".join(f"turn {count}: {position}; RP RCTR -> {position} {count}"
                for (count, position) in (FIGURE | SECOND).items()),
    # CX
    '9.2: "CX contains the real-time array index of the cam table"':
    f"{cam()}; "
    + "; ".join(
        f"turn {count}; CX is {index}"
        for count, index in (
            (0, 0), (999, 0), (1000, 1), (1999, 1), (4500, 4), (7999, 7), (10_000, 0), (11_000, 1), (-2001, 7),
            (-9999, 0),
        )
    ),
    # With other things
    "9.5: MCn calculates BASE/SIZE; without an interval the cam does not start":
    [f"MF0 F=16 aw[0] 0 250 500 250 0 500 1000 750 500. {words} MC; RBs G RMODE => 1<CR>*; turn 1000: 0"
     for words in ("BASE=0 SIZE=8", "BASE=8 SIZE=0", "BASE=7 SIZE=8")],
    "9.5: MC, MC2, MC4 and MC8 multiply by 1, 2, 4 and 8, the counts or (option cam_multiplier) the positions":
    [f"{cam(mc=mc, dwell=0)}; turn {6000 // times} {8000 // times} {-2000 // times}: 1000 500 500"
     for mc, times in MULTIPLIERS]
    + [f"with cam_multiplier=table; {cam(mc=mc, dwell=0)}; turn 6000 8000 -2000: "
       f"{1000 * times} {500 * times} {500 * times}"
       for mc, times in MULTIPLIERS],
    "A frame 23 motor has the same trajectory as an ideal one, and its shaft reaches the target":
    f"with frame23; {cam()}; "
    + "; ".join(f"turn {count} by 5; commanded {place}; 0.3 s; at > {place - 3}; at < {place + 3}"
                for count, place in (FIGURE | SECOND).items())
    + "; RBe RMODE -> 0 C",
    "4: S stops the cam; after MF0, MC and G, positions are relative to the shaft's present position":
    f"{cam()}; turn 1000; S; turn 3000: 250; MF0 MC G; turn 3000 4000 9000 13000: 250 500 1250 750",
})  # fmt: skip
def test_cam(script):
    play(script)


# Speed of the master


def test_the_cam_lags_the_master_by_less_than_two_samples(bench, motor):
    """9.0: the position is based on the external encoder, which the motor reads once per sample."""
    send(bench, motor, "MF4 F=16 D=0 BASE=8000 SIZE=8 aw[0] 0 1000 2000 3000 4000 5000 6000 7000 8000. MC G", 0)
    motor.master.move(10_000, 1000 * SAMPLE_NS / 1e9)  # 10 counts per sample
    advance(bench, 10)
    for _ in range(900):
        advance(bench)
        assert 0 <= motor.master.count - motor.axes["shaft"].position <= 20
    assert send(bench, motor, "RV", 0) == b"655360\r"


# Any table, any walk


@settings(deadline=None, max_examples=12)
@given(
    table=st.lists(st.integers(-2000, 2000), min_size=5, max_size=102),
    interval=st.integers(2, 60),
    dwell=st.integers(0, 5000),
    walk=st.lists(st.integers(-20_000, 20_000), min_size=1, max_size=6),
)
def test_any_table_is_followed_in_both_directions(table, interval, dwell, walk):
    """9.3: at less than ¼ BASE per sample, entries are exact, and straight lines between them exact to the count."""
    bench, base = Bench(), interval * (len(table) - 1)
    motor = ready(bench)
    words = " ".join(map(str, table))
    send(bench, motor, f"MF4 F=16 D={dwell} BASE={base} SIZE={len(table) - 1} aw[0] {words}.", 0)
    send(bench, motor, "MC G", 0)
    for count in walk:
        position = turn_to(bench, motor, count, base // 5)
        wanted, scale = relative(count, table, base, dwell)
        assert abs(position * scale - wanted) < scale
        if wanted % scale == 0:
            assert position * scale == wanted
