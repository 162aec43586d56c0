"""Sending basic move instructions: Speed.  `test_ramp.py` tests random speeds in all ranges."""

import pytest

from ..scripts import scripts
from .talking import play, ready


@pytest.mark.parametrize(
    ("range_", "asked", "runs"),
    [
        (1, 503, 500),  # "503 steps/sec in range 1 will give a final speed of 500 steps/sec"
        (1, 504, 506.25),  # "504 steps/sec will give 506.25 steps/sec"
        (1, 5400, 5400), (1, 4800, 4800),  # 864 x 6.25, 768 x 6.25
        (1, 25_000, 25_000), (1, 24_999, 25_000),
        (1, 24_997, 25_000), (1, 24_996, 24_993.75),  # 3999.52 x 6.25, 3999.36 x 6.25
        (2, 503, 500), (2, 504, 500), (2, 507, 512.5),  # 40.32 x 12.5, 40.56 x 12.5
        (2, 30_000, 30_000), (2, 50_000, 50_000),
        (3, 99_999, 100_000),  # "this will result in a speed of 100,000 steps/sec due to the 25 s/s resolution"
        (3, 99_987, 99_975), (3, 99_988, 100_000),  # 3999.48 x 25, 3999.52 x 25
        (3, 503, 500),
        (4, 503, 503), (4, 504, 504),  # "allows speeds to be set within 1 step/sec"
        (4, 3_999, 3_999), (4, 4_000, 4_000),
    ],
)  # fmt: skip
def test_the_speed_is_set_within_the_resolution_of_the_range(bench, if1, range_, asked, runs):
    """Speed: "up to the final speed within the resolution of that range"."""
    play(bench, if1, f">{range_}; X@{asked}G$; until X moving; 30 s; X runs at {runs}; K: 3; F: 0")


@scripts({
    # 500 in ranges 1 to 3, but 503 in range 4; 506.25 is possible in range 1 only
    'Default values: "Speed range 1", "Speed 400 steps/second"':
    "X100$; 1 s; X 100 pulses at 400; @503; XG$; 30 s; X runs at 500; #; @504; XG$; 1 s; X runs at 506.25",
    "R10: `@0` is out of range, and the speed is kept": "@0; K: 128; F: 16; X40$; 1 s; X 40 pulses at 400",
    "Speed: leading zeros do not count": "X0040@00250$; 1 s; X 40 pulses at 250",
    'R7: "whole message ignored", the parameters before the error included':
    "@200 >1 <9 ?; 0.05 s; K: 128; F: 8; X40$; 1 s; X 40 pulses at 400",
    'R10: "If a speed is requested which is above the maximum for that range": checked again at `$`':
    "@5000; >4; 1.2 s; F?; X100$; 0.5 s; X at 0; K: 128; F: 16; X100@4000$; 1 s; X at 100",
    'Move instructions: spaces "may be transmitted ... they will simply be ignored": even in a number':
    " X 1 0  0 @ 2 5 0 $ ; 1 s; X 100 pulses at 250; sends  <CR>; K: 0; F: 0",
    'Acceleration: "The interface will remember any programmed data unless it is overwritten"':
    "@200; X10$; Y10$; Z10$; 1 s; X 10 pulses at 200; Y 10 pulses at 200; Z 10 pulses at 200; X10@100$; 1 s; "
    "X 10 pulses at 100; Y10$; 1 s; Y 10 pulses at 100",
    'Acceleration: only "new acceleration, start/stop or speed range data" need a calculation, not a new speed':
    "@5400; E; 0.02 s; receives C<CR>",
    'Speed: "Below the start/stop speed, the speed will also be the nearest ... multiple of the speed resolution"':
    "X20@{21|22|1|2|3|4|5|6|7|8|9|10|399|394}$; 5 s; X 20 pulses at {75/4|25|25/4|25/4|25/4|25/4|25/4|25/4|25/4|"
    "25/4|25/4|25/2|400|1575/4}",
    'Speed: "above the maximum for that range, the interface will indicate a "range error" fault"':
    ">{1|2|4|1|4}; 1.1 s; @300; @{25001|50001|4001|99999|99999}; K: 128; F: 16; X30$; 1 s; X 30 pulses at 300",
    'Speed: "the range number 1 to 4"; 506.25 steps/s are possible in range 1 only':
    ">{0|5|9|11|40}; 1.1 s; K: 128; F: 16; X@504G$; 30 s; X runs at 506.25",
    "R7: a missing number is a data fault, and the message is ignored (1)":
    "{>|@|<|^|>-1|@+300|@3.5|@@300|>1,2}; 0.05 s; K: 128; F: 8; X40$; 1 s; X 40 pulses at 400",
    "R7: a missing number is a data fault, and the message is ignored (2)":
    "> <4; 0.05 s; K: 128; F: 8; X40$; 1 s; X 40 pulses at 400",
})  # fmt: skip
def test_speed_data(bench, if1, script):
    play(bench, if1, script)


@pytest.mark.parametrize("speed", ["100000", "123456", "9999999999999999999999"])
def test_more_than_five_digits_are_refused(bench, if1, speed):
    """Speed: "There is a limitation of 5 decades on the programmed speed"."""
    play(bench, if1, f">3; 1.1 s; @{speed}; K: 128; F: 8|16; X40$; 1 s; X 40 pulses at 400")


@pytest.mark.parametrize(("message", "expected"), [
    ("@200@400X10$", "10 pulses at 400"), ("X10@400@200$", "10 pulses at 200"), ("X20Y10@400$", "10 pulses at 400"),
    ("<4<8X10@800$", "10 pulses at 800"), ("<8<4X200@800$", "200 pulses from 400 to 800 by 100 at 10000"),
    ("^10^20X200@800$", "200 pulses from 400 to 800 by 100 at 20000"),
    (">2>4X10@3<1$", "10 pulses at 3"), (">4>2X10@3<1$", "10 pulses at 12.5"),
    ("B+5B-5X10@400$", "10 pulses at 400")])  # fmt: skip
def test_in_one_message_the_last_value_counts(bench, message, expected):
    """Acceleration: if one message holds the same parameter twice, the last value is used."""
    play(bench, ready(bench, recalculation_s=0.01), f"{message}; 4 s; X {expected}; F: 0")


@scripts({
    # 20 ms, not 250, before each of two characters
    "Inter-character delay: the last value of two is used": "D25D2; 0.1 s; E; 0.06 s; receives C<CR>",
    "Backlash correction: the last value of two is used": "B-20B-10X20B$; 1 s; X moves 30 -10",
    "Output switching: an output that is listed twice is switched once":
    "S11$; 0.1 s; outputs 10000; S1221$; 0.1 s; outputs 11000; S12R22$; 0.1 s; outputs 10000; F: 0",
    "Combining inputs and outputs: each stage of the format may be given once only":
    "{X5Y6X7|X5GG|X5/Y2/Z1|P1P2|H1H2X5|L1L2X5|R1R2|X5B/B}$; 0.3 s; F: 8; at 0 0 0",
    'Basic move instructions: spaces "will simply be ignored"; Index mode: "9 decades" (1)':
    "X{0005@0400|+5@400|000000005}$; 0.3 s; X 5 pulses at 400",
    'Basic move instructions: spaces "will simply be ignored"; Index mode: "9 decades" (2)':
    "X 5 @ 4 0 0 $; 0.3 s; X 5 pulses at 400",
})  # fmt: skip
def test_data_that_are_repeated(bench, if1, script):
    play(bench, if1, script)
