"""Chapter 9: mode cam."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import EXAMPLE, TABLE, relative, start_cam, turn_through, turn_to
from .talking import SAMPLE_NS, advance, load, ready, send, value

FIGURE = {
    0: 0, 500: 125, 1000: 250, 2000: 500, 2500: 375, 4000: 0, 6000: 1000, 7000: 750, 8000: 500, 9000: 500, 9999: 500,
}  # fmt: skip
SECOND = {10_000 + at: 500 + position for at, position in FIGURE.items()}


def run_example(bench, motor, f):
    """Load one of the two listings, run the program, and wait until it has ended."""
    load(bench, motor, EXAMPLE.format(f=f) + "END\n")
    send(bench, motor, "RUN", 0)
    bench.run(0.05)
    assert send(bench, motor, "RMODE RBs RP RCTR", 0) == b"C\r0\r0\r0\r"


# 9.2, example 1, figure 9.1


def test_example_1_two_cycles_of_figure_9_1(bench, motor):
    """9.2: "@P" and "RP", and CTR, are reset to zero when the encoder reaches BASE plus D; the shaft moves on."""
    run_example(bench, motor, "F=128")
    for count, physical in (FIGURE | SECOND).items():
        assert turn_to(bench, motor, count) == physical
        within = count % 10_000
        assert send(bench, motor, "RP RCTR", 0) == b"%d\r%d\r" % (FIGURE[within], within)
        assert value(bench, motor, "@P") == FIGURE[within]
        assert value(bench, motor, "CTR") == within


def test_example_1_backwards_through_the_zero_point(bench, motor):
    """Figure 9.1 from right to left: one count before zero is the end of the dwell, CTR 9999 and position 500."""
    run_example(bench, motor, "F=128")
    turn_to(bench, motor, 10_500)
    for count in (10_000, 9_999, 8_000, 7_000, 4_000, 500, 0):
        assert turn_to(bench, motor, count) == (FIGURE | SECOND)[count]
        assert send(bench, motor, "RP RCTR", 0) == b"%d\r%d\r" % (FIGURE[count % 10_000], count % 10_000)
    assert turn_to(bench, motor, -1) == 0
    assert send(bench, motor, "RP RCTR", 0) == b"500\r9999\r"
    assert turn_to(bench, motor, -3_000) == 250
    assert send(bench, motor, "RP RCTR", 0) == b"750\r7000\r"


def test_cam_modulo_is_an_anti_wrap(bench, motor):
    """1.1: after any number of cycles, position and counter are relative to the start of the present cycle."""
    start_cam(bench, motor, "F=128")
    assert turn_to(bench, motor, 1_000_000, 1000) == 50_000
    assert send(bench, motor, "RP RCTR RBw", 0) == b"0\r0\r0\r"


def test_the_counter_is_reset_in_the_very_sample(bench, motor):
    """9.2: in every sample CTR is below BASE plus D, and the shaft moves without a jump."""
    start_cam(bench, motor, "F=128", dwell=100)
    motor.master.move(25_000, 500 * SAMPLE_NS / 1e9)
    for _ in range(503):
        advance(bench)
        assert 0 <= value(bench, motor, "CTR") < 8100
    assert value(bench, motor, "CTR") == 25_000 - 3 * 8100
    assert motor.axes["shaft"].position == 3 * 500 + 700 * 250 // 1000


# 9.3, example 2, figure 9.2


def test_example_2_two_cycles_of_figure_9_2(bench, motor):
    """9.3: the second cycle begins at the last position of the first; CTR and RP are not reset."""
    run_example(bench, motor, "F=16")
    for count, position in (FIGURE | SECOND).items():
        assert turn_to(bench, motor, count) == position
        assert send(bench, motor, "RP RCTR", 0) == b"%d\r%d\r" % (position, count)


def test_example_2_reversed_before_the_origin(bench, motor):
    """9.3: "Reversing the direction of the external encoder will reverse the process": first a dwell at 0."""
    run_example(bench, motor, "F=16")
    counts = [-1, -1999, -2000, -3000, -4000, -6000, -9000, -10_000, -11_000, -12_000, -20_000]
    assert turn_through(bench, motor, counts) == [0, 0, 0, 250, 500, -500, -250, -500, -500, -500, -1000]
    assert send(bench, motor, "RP RCTR", 0) == b"-1000\r-20000\r"


def test_there_and_back_ends_where_it_began(bench, motor):
    """9.3: the same positions in both directions, over many cycles."""
    start_cam(bench, motor)
    there = turn_through(bench, motor, list(range(-20_000, 30_001, 1000)))
    assert turn_through(bench, motor, list(range(30_000, -20_001, -1000))) == there[::-1]


def test_both_bits_repeat_relatively_and_avoid_the_wrap(bench, motor):
    """9.5, example 4: F=144 sets both F=16 and F=128."""
    start_cam(bench, motor, "F=144")
    assert turn_through(bench, motor, [8_000, 10_000, 12_000, 20_000, 26_000]) == [500, 500, 1000, 1000, 2000]
    assert send(bench, motor, "RP RCTR", 0) == b"1000\r6000\r"


# Absolute positions (F=0)


def test_without_16_and_128_positions_are_absolute_and_the_dwell_is_not_operative(bench, motor):
    """9.5: "F must be bit-wise equal to 16 or 128 for dwell to be operative"; without them the index wraps at SIZE."""
    start_cam(bench, motor, "F=0")
    counts = [0, 1000, 2000, 6000, 7000, 8000, 9000, 14_000, 16_000, -1000, -2000, -8000]
    expected = [0, 250, 500, 1000, 750, 0, 250, 1000, 0, 750, 1000, 0]
    assert turn_through(bench, motor, counts) == expected
    assert turn_through(bench, motor, [7500]) == [375]  # from aw[7] to aw[0]


@pytest.mark.parametrize(("f", "position"), [(0, 1), (16, 3001), (144, 3001)])
def test_f_16_is_issued_before_cam_mode_is_initialised(bench, motor, f, position):
    """9.4: at position 3000 with a first entry of 1 the motor attempts to move to 1, or to 3001 if F=16."""
    send(bench, motor, f"MF4 F={f} BASE=8000 SIZE=8 D=0 O=3000 aw[0] 1 250 500 250 0 500 1000 750 500. MC G", 0)
    advance(bench, 3)
    assert value(bench, motor, "@P") == position


def test_the_jump_to_an_absolute_table_is_a_position_error_of_a_real_motor(bench):
    """9.4: "the motor would immediately attempt to move": 2999 counts are more than E=1000."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "MF4 F=0 BASE=8000 SIZE=8 O=3000 aw[0] 1 1 1 1 1 1 1 1 1. MC G", 0)
    bench.run(0.1)
    assert send(bench, motor, "RBe RBo RMODE", 0) == b"1\r1\rB\r"


