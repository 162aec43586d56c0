"""Base language 4 and 5: the motion parameters, G, S, X, O, OFF, and the letters of RMODE."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import points
from .talking import SAMPLE_NS, advance, load, positions, ready, send, value

FAST = "A=100*65536 V=100*65536 "
SLOW = "A=65536 V=10*65536 "


def cruise(bench, motor, mode):
    """Start a mode at 10 counts per sample; return the motor after 30 samples, 55 + 20·10 = 255 counts."""
    send(bench, motor, SLOW + mode + " G", 0)
    assert positions(bench, motor, 30)[-1] == 255


# RMODE


@pytest.mark.parametrize(
    ("words", "letter"),
    [
        ("", "B"), ("MP ", "B"), ("MV ", "B"), ("MFR ", "B"), ("MSR ", "B"), ("MF0 ", "B"), ("MS0 ", "B"),
        ("BASE=8000 SIZE=8 MC ", "B"), ("MD ", "B"), ("MP P=1 G ", "P"), ("MP D=1 G ", "R"), ("MV G ", "V"),
        ("MT ", "T"), ("MT T=3 G ", "T"), ("MF1 ", "F"), ("MF2 ", "F"), ("MF4 ", "F"), ("MFR G ", "X"), ("MS ", "S"),
        ("MSR G ", "X"), ("BASE=8000 SIZE=8 MC G ", "C"), ("BASE=8000 SIZE=8 MC2 G ", "C"),
        ("BASE=8000 SIZE=8 MC4 G ", "C"), ("BASE=8000 SIZE=8 MC8 G ", "C"), ("MTB ", "B"), ("MV G MTB ", "B"),
        ("MD G ", "H"),
    ],
)  # fmt: skip
def test_rmode_reports_the_mode_in_force(bench, motor, words, letter):
    """5: MT, MF1, MF2, MF4, MS and MTB act at once, the others with G; RMODE reports the mode in force."""
    assert send(bench, motor, words + "RMODE RBs", 0) == letter.encode() + b"\r0\r"


def test_off_with_the_dynamic_brake_disabled_is_o(bench, motor):
    """5: RMODE reports O after OFF; 5.2: after BRKRLS and OFF the mode torque brake stays inactive."""
    assert send(bench, motor, "MV G BRKRLS OFF RMODE RBo", 0) == b"O\r1\r"


@pytest.mark.parametrize(
    "word", ["MF3", "MF8", "MS1", "MC3", "MC1", "MF", "MFRATIO", "MD50", "MP=1", "PID3", "PID=2", "PID0"]
)
def test_modes_that_do_not_exist(bench, motor, word):
    """3, 1.3: the word is a syntax error and has no other effect."""
    assert send(bench, motor, word + " RBs RMODE RBo", 0) == b"1\rB\r1\r"


def test_the_default_mode_is_position(bench, motor):
    """16: `A= V= P= G` without MP is a position move."""
    assert send(bench, motor, FAST + "P=500 G RMODE", 0) == b"P\r"
    assert positions(bench, motor, 12)[-1] == 500


# P and D


@pytest.mark.parametrize(
    ("words", "letter", "first", "second"),
    [
        ("P=100 D=7", "R", 7, 14), ("D=7 P=100", "P", 100, 100), ("P=100 D=7 P=100", "P", 100, 100),
        ("D=7 P=50 D=7", "R", 7, 14), ("D=0", "R", 0, 0), ("D=-7", "R", -7, -14), ("O=30 P=100", "P", 70, 70),
        ("O=30 D=7", "R", 7, 14), ("D=7 O=30", "R", 7, 14),
    ],
)  # fmt: skip
def test_the_one_assigned_last_decides(bench, motor, words, letter, first, second):
    """4: MP and G use P or D, whichever was assigned last; another G repeats a relative step."""
    assert send(bench, motor, FAST + words + " G RMODE", 0) == letter.encode() + b"\r"
    assert positions(bench, motor, 30)[-1] == first
    assert send(bench, motor, "G RMODE", 0) == letter.encode() + b"\r"
    assert positions(bench, motor, 30)[-1] == second


def test_a_relative_step_starts_from_the_commanded_position(bench, motor):
    """4: "Relative target at G = current trajectory position + D": during a move, from the position at that time."""
    cruise(bench, motor, "MP D=500")
    send(bench, motor, "G", 0)
    assert positions(bench, motor, 120)[-1] == 755


def test_p_assigned_without_g_changes_nothing(bench, motor):
    cruise(bench, motor, "MP P=500")
    send(bench, motor, "P=-900 V=1 A=1 D=8 MV", 0)
    assert positions(bench, motor, 60)[-1] == 500
    assert send(bench, motor, "RMODE RBt", 0) == b"P\r0\r"


def test_a_motor_turned_by_hand_while_off_starts_from_where_it_is(bench, motor):
    """4: after OFF and a turn by hand, the host enables with `a=@P P=a G` (as EPICS does): the shaft does not move."""
    motor.axes["shaft"].encoder.displace(5000)
    advance(bench, 2)
    assert send(bench, motor, "RP MP a=@P P=a " + SLOW + "G", 0) == b"5000\r"
    assert set(positions(bench, motor, 20)) == {5000}
    assert send(bench, motor, "RBo RBe RPE", 0) == b"0\r0\r0\r"


def test_a_target_across_the_whole_range(bench, motor):
    """4: positions are signed 32 bit numbers, so a move from -2^31 to 2^31 - 1 is possible."""
    send(bench, motor, "O=-2147483648 A=2147483647 V=2147483647 P=2147483647 G", 0)
    bench.run(60)
    assert motor.axes["shaft"].position == 2**32 - 1
    assert send(bench, motor, "RP", 0) == b"2147483647\r"


def test_velocity_mode_crosses_the_wrap(bench, motor):
    """4: MV may pass the end of the range: "crossing ±2^31 sets Bw"."""
    send(bench, motor, "O=2147483640 A=65536 V=65536 MV G", 0)
    positions(bench, motor, 7)
    assert send(bench, motor, "RP RBw", 0) == b"2147483647\r0\r"
    positions(bench, motor, 2)
    assert send(bench, motor, "RP RBw RMODE", 0) == b"-2147483647\r1\rV\r"
    assert send(bench, motor, "Zw RBw", 0) == b"0\r"


# Changes on the fly


def test_from_position_to_velocity_mode(bench, motor):
    """4: at G the mode changes, position and velocity do not: 10, 9, 8, 7 … counts per sample down to -2."""
    cruise(bench, motor, "MP P=10000")
    send(bench, motor, "MV V=-2*65536", 0)
    assert positions(bench, motor, 1) == [265]
    send(bench, motor, "G", 0)
    assert positions(bench, motor, 14) == [274, 282, 289, 295, 300, 304, 307, 309, 310, 310, 309, 307, 305, 303]
    assert send(bench, motor, "RV RMODE", 0) == b"-131072\rV\r"


def test_from_velocity_to_position_mode_with_a_passed_target(bench, motor):
    """4: at G the motor decelerates at A, 45 counts, stops at 300, and returns to the target 255."""
    cruise(bench, motor, "MV")
    send(bench, motor, "MP P=255 G", 0)
    found = positions(bench, motor, 60)
    assert found[:10] == [264, 272, 279, 285, 290, 294, 297, 299, 300, 300]
    assert found[-1] == 255
    assert found[10:] == sorted(found[10:], reverse=True)


def test_from_torque_to_velocity_mode(bench, motor):
    """MT acts at once, without G; a later MV takes effect at G."""
    send(bench, motor, "MT A=65536 V=2*65536", 0)
    assert send(bench, motor, "RMODE RBt MV RMODE G RMODE", 0) == b"T\r0\rT\rV\r"
    assert positions(bench, motor, 4)[-1] - motor.axes["shaft"].commanded == 0
    positions(bench, motor, 4)
    assert send(bench, motor, "RV", 0) == b"131072\r"


@pytest.mark.parametrize(("mode", "letter"), [("MV", b"V"), ("MP P=1000", b"P")])
@pytest.mark.parametrize(
    ("word", "after", "report"),
    [
        ("S ", [255] * 4, b"\r0\r0\r0\r"),
        ("OFF ", [255] * 4, b"B\r0\r1\r0\r"),
        ("MTB ", [255] * 4, b"B\r0\r1\r0\r"),
        ("Z ", [255] * 4, b"B\r0\r1\r0\r"),
        ("A=5*65536 X ", [260, 260, 260, 260], b"\r0\r0\r0\r"),
    ],
)
def test_stopping(bench, motor, mode, letter, word, after, report):
    """4, 5.2: S stops at once and the servo holds; X stops at the newest A; OFF and MTB switch the servo off.

    RMODE reports the mode that the next G starts; S and X leave it as it is.
    """
    cruise(bench, motor, mode)
    send(bench, motor, word, 0)
    assert positions(bench, motor, 4) == after
    assert send(bench, motor, "RMODE RBt RBo RV", 0) == (report if report.startswith(b"B") else letter + report)


def test_stopping_a_motor_at_rest(bench, motor):
    """Repeated S and X have no further effect; a later G moves again."""
    send(bench, motor, FAST + "MV G", 0)
    positions(bench, motor, 3)
    here = motor.axes["shaft"].position
    send(bench, motor, "S S X X S", 0)
    assert positions(bench, motor, 3) == [here] * 3
    send(bench, motor, "MP P=0 G", 0)
    assert positions(bench, motor, 20)[-1] == 0


def test_x_and_then_g_resumes(bench, motor):
    """X decelerates; MV and G during the deceleration accelerate again."""
    cruise(bench, motor, "MV")
    send(bench, motor, "X", 0)
    assert positions(bench, motor, 3) == [264, 272, 279]
    send(bench, motor, "MV G", 0)
    assert positions(bench, motor, 4) == [287, 296, 306, 316]


def test_s_at_the_very_end_of_a_move(bench, motor):
    """In the sample that reaches the target, S has nothing to stop."""
    send(bench, motor, SLOW + "P=500 G", 0)
    while motor.axes["shaft"].position < 500:
        positions(bench, motor, 1)
    assert send(bench, motor, "S RP RBt", 0) == b"500\r0\r"


def test_o_while_moving_shifts_the_numbers_only(bench, motor):
    """4: O= shifts actual and commanded position together, so a move in progress ends at the same physical place."""
    cruise(bench, motor, "MP P=1000")
    assert send(bench, motor, "O=0 RP RPE RV", 0) == b"0\r0\r655360\r"
    assert positions(bench, motor, 1) == [265]
    assert positions(bench, motor, 150)[-1] == 1000
    assert send(bench, motor, "RP", 0) == b"745\r"


def test_off_keeps_track_of_the_position(bench, motor):
    """4: after OFF, Bo is 1, Bt is 0, and the position is still counted."""
    send(bench, motor, FAST + "P=100 G", 0)
    positions(bench, motor, 10)
    send(bench, motor, "OFF", 0)
    motor.axes["shaft"].encoder.displace(37)
    positions(bench, motor, 2)
    assert send(bench, motor, "RP RBo RBt", 0) == b"137\r1\r0\r"


# Ranges


def test_the_slowest_move(bench, motor):
    """With A=1 and V=1 the motor moves one count in 65536 samples."""
    send(bench, motor, "A=1 V=1 P=1 G", 0)
    advance(bench, 65_535)
    assert motor.axes["shaft"].position == 0
    assert send(bench, motor, "RBt RV", 0) == b"1\r1\r"
    advance(bench, 1)
    assert motor.axes["shaft"].position == 1
    assert send(bench, motor, "RBt RV", 0) == b"0\r0\r"


# G on pin G


def test_pin_g_is_a_hardware_g(bench, motor):
    """4, UG, the default role of pin G: a falling edge acts as G; a rising edge has no effect."""
    send(bench, motor, FAST + "P=10", 0)
    motor.pins["G"].drive(False)
    advance(bench, 20)
    assert send(bench, motor, "RMODE RP", 0) == b"P\r10\r"
    send(bench, motor, "P=20", 0)
    motor.pins["G"].release()
    advance(bench, 20)
    assert send(bench, motor, "RP", 0) == b"10\r"
    motor.pins["G"].drive(False)
    advance(bench, 20)
    assert send(bench, motor, "RP", 0) == b"20\r"


def test_as_an_input_pin_g_starts_nothing(bench, motor):
    send(bench, motor, "UGI " + FAST + "P=10", 0)
    motor.pins["G"].drive(False)
    advance(bench, 20)
    assert send(bench, motor, "RMODE RP", 0) == b"B\r0\r"


# PIDn, CLK, WAIT


@pytest.mark.parametrize("n", [1, 2, 4, 8])
def test_pid_runs_the_trajectory_every_nth_sample(bench, motor, n):
    """1: "V, A and WAIT scale with it": with PIDn, 10 steps of the trajectory take 10n samples (55 counts)."""
    send(bench, motor, f"PID{n} " + SLOW + "MV G", 0)
    found = positions(bench, motor, 20 * n)
    changes = [at for at, (before, after) in enumerate(pairwise(found)) if before != after]
    assert {after - before for before, after in pairwise(changes)} == {n}
    steps = [found[at + 1] - found[at] for at in changes]
    assert steps[:8] in ([2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 3, 4, 5, 6, 7, 8])
    assert send(bench, motor, "RSP", 0) == b"%d/476\r" % (24_576 * n)


@pytest.mark.parametrize("n", [1, 2, 4, 8])
def test_wait_is_in_samples_of_the_servo(bench, motor, n):
    """1: WAIT scales with PIDn, but CLK counts base samples: 1000 samples and one statement."""
    load(bench, motor, "CLK=0\nWAIT=1000\na=CLK\nEND\n")
    send(bench, motor, f"PID{n} RUN", 0)
    advance(bench, 9000)
    assert value(bench, motor, "a") in (1000 * n, 1000 * n + 1)


def test_clk_counts_base_samples_and_is_writable(bench, motor):
    send(bench, motor, "CLK=-3", 0)
    positions(bench, motor, 10)
    assert value(bench, motor, "CLK") == 7
    send(bench, motor, "CLK=2147483647", 0)
    positions(bench, motor, 1)
    assert value(bench, motor, "CLK") == -(2**31)


def test_clk_is_zero_at_power_up(bench):
    """16: CLK is 0 at power-up; it counts 4069 samples per second."""
    motor = bench.add("smartmotor", line="instant")
    bench.clock.run_to(5000 * SAMPLE_NS)
    assert value(bench, motor, "CLK") in (4999, 5000)


# Any order


WORDS = """
MP MV MT MF1 MF2 MF4 MF0 MFR MS MS0 MSR MC MC8 MD G S X OFF MTB BRKRLS BRKSRV Z F=2 F=0 PID1 PID8
A=65536 A=0 A=1 V=0 V=-65536 V=655360 P=0 P=500 D=-30 D=0 O=5 T=100 T=-1023 BASE=80 SIZE=8 MFMUL=-3 MFDIV=0 MFDIV=2
"""


@settings(deadline=None, max_examples=25)
@given(words=st.lists(st.sampled_from(WORDS.split()), max_size=20))
def test_any_order_of_commands_leaves_the_motor_operable(words):
    """After any commands the motor answers, and the result is the same in one piece and in many."""
    assert told(words, pieces=1) == told(words, pieces=5)


def told(words, pieces):
    bench = Bench()
    motor = ready(bench)
    advance(bench)
    motor.master.move(500, 0.1)
    found = []
    for word in words:
        send(bench, motor, word + "", 0)
        end = bench.now + 10 * SAMPLE_NS
        for piece in range(pieces):
            bench.clock.run_to(bench.now + (end - bench.now) // (pieces - piece))
        found.append((motor.axes["shaft"].position, motor.axes["shaft"].commanded))
    found.append(send(bench, motor, "ECHO_OFF RMODE RP RCTR RBo RBt RV", 0))
    assert found[-1].count(b"\r") == 6
    return found


# The mode of the next G after S and X


@pytest.mark.parametrize("stop", ["S", "X"])
@pytest.mark.parametrize(
    ("move", "letter", "way"),
    [("D=20", "R", [1, 3, 6, 10, 14, 17, 19, 20, 20]), ("P=a+20", "P", [1, 3, 6, 10, 14, 17, 19, 20, 20])],
)
def test_a_real_host_moves_after_a_jog_without_mp(bench, motor, stop, move, letter, way):
    """The EPICS driver motorSmartMotor jogs with `MV V= G`, stops with S, moves with `D=n G` or `P=n G`, without MP.

    After the stop RMODE reports the mode that the next G starts, and the same mode during its move.
    """
    cruise(bench, motor, "MV")
    send(bench, motor, f"{stop}", 0)
    positions(bench, motor, 20)
    zero = motor.axes["shaft"].position
    assert send(bench, motor, f"a=@P {move} RMODE G RMODE", 0) == f"{letter}\r{letter}\r".encode()
    assert [position - zero for position in positions(bench, motor, 9)] == way


@pytest.mark.parametrize("stop", ["S", "X"])
def test_another_real_host_goes_on_after_a_stop_with_another_velocity(bench, motor, stop):
    """A host stops with X, changes V, and sends G without MV: as long as no P or D is assigned, the jog goes on.

    With an acceleration of one count per sample in each sample: -1, -2, -2, -2.
    """
    cruise(bench, motor, "MV")
    send(bench, motor, stop, 0)
    positions(bench, motor, 20)
    zero = motor.axes["shaft"].position
    assert send(bench, motor, "V=-2*65536 RMODE G RMODE", 0) == b"V\rV\r"
    assert [position - zero for position in positions(bench, motor, 4)] == [-1, -3, -5, -7]


@pytest.mark.parametrize("between", ["MV", "G"])
def test_a_mode_or_g_after_a_stop_ends_its_effect_on_p_and_d(bench, motor, between):
    """After `S G` the jog goes on, and P= is for the next MP."""
    cruise(bench, motor, "MV")
    send(bench, motor, f"S {between} P=7", 0)
    assert send(bench, motor, "G RMODE", 0) == b"V\r"


@pytest.mark.parametrize("stop", ["S", "X"])
def test_mt_after_a_stop_ends_its_effect_too(bench, motor, stop):
    """Base 5: MT acts at once, and the buffered mode is then T, with P= as without."""
    cruise(bench, motor, "MV")
    send(bench, motor, stop, 0)
    positions(bench, motor, 20)
    assert send(bench, motor, "MT T=0 P=7 G RMODE", 0) == b"T\r"


@pytest.mark.parametrize("stop", ["S", "X"])
def test_p_after_a_stop_and_md_is_for_the_mode_after_host_mode(bench, motor, stop):
    """10.2: host mode is left for the buffered mode; P= after MD does not take the G from it."""
    cruise(bench, motor, "MV")
    send(bench, motor, stop, 0)
    positions(bench, motor, 20)
    send(bench, motor, "MD " + points((0, 0), (0, 4), (0, 4)) + "P=7", 0)
    assert send(bench, motor, "Q", 0)[1] == 0x01  # G pending
    send(bench, motor, "G", 0)
    positions(bench, motor, 8)
    assert send(bench, motor, "RMODE", 0) == b"P\r"


@pytest.mark.parametrize("stop", ["S", "X"])
@pytest.mark.parametrize(
    ("mode", "letter"), [("MV", "V"), ("MFR", "X"), ("MSR", "X"), ("MP D=9", "R"), ("MP P=9", "P")]
)
def test_s_and_x_may_leave_the_buffered_mode_as_it_is(bench, stop, mode, letter):
    """Option `stop_buffers="same"`: the next G starts the same mode again, and RMODE reports it."""
    motor = ready(bench, stop_buffers="same")
    send(bench, motor, SLOW + f"{mode} G {stop}", 0)
    positions(bench, motor, 20)
    assert send(bench, motor, "RMODE G RMODE", 0) == f"{letter}\r{letter}\r".encode()


def test_with_same_a_jog_resumes(bench):
    """Option `stop_buffers="same"`: from 10 counts per sample X decelerates to 7, and G accelerates to 10 again."""
    motor = ready(bench, stop_buffers="same")
    advance(bench)
    cruise(bench, motor, "MV")
    send(bench, motor, "X", 0)
    assert positions(bench, motor, 3) == [264, 272, 279]
    send(bench, motor, "G", 0)
    assert positions(bench, motor, 4) == [287, 296, 306, 316]


@pytest.mark.parametrize("stop", ["S", "X"])
def test_s_and_x_without_effect_leave_the_buffered_mode(bench, motor, stop):
    """4.1: while the motor is off, S and X do not change the buffered mode."""
    assert send(bench, motor, SLOW + f"MV {stop} G RMODE", 0) == b"V\r"


def test_s_cancels_host_mode_that_has_not_begun(bench, motor):
    """10.1: MD is buffered until G; after S the next G is a position move."""
    assert send(bench, motor, SLOW + "MV G MD S D=1 RMODE G RMODE", 0) == b"R\rR\r"


# axis.velocity


@pytest.mark.parametrize(
    ("rate", "shaft"), [(1, {}), (2, {}), (4, {}), (8, {}), (1, {"motor": "frame23"}), (2, {"motor": "frame23"})]
)
def test_velocity_is_that_of_the_motion_with_any_pid(bench, rate, shaft):
    """Base 1: V is per servo sample, of n base samples: 16 counts in each, and the velocity is never 0 between."""
    motor = ready(bench, shaft=shaft)
    send(bench, motor, f"PID{rate} A=65536 V=16*65536 MV G", 0)
    advance(bench, 2000)
    expected = 16 / (rate * SAMPLE_NS) * 1e9
    for _ in range(3 * rate):
        advance(bench)
        assert motor.axes["shaft"].velocity == pytest.approx(expected, rel=1e-9 if not shaft else 0.1)


def test_velocity_ignores_a_push(bench, motor):
    """A displacement of the shaft between two samples is not counted as velocity."""
    send(bench, motor, "PID4 A=65536*4 V=4*65536 MV G", 0)
    advance(bench, 30)
    motor.axes["shaft"].encoder.displace(1000)
    assert motor.axes["shaft"].velocity == pytest.approx(4 / (4 * SAMPLE_NS) * 1e9)


# A real host: a brake actuator at 38400 baud


def test_a_brake_actuator_changes_from_torque_to_position_and_adds_distances(bench):
    """A published driver sends MT, then `MP D=0 G`, then `D=n RW G` 20 times a second: D adds to the trajectory."""
    motor = ready(bench, shaft={"motor": "frame23"})
    send(bench, motor, "A=2000 V=2000000 MT T=60", 0)
    bench.run(0.2)
    send(bench, motor, "MP D=0 G", 0)
    bench.run(0.5)
    begin = value(bench, motor, "@P+@PE")  # the commanded position
    assert send(bench, motor, "RBe RBo RMODE", 0) == b"0\r0\rR\r"
    for number in range(1, 21):
        word = int(send(bench, motor, "D=100 RW G", 0))
        assert word & 1 == 0  # the last move has ended: the commands come every 50 ms
        bench.run(0.05)
        assert value(bench, motor, "@P+@PE") == begin + 100 * number
    answers = send(bench, motor, "PRINT(UIA,#13,UJA,#13,UEA,#13)", 0).split()
    assert answers[1:] == [b"480", b"1023"]
    assert send(bench, motor, "RBs RBe", 0) == b"0\r0\r"


def test_a_displaced_shaft_comes_back_to_where_the_servo_holds_it(bench, motor):
    """13: the servo holds the position: an ideal motor corrects a displacement within E in one sample."""
    send(bench, motor, "MP A=65536 V=655360 P=500 G", 1.0)
    motor.axes["shaft"].encoder.displace(100)
    bench.run(0.001)
    assert motor.axes["shaft"].position == 500
    assert send(bench, motor, "RP RPE RS", 0) == b"500\r0\r8\r"
