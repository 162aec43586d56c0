"""Decisions of docs/fidelity.md on modes, trajectories, limits and brakes, not covered by a chapter's tests."""

from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.kernel import state
from axistwin.plant.servo import FRAME17

from .rig import Rig
from .scenarios import cam, clock, points
from .scripts import play, scripts
from .talking import UNIT

LEAVE = f"Zr A={UNIT} V={-10 * UNIT} MV G"


@scripts({
    # Trajectory in progress
    '10 of the base language: "trajectory in progress": Bt is 1 while following, and 0 in torque mode':
    [f"A=1 V=1 P=9 {words} RBt RBo -> {busy} 0"
     for words, busy in (
         ("MF4", "1"), ("MS", "1"), ("MFR G", "1"), ("BASE=80 SIZE=8 MC G", "1"), ("MT T=100", "0"),
         ("MP G", "1"),
     )],
    "bt in host mode":
    f"MD {points((0, 0), (100, 100))}G; RBt -> 1",
    "5 of the base language: ENC1 selects an external encoder for the servo, which this motor does not have":
    "ENC0 RBs ENC1 RBs -> 0 1",
    # Cam
    "BASE/SIZE is 2.5: 1 count is 1/2.5 of the way to aw[1], 3 counts are 0.5/2.5 of the way from there to "
    "aw[2]":
    "MF4 F=16 D=0 BASE=10 SIZE=4 aw[0] 0 100 200 300 400. MC G; "
    "turn 0 1 2 3 4 5 6 7 8 9 10 by 1: 0 40 80 120 160 200 240 280 320 360 400",
    '9.4: "SIZE is at least 4"; a smaller SIZE also gives a cam, here a straight line of 3 counts in 10':
    "MF4 F=16 D=0 BASE=10 SIZE=1 aw[0] 0 3. MC RBs G -> *; turn 1 4 7 10 20 by 1: 0 1 2 3 6",
    "Halfway from 0 to 1 the position is 0; halfway from 0 to -1 it is -1":
    "MF4 F=16 D=0 BASE=8 SIZE=4 aw[0] 0 1 0 -1 0. MC G; turn 0 1 2 3 4 5 6 7 8 by 1: 0 0 1 0 0 -1 -1 -1 0",
    # at first 500 is aw[2]; then a crossing is found: aw[0] and one origin
    "9.4, example 3, requires less than ¼ BASE per sample. 10,000 counts in four samples make no new origin":
    f"{cam(dwell=0)}; turn 10000 by 2500: 500; turn 16000 by 1000: 500",
    # Host mode
    "10.1: the point of a clock value that goes backwards is refused with Bs; its position needs a new clock":
    f"O=0 MV V=65536 A=1 MD {points((0, 0), (10, 10), (20, 9))}{clock(20)}{clock(20)}; RBs G -> 1; 20 samples; "
    "at 20; RMODE -> V",
    "After 32 bits the clock continues at 0: the values FFFFFFF6h, 0 and 10 are 10 samples apart":
    f"O=0 MV V=65536 A=1 MD {points((0, 2 ** 32 - 10), (10, 0), (20, 10))}{clock(10)}G; 25 samples; at 25; "
    "RMODE RBs -> V 0",
    '10.2: "entering mode E, losing control"; 5.2: B while MTB is active, the default':
    [f"{words}O=0 MD {points((0, 0), (10, 10))}G; 12 samples; RMODE RBo -> {letter} 1"
     for words, letter in (("", "B"), ("BRKRLS OFF ", "E"))],
    "11 of the base language gives no number; the 33rd point overflows, and no variable changes":
    f"al[0]=5 zz=6 O=0 MD {points(*((n, n) for n in range(32)))}; RBc -> 0; {points((32, 32))}; "
    "RBc Ral[0] Rzz -> 1 5 6",
    # Limits and faults
    '3.2, note: soft limits must be disabled by SLD "before their values are changed"; otherwise Bs':
    "SLP=500 SLN=-500 SLE RBs -> 0; SLP=10 RBs Zs SLN=-10 RBs PRINT(SLP,SLN) => 1<CR>1<CR>500-500",
    '3.2: F=1 decelerates "at the acceleration value set by A"; with A=0 the motor stops at once instead':
    f"wired; F=1 A={UNIT} V={UNIT * 10} MV G; 0.05 s; A=0; 1 sample; C high; 1 sample; mark; 5 samples; "
    "moved 0; RMODE -> B",
    # Brakes
    "5.2: BRKTRJ controls MTB; if BRKRLS and OFF have disabled MTB, the servo holds after the move":
    f"BRKRLS OFF BRKTRJ A={UNIT} V={UNIT * 10} P=100 G; 0.1 s; RMODE RBo RBt -> P 0 0; brake is high",
    '5.2: "When Bt is 0, MTB will be active"; Bt is 0 in torque mode, so under BRKTRJ mode torque has no '
    "torque":
    "BRKTRJ T=320 MT; 0.1 s; RMODE RBo RP -> B 0 0; BRKSRV MT; 0.1 s; RMODE -> T",
    # Index
    "10 of the base language: until RI or I clears Bi, the mark at 300 is kept; later that at 2300 is "
    "captured":
    f"with index_at=300; A={UNIT} V={UNIT * 10} P=2400 G; 0.2 s; RBi RI RBi -> 1 300 0; P=2200 G; 0.1 s; "
    "RBi RI -> 1 2300",
    # Physics
    "UJA reads the supply in 0.1 V: a frame 23 has 48 V at rest and at its largest current":
    "with frame23; PRINT(UJA,#13) -> 480; jam; MT T=1023; 0.1 s; PRINT(UJA,#13) -> 480",
    # the motor leaves an open switch, or a switch opens during the move
    "4.1 inhibits S and X in a fault; but S and X must stop a motor that is allowed to move":
    [f"wired; {begin}; 2 samples; RBr -> 1; mark; {word}; 20 samples; moved {-rest}; RMODE RBo RBt -> V 0 0"
     for begin in (f"C released; 2 samples; {LEAVE}; 0.02 s", f"{LEAVE}; 0.02 s; C released")
     for word, rest in (("S", 0), ("X", 9 + 8 + 7 + 6 + 5 + 4 + 3 + 2 + 1))],
    "13 of the base language has typical tuning figures of a frame 23; a frame 17 needs a larger integral limit":
    [f"{motor}RKP RKI RKD RKL RKS RKV RKA RKG -> 42 28 550 {limit} 1 0 0 0"
     for motor, limit in (("", 15), ("with frame23; ", 15), ("with frame17; ", 40))],
    "An hour in air of 60 °C, then 1.5 h without power in 20 °C; without power nothing heats the motor":
    "with frame17; air 60; 3600 s; TEMP > 57; TEMP < 61; power off; air 20; 5400 s; power on; clear; TEMP > 19; "
    "TEMP < 22",
})  # fmt: skip
def test_decisions_motion(script):
    play(script)


# Physics


def test_current_is_a_magnitude_without_inductance_filtered_over_16_samples():
    """24 V · 427/1023 / 2.5 Ω are 4.007 A in the first sample: UIA reads 400/16 = 25, and in the end 400."""
    for torque in (427, -427):
        rig = Rig(FRAME17)
        machine.set_jam(rig.f, True)
        rig.i[state.MODE], rig.i[state.T] = state.M_TORQUE, torque
        rig.sample()  # this sample sets the PWM for the next sample
        rig.sample()
        assert rig.i[state.CURRENT] == 25
        for _ in range(200):
            rig.sample()
        assert rig.i[state.CURRENT] == 400