# Dwell


def test_dwell_zero_overlaps_the_last_entry_with_the_first(bench, motor):
    """9.4: with D=0, at BASE counts the position is aw[SIZE], the new origin, plus aw[0]."""
    start_cam(bench, motor, dwell=0)
    assert turn_through(bench, motor, [7000, 8000, 9000, 16_000, -1000]) == [750, 500, 750, 1000, 250]
    assert [value(bench, motor, "CX")] == [7]


def test_with_dwell_zero_no_count_results_in_the_last_position_unless_the_first_is_zero(bench, motor):
    """9.4: "there is no external encoder value that will result in position aw[SIZE] exactly, unless aw[0] is 0"."""
    send(bench, motor, "MF4 F=16 D=0 BASE=40 SIZE=4 aw[0] 70 0 0 0 1000. MC G", 0)
    assert turn_to(bench, motor, 39, 1) == 900
    assert turn_to(bench, motor, 40, 1) == 1070
    assert turn_to(bench, motor, 39, 1) == 900


@pytest.mark.parametrize("f", ["F=16", "F=128"])
def test_the_shaft_remains_at_the_last_position_for_exactly_d_counts(bench, motor, f):
    """9.1: "Dwell is the number of external encoder counts the motor remains at the last cam table position"."""
    send(bench, motor, f"MF4 {f} D=7 BASE=8 SIZE=8 aw[0] 0 1 2 3 4 5 6 7 100. O=0 MC G", 0)
    expected = [0, 1, 2, 3, 4, 5, 6, 7] + [100] * 8 + [101, 102]
    assert turn_through(bench, motor, list(range(18)), 1) == expected
    assert turn_through(bench, motor, list(range(17, -1, -1)), 1) == expected[::-1]


# CX


def test_cx_is_the_index_of_the_table_in_real_time(bench, motor):
    """9.2: "CX contains the real-time array index of the cam table"."""
    start_cam(bench, motor)
    for count, index in [
        (0, 0),
        (999, 0),
        (1000, 1),
        (1999, 1),
        (4500, 4),
        (7999, 7),
        (10_000, 0),
        (11_000, 1),
        (-2001, 7),
        (-9999, 0),
    ]:
        turn_to(bench, motor, count)
        assert value(bench, motor, "CX") == index


