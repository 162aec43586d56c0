"""Decisions of docs/fidelity.md on modes, trajectories, limits and brakes, not covered by a chapter's tests."""

import pytest

from axistwin.controllers.smartmotor.kernel import machine, state
from axistwin.plant import FRAME17

from .rig import Rig
from .scenarios import clock, points, start_cam, turn_through, turn_to
from .talking import UNIT, advance, ask, clear, ready, send, wired

# Trajectory in progress


@pytest.mark.parametrize(
    ("words", "busy"),
    [
        ("MF4", "1"), ("MS", "1"), ("MFR G", "1"), ("BASE=80 SIZE=8 MC G", "1"), ("MT T=100", "0"), ("MP G", "1"),
    ],
)  # fmt: skip
def test_bt_in_each_mode(bench, motor, words, busy):
    """10 of the base language: "trajectory in progress": Bt is 1 while following, and 0 in torque mode."""
    assert send(bench, motor, f"A=1 V=1 P=9 {words} RBt RBo", 0) == f"{busy}\r0\r".encode()


def test_bt_in_host_mode(bench, motor):
    send(bench, motor, "MD " + points((0, 0), (100, 100)) + "G", 0)
    assert send(bench, motor, "RBt", 0) == b"1\r"


def test_enc1_is_refused(bench, motor):
    """5 of the base language: ENC1 selects an external encoder for the servo, which this motor does not have."""
    assert send(bench, motor, "ENC0 RBs ENC1 RBs", 0) == b"0\r1\r"


# Cam


def test_base_need_not_be_a_multiple_of_size(bench, motor):
    """BASE/SIZE is 2.5: 1 count is 1/2.5 of the way to aw[1], 3 counts are 0.5/2.5 of the way from there to aw[2]."""
    send(bench, motor, "MF4 F=16 D=0 BASE=10 SIZE=4 aw[0] 0 100 200 300 400. MC G", 0)
    assert turn_through(bench, motor, list(range(11)), 1) == [0, 40, 80, 120, 160, 200, 240, 280, 320, 360, 400]


def test_a_cam_of_one_interval(bench, motor):
    """9.4: "SIZE is at least 4"; a smaller SIZE also gives a cam, here a straight line of 3 counts in 10."""
    send(bench, motor, "MF4 F=16 D=0 BASE=10 SIZE=1 aw[0] 0 3. MC RBs G", 0)
    assert turn_through(bench, motor, [1, 4, 7, 10, 20], 1) == [0, 1, 2, 3, 6]


def test_between_counts_the_cam_is_rounded_down(bench, motor):
    """Halfway from 0 to 1 the position is 0; halfway from 0 to -1 it is -1."""
    send(bench, motor, "MF4 F=16 D=0 BASE=8 SIZE=4 aw[0] 0 1 0 -1 0. MC G", 0)
    assert turn_through(bench, motor, list(range(9)), 1) == [0, 0, 1, 0, 0, -1, -1, -1, 0]


def test_a_master_that_goes_a_quarter_of_base_in_a_sample_passes_the_zero_point_unseen(bench, motor):
    """9.4, example 3, requires less than ¼ BASE per sample.  10,000 counts in four samples make no new origin."""
    start_cam(bench, motor, dwell=0)
    assert turn_to(bench, motor, 10_000, 2500) == 500  # aw[2]
    assert turn_to(bench, motor, 16_000, 1000) == 500  # this time the crossing is found: aw[0] and one origin


# Host mode


def test_a_clock_value_that_goes_backwards_is_none(bench, motor):
    """10.1: the point of a clock value that goes backwards is refused with Bs; its position needs a new clock."""
    send(bench, motor, "O=0 MV V=65536 A=1 MD " + points((0, 0), (10, 10), (20, 9)) + clock(20) + clock(20), 0)
    assert send(bench, motor, "RBs G", 0) == b"1\r"
    advance(bench, 20)
    assert motor.axes["shaft"].position == 20
    assert send(bench, motor, "RMODE", 0) == b"V\r"


def test_the_clock_of_host_mode_continues_at_0_after_32_bits(bench, motor):
    """After 32 bits the clock continues at 0: the values FFFFFFF6h, 0 and 10 are 10 samples apart."""
    send(bench, motor, "O=0 MV V=65536 A=1 MD " + points((0, 2**32 - 10), (10, 0), (20, 10)) + clock(10) + "G", 0)
    advance(bench, 25)
    assert motor.axes["shaft"].position == 25
    assert send(bench, motor, "RMODE RBs", 0) == b"V\r0\r"


@pytest.mark.parametrize(("words", "letter"), [("", "B"), ("BRKRLS OFF ", "E")])
def test_an_underflow_is_mode_e_unless_mtb_follows(bench, motor, words, letter):
    """10.2: "entering mode E, losing control"; 5.2: B while MTB is active, the default."""
    send(bench, motor, f"{words}O=0 MD " + points((0, 0), (10, 10)) + "G", 0)
    advance(bench, 12)
    assert send(bench, motor, "RMODE RBo", 0) == letter.encode() + b"\r1\r"


def test_host_mode_has_32_points_of_its_own(bench, motor):
    """11 of the base language gives no number; the 33rd point overflows, and no variable changes."""
    send(bench, motor, "al[0]=5 zz=6 O=0 MD " + points(*((n, n) for n in range(32))), 0)
    assert send(bench, motor, "RBc", 0) == b"0\r"
    send(bench, motor, points((32, 32)), 0)
    assert send(bench, motor, "RBc Ral[0] Rzz", 0) == b"1\r5\r6\r"


