"""Base language 4 and 5: the motion parameters, G, S, X, O, OFF, and the letters of RMODE."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin import Bench

from .scenarios import points
from .scripts import play, scripts
from .talking import SAMPLE_NS, advance, positions, ready, send, value

FAST = "A=100*65536 V=100*65536 "
SLOW = "A=65536 V=10*65536 "


def cruise(bench, motor, mode):
    """Start a mode at 10 counts per sample; return the motor after 30 samples, 55 + 20·10 = 255 counts."""
    send(bench, motor, SLOW + mode + " G", 0)
    assert positions(bench, motor, 30)[-1] == 255


@scripts({
    # RMODE
    "5: MT, MF1, MF2, MF4, MS and MTB act at once, the others with G; RMODE reports the mode in force":
    [f"{words}RMODE RBs -> {letter} 0"
     for words, letter in (
         ("", "B"), ("MP ", "B"), ("MV ", "B"), ("MFR ", "B"), ("MSR ", "B"), ("MF0 ", "B"), ("MS0 ", "B"),
         ("BASE=8000 SIZE=8 MC ", "B"), ("MD ", "B"), ("MP P=1 G ", "P"), ("MP D=1 G ", "R"), ("MV G ", "V"),
         ("MT ", "T"), ("MT T=3 G ", "T"), ("MF1 ", "F"), ("MF2 ", "F"), ("MF4 ", "F"), ("MFR G ", "X"),
         ("MS ", "S"), ("MSR G ", "X"), ("BASE=8000 SIZE=8 MC G ", "C"), ("BASE=8000 SIZE=8 MC2 G ", "C"),
         ("BASE=8000 SIZE=8 MC4 G ", "C"), ("BASE=8000 SIZE=8 MC8 G ", "C"), ("MTB ", "B"), ("MV G MTB ", "B"),
         ("MD G ", "H"),
     )],
    "5: RMODE reports O after OFF; 5.2: after BRKRLS and OFF the mode torque brake stays inactive":
    "MV G BRKRLS OFF RMODE RBo -> O 1",
    "3, 1.3: the word is a syntax error and has no other effect":
    [f"{word} RBs RMODE RBo -> 1 B 1"
     for word in (
         "MF3", "MF8", "MS1", "MC3", "MC1", "MF", "MFRATIO", "MD50", "MP=1", "PID3", "PID=2", "PID0",
     )],
    "16: `A= V= P= G` without MP is a position move":
    f"{FAST}P=500 G RMODE -> P; 12 samples; at 500",
    # P and D
    "4: MP and G use P or D, whichever was assigned last; another G repeats a relative step":
    [f"{FAST}{words} G RMODE -> {letter}; 30 samples; at {first}; G RMODE -> {letter}; 30 samples; "
     f"at {second}"
     for words, letter, first, second in (
         ("P=100 D=7", "R", 7, 14), ("D=7 P=100", "P", 100, 100), ("P=100 D=7 P=100", "P", 100, 100),
         ("D=7 P=50 D=7", "R", 7, 14), ("D=0", "R", 0, 0), ("D=-7", "R", -7, -14), ("O=30 P=100", "P", 70, 70),
         ("O=30 D=7", "R", 7, 14), ("D=7 O=30", "R", 7, 14),
     )],
    '4: "Relative target at G = current trajectory position + D": during a move, from the position at that '
    "time":
    f"{SLOW}MP D=500 G; 30 samples; at 255; G; 120 samples; at 755",
    "p assigned without g changes nothing":
    f"{SLOW}MP P=500 G; 30 samples; at 255; P=-900 V=1 A=1 D=8 MV; 60 samples; at 500; RMODE RBt -> P 0",
    "4: after OFF and a turn by hand, the host enables with `a=@P P=a G` (as EPICS does): the shaft does not "
    "move":
    f"push 5000; 2 samples; RP MP a=@P P=a {SLOW}G -> 5000; 20 steps of 0; at 5000; RBo RBe RPE -> 0 0 0",
    "4: positions are signed 32 bit numbers, so a move from -2^31 to 2^31 - 1 is possible":
    "O=-2147483648 A=2147483647 V=2147483647 P=2147483647 G; 60 s; at 4294967295; RP -> 2147483647",
    '4: MV may pass the end of the range: "crossing ±2^31 sets Bw"':
    "O=2147483640 A=65536 V=65536 MV G; 7 samples; RP RBw -> 2147483647 0; 2 samples; "
    "RP RBw RMODE -> -2147483647 1 V; Zw RBw -> 0",
    # Changes on the fly
    "4: at G the mode changes, position and velocity do not: 10, 9, 8, 7 … counts per sample down to -2":
    f"{SLOW}MP P=10000 G; 30 samples; at 255; MV V=-2*65536; positions 265; G; "
    "positions 274 282 289 295 300 304 307 309 310 310 309 307 305 303; RV RMODE -> -131072 V",
    "Repeated S and X have no further effect; a later G moves again":
    f"{FAST}MV G; 3 samples; mark; S S X X S; 3 steps of 0; moved 0; MP P=0 G; 20 samples; at 0",
    "X decelerates; MV and G during the deceleration accelerate again":
    f"{SLOW}MV G; 30 samples; at 255; X; positions 264 272 279; MV G; positions 287 296 306 316",
    "4: O= shifts actual and commanded position together, so a move in progress ends at the same physical "
    "place":
    f"{SLOW}MP P=1000 G; 30 samples; at 255; O=0 RP RPE RV -> 0 0 655360; positions 265; 150 samples; at 1000; "
    "RP -> 745",
    "4: after OFF, Bo is 1, Bt is 0, and the position is still counted":
    f"{FAST}P=100 G; 10 samples; OFF; push 37; 2 samples; RP RBo RBt -> 137 1 0",
    # Ranges
    "With A=1 and V=1 the motor moves one count in 65536 samples":
    "A=1 V=1 P=1 G; 65535 samples; at 0; RBt RV -> 1 1; 1 sample; at 1; RBt RV -> 0 0",
    # G on pin G
    "4, UG, the default role of pin G: a falling edge acts as G; a rising edge has no effect":
    f"{FAST}P=10; G low; 20 samples; RMODE RP -> P 10; P=20; G released; 20 samples; RP -> 10; G low; "
    "20 samples; RP -> 20",
    "as an input pin g starts nothing":
    f"UGI {FAST}P=10; G low; 20 samples; RMODE RP -> B 0",
    # PIDn, CLK, WAIT
    "clk counts base samples and is writable":
    "CLK=-3; 10 samples; CLK is 7; CLK=2147483647; 1 sample; CLK is -2147483648",
    # The mode of the next G after S and X
    "The EPICS driver motorSmartMotor jogs with `MV V= G`, stops with S, moves with `D=n G` or `P=n G`, "
    "without MP. After the stop RMODE reports the mode that the next G starts, and the same mode during its "
    "move":
    [f"{SLOW}MV G; 30 samples; at 255; {stop}; 20 samples; mark; "
     f"a=@P {move} RMODE G RMODE -> {letter} {letter}; onwards {' '.join(map(str, way))}"
     for stop in ("S", "X")
     for move, letter, way in (
         ("D=20", "R", [1, 3, 6, 10, 14, 17, 19, 20, 20]), ("P=a+20", "P", [1, 3, 6, 10, 14, 17, 19, 20, 20]),
     )],
    "A host stops with X, changes V, and sends G without MV: as long as no P or D is assigned, the jog goes "
    "on. With an acceleration of one count per sample in each sample: -1, -2, -2, -2":
    [f"{SLOW}MV G; 30 samples; at 255; {stop}; 20 samples; mark; V=-2*65536 RMODE G RMODE -> V V; "
     "onwards -1 -3 -5 -7"
     for stop in ("S", "X")],
    "After `S G` the jog goes on, and P= is for the next MP":
    [f"{SLOW}MV G; 30 samples; at 255; S {between} P=7; G RMODE -> V" for between in ("MV", "G")],
    "Base 5: MT acts at once, and the buffered mode is then T, with P= as without":
    [f"{SLOW}MV G; 30 samples; at 255; {stop}; 20 samples; MT T=0 P=7 G RMODE -> T" for stop in ("S", "X")],
    'Option `stop_buffers="same"`: the next G starts the same mode again, and RMODE reports it':
    [f"with stop_buffers=same; {SLOW}{mode} G {stop}; 20 samples; RMODE G RMODE -> {letter} {letter}"
     for stop in ("S", "X")
     for mode, letter in (("MV", "V"), ("MFR", "X"), ("MSR", "X"), ("MP D=9", "R"), ("MP P=9", "P"))],
    'Option `stop_buffers="same"`: from 10 counts per sample X decelerates to 7, and G accelerates to 10 '
    "again":
    f"with stop_buffers=same; 1 sample; {SLOW}MV G; 30 samples; at 255; X; positions 264 272 279; G; "
    "positions 287 296 306 316",
    "4.1: while the motor is off, S and X do not change the buffered mode":
    [f"{SLOW}MV {stop} G RMODE -> V" for stop in ("S", "X")],
    "10.1: MD is buffered until G; after S the next G is a position move":
    f"{SLOW}MV G MD S D=1 RMODE G RMODE -> R R",
    # A real host: a brake actuator at 38400 baud
    "13: the servo holds the position: an ideal motor corrects a displacement within E in one sample":
    "MP A=65536 V=655360 P=500 G; 1.0 s; push 100; 0.001 s; at 500; RP RPE RS -> 500 0 8",
    # The mode of the next G after S and X
    "10.2: host mode is left for the buffered mode; P= after MD does not take the G from it":
    [f"{SLOW}MV G; 30 samples; at 255; {stop}; 20 samples; MD {points((0, 0), (0, 4), (0, 4))}P=7; "
     "Q => ?<01>*; G; 8 samples; RMODE -> P"
     for stop in ("S", "X")],
    # RMODE then reports the mode that the next G starts; S and X leave it as it is
    "4, 5.2: S stops at once and the servo holds; X stops at the newest A; OFF and MTB switch the servo off":
    [f"{SLOW}{mode} G; 30 samples; at 255; {word}; positions {place} {place} {place} {place}; "
     f"RMODE RBt RBo RV -> {answers}"
     for mode, letter in (("MV", "V"), ("MP P=1000", "P"))
     for word, place, answers in (
         ("S", 255, f"{letter} 0 0 0"), ("OFF", 255, "B 0 1 0"), ("MTB", 255, "B 0 1 0"), ("Z", 255, "B 0 1 0"),
         ("A=5*65536 X", 260, f"{letter} 0 0 0"),
     )],
    "1: WAIT scales with PIDn, but CLK counts base samples: 1000 samples and one statement":
    [f"load CLK=0 / WAIT=1000 / a=CLK / END; PID{n} RUN; 9000 samples; a > {1000 * n - 1}; a < {1000 * n + 2}"
     for n in (1, 2, 4, 8)],
    "16: CLK is 0 at power-up; it counts 4069 samples per second":
    "new; 5000 samples; CLK > 4998; CLK < 5001",
})  # fmt: skip
def test_modes(script):
    play(script)


# Changes on the fly


def test_from_velocity_to_position_mode_with_a_passed_target(bench, motor):
    """4: at G the motor decelerates at A, 45 counts, stops at 300, and returns to the target 255."""
    cruise(bench, motor, "MV")
    send(bench, motor, "MP P=255 G", 0)
    found = positions(bench, motor, 60)
    assert found[:10] == [264, 272, 279, 285, 290, 294, 297, 299, 300, 300] and found[-1] == 255
    assert found[10:] == sorted(found[10:], reverse=True)


def test_from_torque_to_velocity_mode(bench, motor):
    """MT acts at once, without G; a later MV takes effect at G."""
    send(bench, motor, "MT A=65536 V=2*65536", 0)
    assert send(bench, motor, "RMODE RBt MV RMODE G RMODE", 0) == b"T\r0\rT\rV\r"
    assert positions(bench, motor, 4)[-1] - motor.axes["shaft"].commanded == 0
    positions(bench, motor, 4)
    assert send(bench, motor, "RV", 0) == b"131072\r"


def test_s_at_the_very_end_of_a_move(bench, motor):
    """In the sample that reaches the target, S has nothing to stop."""
    send(bench, motor, SLOW + "P=500 G", 0)
    while motor.axes["shaft"].position < 500:
        positions(bench, motor, 1)
    assert send(bench, motor, "S RP RBt", 0) == b"500\r0\r"


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


# axis.velocity


@pytest.mark.parametrize(("rate", "shaft"), [
    (1, {}), (2, {}), (4, {}), (8, {}), (1, {"motor": "frame23"}), (2, {"motor": "frame23"})])  # fmt: skip
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
    assert send(bench, motor, "PRINT(UIA,#13,UJA,#13,UEA,#13)", 0).split()[1:] == [b"480", b"1023"]
    assert send(bench, motor, "RBs RBe", 0) == b"0\r0\r"