def test_a_table_is_changed_outside_its_active_area(bench, motor):
    """9.1: CX lets a program avoid the active area; a changed entry is used in the next pass."""
    start_cam(bench, motor)
    turn_to(bench, motor, 1500)
    assert value(bench, motor, "CX") == 1
    send(bench, motor, "aw[6]=-32768 aw[8]=32767", 0)
    assert motor.axes["shaft"].position == 375
    assert turn_through(bench, motor, [6000, 8000, 11_000]) == [-32_768, 32_767, 33_017]


# The multiplier


def test_example_3_with_the_encoder_multiplied(bench, motor):
    """9.4, example 3: "encoder input pulses are multiplied by 2": BASE is passed in 10000 counts, D in 4939."""
    example_3(bench, motor)
    counts = [2000, 4000, 6000, 8000, 10_000, 14_938, 14_939, 16_939]
    assert turn_through(bench, motor, counts) == [700, 1100, 2200, 3300, 2200, 2200, 2200, 2900]
    second = 14_939 + 10_000 + 4901  # D=9802 is in force from the first crossing on
    assert turn_through(bench, motor, [second - 4901, second, second + 2000]) == [4400, 4400, 5100]


def test_example_3_with_the_table_multiplied(bench):
    """Option cam_multiplier="table" is the other reading of MC2: it doubles positions, not BASE and D."""
    motor = ready(bench, cam_multiplier="table")
    example_3(bench, motor)
    counts = [4000, 8000, 12_000, 16_000, 20_000, 29_877, 29_878, 33_878]
    assert turn_through(bench, motor, counts) == [1400, 2200, 4400, 6600, 4400, 4400, 4400, 5800]
    second = 29_878 + 20_000 + 9802
    assert turn_through(bench, motor, [second - 9802, second, second + 4000]) == [8800, 8800, 10_200]


def example_3(bench, motor):
    """Return example 3 as printed; its last three lines take effect at the first zero crossing."""
    load(bench, motor, EXAMPLE_3)
    send(bench, motor, "RUN", 0)
    bench.run(0.05)
    assert send(bench, motor, "RMODE RBs", 0) == b"C\r0\r"


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