# Limits and faults


def test_soft_limits_refuse_new_values_while_enabled_with_bs(bench, motor):
    """3.2, note: soft limits must be disabled by SLD "before their values are changed"; otherwise Bs."""
    assert send(bench, motor, "SLP=500 SLN=-500 SLE RBs", 0) == b"0\r"
    assert send(bench, motor, "SLP=10 RBs Zs SLN=-10 RBs PRINT(SLP,SLN)", 0) == b"1\r1\r500-500"


def test_with_a_zero_the_stop_of_f_1_is_abrupt(bench):
    """3.2: F=1 decelerates "at the acceleration value set by A"; with A=0 the motor stops at once instead."""
    motor = wired(bench)
    send(bench, motor, f"F=1 A={UNIT} V={UNIT * 10} MV G", 0.05)
    send(bench, motor, "A=0", 0)
    advance(bench)
    motor.pins["C"].drive(True)
    advance(bench, 1)
    stood = motor.axes["shaft"].position
    advance(bench, 5)
    assert motor.axes["shaft"].position == stood
    assert ask(bench, motor, "RMODE") == "B"


@pytest.mark.parametrize("acknowledged", [True, False])
@pytest.mark.parametrize(("word", "rest"), [("S", 0), ("X", 9 + 8 + 7 + 6 + 5 + 4 + 3 + 2 + 1)])
def test_s_and_x_stop_a_motor_that_leaves_a_limit(bench, word, rest, acknowledged):
    """4.1 inhibits S and X in a fault; but S and X must stop a motor that is allowed to move.

    The motor leaves an open switch, or a switch opens during the move.
    """
    motor = wired(bench)
    go = f"Zr A={UNIT} V={-10 * UNIT} MV G"
    if acknowledged:
        motor.pins["C"].release()
        advance(bench, 2)
        send(bench, motor, go, 0.02)
    else:
        send(bench, motor, go, 0.02)
        motor.pins["C"].release()
    advance(bench, 2)
    assert ask(bench, motor, "RBr", 0) == "1"
    at = motor.axes["shaft"].position
    send(bench, motor, word, 0)
    advance(bench, 20)
    assert motor.axes["shaft"].position == at - rest
    assert send(bench, motor, "RMODE RBo RBt") == b"V\r0\r0\r"


# Brakes


def test_brktrj_without_mtb_lets_the_servo_hold(bench, motor):
    """5.2: BRKTRJ controls MTB; if BRKRLS and OFF have disabled MTB, the servo holds after the move."""
    send(bench, motor, f"BRKRLS OFF BRKTRJ A={UNIT} V={UNIT * 10} P=100 G", 0.1)
    assert send(bench, motor, "RMODE RBo RBt") == b"P\r0\r0\r"
    assert motor.pins["brake"].level is True


def test_mode_torque_under_brktrj_has_no_torque(bench, motor):
    """5.2: "When Bt is 0, MTB will be active"; Bt is 0 in torque mode, so under BRKTRJ mode torque has no torque."""
    send(bench, motor, "BRKTRJ T=320 MT", 0.1)
    assert send(bench, motor, "RMODE RBo RP") == b"B\r0\r0\r"
    send(bench, motor, "BRKSRV MT", 0.1)
    assert ask(bench, motor, "RMODE") == "T"


# Index


def test_one_index_is_kept_until_it_has_been_read(bench):
    """10 of the base language: until RI or I clears Bi, the mark at 300 is kept; later that at 2300 is captured."""
    motor = ready(bench, index_at=300)
    send(bench, motor, f"A={UNIT} V={UNIT * 10} P=2400 G", 0.2)
    assert send(bench, motor, "RBi RI RBi") == b"1\r300\r0\r"
    send(bench, motor, "P=2200 G", 0.1)
    assert send(bench, motor, "RBi RI") == b"1\r2300\r"


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


@pytest.mark.parametrize(("shaft", "limit"), [({}, 15), ({"motor": "frame23"}, 15), ({"motor": "frame17"}, 40)])
def test_the_factorys_tuning(bench, shaft, limit):
    """13 of the base language has typical tuning figures of a frame 23; a frame 17 needs a larger integral limit."""
    motor = ready(bench, shaft=shaft)
    answer = send(bench, motor, "RKP RKI RKD RKL RKS RKV RKA RKG")
    assert answer == b"42\r28\r550\r%d\r1\r0\r0\r0\r" % limit


def test_the_supply_voltage_does_not_sag(bench):
    """UJA reads the supply in 0.1 V: a frame 23 has 48 V at rest and at its largest current."""
    motor = ready(bench, shaft={"motor": "frame23"})
    assert ask(bench, motor, "PRINT(UJA,#13)") == "480"
    motor.axes["shaft"].jam(True)
    send(bench, motor, "MT T=1023", 0.1)
    assert ask(bench, motor, "PRINT(UJA,#13)") == "480"


def test_a_motor_cools_while_it_is_switched_off(bench):
    """The motor spends an hour in air of 60 °C, then 1.5 h without power in 20 °C; without power nothing heats it."""
    motor = ready(bench, shaft={"motor": "frame17"})
    motor.ambient = 60
    bench.run(3600)
    warm = motor.axes["shaft"].temperature
    assert 58 <= warm <= 60
    motor.power(False)
    motor.ambient = 20
    bench.run(5400)
    motor.power(True)
    clear(bench, motor)
    assert int(ask(bench, motor, "PRINT(TEMP,#13)")) in (20, 21)