@pytest.mark.parametrize(("mc", "times"), [("MC", 1), ("MC2", 2), ("MC4", 4), ("MC8", 8)])
@pytest.mark.parametrize("option", ["master", "table"])
def test_each_multiplier(bench, mc, times, option):
    """9.5: MC, MC2, MC4 and MC8 multiply by 1, 2, 4 and 8."""
    motor = ready(bench, cam_multiplier=option)
    start_cam(bench, motor, mc=mc, dwell=0)
    if option == "master":
        assert turn_through(bench, motor, [6000 // times, 8000 // times, -2000 // times]) == [1000, 500, 500]
    else:
        assert turn_through(bench, motor, [6000, 8000, -2000]) == [1000 * times, 500 * times, 500 * times]


# Speed of the master


@pytest.mark.parametrize("per_sample", [1, 333, 1999])
def test_less_than_a_quarter_of_base_per_sample_is_followed(bench, motor, per_sample):
    """9.4, example 3: "Will go less than 1/4 BASE in a Sample"."""
    start_cam(bench, motor)
    assert turn_to(bench, motor, 36_000, per_sample) == 3 * 500 + 1000
    assert turn_to(bench, motor, -24_000, per_sample) == -3 * 500 + 1000


def test_a_master_beyond_all_limits_leaves_the_motor_operable(bench, motor):
    """More than BASE in one sample is not allowed; the motor still executes commands, and CTR counts."""
    start_cam(bench, motor)
    motor.master.move(10_000_000, SAMPLE_NS / 1e9)
    advance(bench, 4)
    assert send(bench, motor, "RMODE RBo RCTR", 0) == b"C\r0\r10000000\r"


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


# With other things


def test_outside_cam_mode_f_128_resets_nothing(bench, motor):
    """1.2: F=128 resets the counter only in a cam, "at modulo cam BASE plus dwell"."""
    send(bench, motor, "F=128 BASE=100 SIZE=4 D=0 MF4", 0)
    assert turn_to(bench, motor, 1000) == 1000
    assert send(bench, motor, "RCTR RP", 0) == b"1000\r1000\r"


def test_reversed_by_f_2_the_cam_runs_the_other_way(bench, motor):
    """7.1: "in the opposite direction for any given mode"; the reported positions stay those of the table."""
    start_cam(bench, motor, "F=18")
    assert turn_through(bench, motor, [1000, 6000, 12_000]) == [-250, -1000, -1000]
    assert send(bench, motor, "RP RCTR", 0) == b"1000\r12000\r"


def test_a_real_motor_follows_the_cam(bench):
    """A frame 23 motor has the same trajectory as an ideal one, and its shaft reaches the target."""
    motor = ready(bench, shaft={"motor": "frame23"})
    start_cam(bench, motor)
    for count, position in (FIGURE | SECOND).items():
        turn_to(bench, motor, count, 5)
        assert motor.axes["shaft"].commanded == position
        bench.run(0.3)
        assert abs(motor.axes["shaft"].position - position) <= 2
    assert send(bench, motor, "RBe RMODE", 0) == b"0\rC\r"


def test_the_cam_is_left_for_a_position(bench, motor):
    """MP and G during a cam at 25 counts per sample: the shaft decelerates to a stop and returns to the target."""
    start_cam(bench, motor)
    motor.master.move(2000, 20 * SAMPLE_NS / 1e9)
    advance(bench, 10)
    assert send(bench, motor, "MP RMODE A=65536 V=65536*5 P=0 G RMODE", 0) == b"C\rP\r"
    turn_to(bench, motor, 6000)
    advance(bench, 300)
    assert send(bench, motor, "RP RBt RMODE", 0) == b"0\r0\rP\r"


def test_s_holds_the_cam_and_mc_g_starts_it_again(bench, motor):
    """4: S stops the cam; after MF0, MC and G, positions are relative to the shaft's present position."""
    start_cam(bench, motor)
    turn_to(bench, motor, 1000)
    send(bench, motor, "S", 0)
    assert turn_to(bench, motor, 3000) == 250
    send(bench, motor, "MF0 MC G", 0)
    assert [turn_to(bench, motor, 3000 + at) for at in (0, 1000, 6000, 10_000)] == [250, 500, 1250, 750]


def test_g_on_pin_g_starts_the_cam(bench, motor):
    """5: the cam starts with G, or with G on pin G."""
    send(bench, motor, "MF0 F=16 D=0 BASE=8000 SIZE=8 aw[0] 0 250 500 250 0 500 1000 750 500. MC", 0)
    assert turn_to(bench, motor, 16_000, 500) == 0
    send(bench, motor, "MF0", 0)
    motor.pins["G"].drive(False)
    advance(bench, 20)
    assert send(bench, motor, "RMODE", 0) == b"C\r"
    assert turn_to(bench, motor, 17_000) == 250


@pytest.mark.parametrize("words", ["BASE=0 SIZE=8", "BASE=8 SIZE=0", "BASE=7 SIZE=8"])
def test_a_cam_without_an_interval_does_not_start(bench, motor, words):
    """9.5: MCn calculates BASE/SIZE; without an interval the cam does not start."""
    send(bench, motor, f"MF0 F=16 aw[0] 0 250 500 250 0 500 1000 750 500. {words} MC", 0)
    assert send(bench, motor, "RBs G RMODE", 0)[:2] == b"1\r"
    assert turn_to(bench, motor, 1000) == 0


def test_the_largest_table(bench, motor):
    """9.0: the largest table is aw[0] to aw[101]."""
    table = " ".join(str(index * 10) for index in range(102))
    send(bench, motor, f"MF4 F=16 D=0 BASE=10100 SIZE=101 aw[0] {table}. MC G", 0)
    assert turn_through(bench, motor, [5000, 10_099, 10_100, 10_200]) == [500, 1009, 1010, 1020]
    turn_to(bench, motor, 10_099)
    assert value(bench, motor, "CX") == 100


# Started in the middle of a cycle (9.3, 9.4)


@pytest.mark.parametrize(
    ("option", "mc", "counts", "times"),
    [("master", "MC", 6000, 1), ("master", "MC2", 3000, 1), ("table", "MC", 6000, 1), ("table", "MC2", 6000, 2)],
)
def test_the_counter_says_where_in_the_cycle_the_cam_starts(bench, option, mc, counts, times):
    """9.3: CX is "the current index … as controlled by the external encoder value"; 9.4: relative to where it is.

    BASE is 8000 with 8 intervals, so a cam started at 6000 counts starts at entry 6; MC2 doubles counts or the table.
    """
    motor = ready(bench, cam_multiplier=option)
    send(bench, motor, "MF4", 0)
    turn_to(bench, motor, counts)
    send(bench, motor, f"BASE=8000 SIZE=8 D=0 F=16 aw[0] {' '.join(map(str, TABLE))}. O=100 {mc} G", 0)
    advance(bench, 2)
    assert value(bench, motor, "CX") == 6
    assert value(bench, motor, "@P") == 100 + times * TABLE[6]
