"""Servo law, protection and motors at rest (base language, chapter 13; manual, chapter 4)."""

from dataclasses import replace
from math import exp, log

import pytest

from axistwin.controllers.smartmotor.kernel import jit, servo, servo_law, state
from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.kernel.kernel import ALL_DONE
from axistwin.core.errors import UsageError
from axistwin.plant.servo import FRAME17, FRAME23, SERVO_MOTORS, ServoLoad

from .rig import Rig, Whole, tune
from .talking import SAMPLE_S

FRAMES = sorted(SERVO_MOTORS)
QUICK = replace(FRAME17, winding_time_constant_s=0.5, housing_time_constant_s=10.0)
"""Warms up as if it were much smaller."""


def tuned(**tuning):
    """Return a rig with only this tuning, with its drive on and its shaft jammed."""
    rig = Rig(FRAME23)
    names = "kp", "ki", "kd", "kl", "ks", "kv", "ka", "kg"
    tune(rig.i, [tuning.get(name, 1 if name == "ks" else 0) for name in names])
    machine.set_jam(rig.f, True)
    return rig


def pwm_of(rig, *errors):
    """Return the PWM for these following errors, one per sample."""
    found = []
    for error in errors:
        rig.i[state.COMMANDED] = error << 16
        rig.sample()
        found.append(rig.i[state.PWM])
    return found


# The servo law, with calculated values


def test_kp_is_in_sixteenths_of_a_pwm_unit_per_count():
    """KP × error / 16: 42 × 100 / 16 = 262.5 is rounded upwards; 42 × 1000 / 16 is limited to full PWM."""
    assert pwm_of(tuned(kp=42), 0, 100, -100, 1, 1000, -1000) == [0, 263, -262, 3, 1023, -1023]


def test_ki_adds_the_error_up_within_kl():
    """KI × error / 2048: 28 × 10 / 2048 = 0.1367 per sample gives 1, and 2 after 11 samples; KL=1 limits to 4."""
    pwm = pwm_of(tuned(ki=28, kl=1), *[10] * 100)
    assert (pwm[2], pwm[3], pwm[10], pwm[-1]) == (0, 1, 2, 4)
    assert pwm_of(tuned(ki=28), *[10] * 100)[-1] == 0


def test_kd_takes_the_difference_of_two_errors():
    """KD × difference / 16: 550 × 2 / 16 = 68.75."""
    assert pwm_of(tuned(kd=550), 0, 2, 4, 4) == [0, 69, 69, 0]


def test_ks_is_the_number_of_samples_between_the_two_errors():
    """With KS = 3, differences are taken in samples 0, 3, 6, 9 and held between: 550 × 3 / 16 = 103.125."""
    assert pwm_of(tuned(kd=550, ks=3), 0, 1, 2, 3, 4, 5, 6, 6, 6, 6) == [0, 0, 0, 103, 103, 103, 103, 103, 103, 0]


def test_kg_is_a_constant():
    """KG / 16: -100 / 16 = -6.25, and 160 / 16 = 10."""
    assert pwm_of(tuned(kg=-100), 0) == [-6] and pwm_of(tuned(kg=160), 0) == [10]


def test_kv_and_ka_look_ahead():
    """Velocity × KV / 16 = 2.5 × 400 / 16 = 62.5; acceleration × KA / 16 = 0.25 × 8000 / 16 = 125."""
    rig = tuned(kv=400)
    rig.i[state.VELOCITY] = 5 * 65536 // 2
    assert pwm_of(rig, 0, 0) == [63, 63]
    rig = tuned(ka=8000)
    rig.i[state.VELOCITY] = 65536 // 4
    assert pwm_of(rig, 0, 0) == [125, 0]


def test_amps_limits_everything():
    rig = tuned(kp=42)
    rig.i[state.AMPS] = 100
    assert pwm_of(rig, 1000, -1000) == [100, -100]
    rig.i[state.MODE], rig.i[state.T] = state.M_TORQUE, -700
    assert pwm_of(rig, 0) == [-100]
    rig.i[state.AMPS] = 1023
    assert pwm_of(rig, 0) == [-700]


def test_with_f_2_everything_is_the_other_way_round():
    rig = tuned(kp=42)
    rig.i[state.DIRECTION] = -1
    assert pwm_of(rig, 16) == [-42]
    rig.i[state.SHAFT], rig.i[state.ORIGIN] = 50, 60
    assert pwm_of(rig, 26) == [-42]


def test_pid4_speaks_in_every_fourth_sample():
    rig = tuned(kp=16)
    rig.i[state.PID_RATE] = 4
    assert pwm_of(rig, 1, 2, 3, 4, 5, 6) == [1, 1, 1, 1, 5, 5]


def test_the_error_has_32_bits():
    """After 2³¹ - 1 a position continues at -2³¹, that of the shaft and that of the trajectory alike."""
    rig = tuned(kp=16)
    rig.i[state.SHAFT] = 2**31 - 1
    rig.i[state.COMMANDED] = -(2**31) << 16
    assert rig.error == 1


def test_off_forgets_integral_and_difference():
    rig = tuned(ki=28, kd=550, kl=15)
    pwm_of(rig, *[10] * 50)
    rig.i[state.DRIVE] = state.DRIVE_OPEN
    assert pwm_of(rig, 10) == [0]
    rig.i[state.DRIVE] = state.DRIVE_ON
    assert pwm_of(rig, 0) == [0]


def test_the_integral_can_be_cleared():
    rig = tuned(ki=28, kl=15)
    assert pwm_of(rig, *[10] * 50)[-1] == 7
    servo_law.clear_integral(rig.i)
    assert pwm_of(rig, 0) == [0]


# The factory tuning


@pytest.mark.parametrize("gravity", [0.0, 0.3])
@pytest.mark.parametrize("inertia", [0, 1, 5])
@pytest.mark.parametrize("frame", FRAMES)
def test_a_trapezoid_settles_and_the_error_stays_small(frame, inertia, gravity):
    """Ten revolutions at 30 rev/s and 300 rev/s²; the load is 0 to 5 rotors, and a weight of 0.3 × rated torque."""
    motor = SERVO_MOTORS[frame]
    weight = -gravity * motor.torque_constant_nm_per_a * motor.continuous_current_a
    rig = Rig(motor, ServoLoad(inertia_kg_m2=inertia * motor.rotor_inertia_kg_m2, gravity_torque_nm=weight))
    errors, end = rig.trapezoid(10 * motor.counts_per_rev, 30, 300)
    assert max(map(abs, errors)) < 250 and max(abs(error) for error in errors[end + 814 :]) <= 2
    assert errors[-1] == 0


@pytest.mark.parametrize("inertia", [0, 1, 5])
@pytest.mark.parametrize("frame", FRAMES)
def test_a_step_settles(frame, inertia):
    """A step of 100 counts settles within 0.2 s."""
    motor = SERVO_MOTORS[frame]
    rig = Rig(motor, ServoLoad(inertia_kg_m2=inertia * motor.rotor_inertia_kg_m2))
    rig.i[state.COMMANDED] = 100 << 16
    errors = []
    for _ in range(4000):
        rig.sample()
        errors.append(rig.error)
    assert min(errors) > -70 and max(abs(error) for error in errors[814:]) <= 2


# Protection


def test_rms_current_beyond_the_rated_one_for_thd_samples_is_too_much():
    """4 A where 2 A are rated: the mean square over 1 s reaches 2² after ln(4/3) s; 12,000 samples later it trips."""
    rig = Rig(FRAME17)
    machine.set_jam(rig.f, True)
    rig.i[state.MODE], rig.i[state.T] = state.M_TORQUE, 427  # 24 V × 427/1023 / 2.5 Ω = 4.007 A
    assert rig.until_overload(20_000) == pytest.approx(log(4 / 3) + 12_000 * SAMPLE_S, abs=0.08)
    assert (rig.i[state.TEMP], rig.i[state.CURRENT], rig.i[state.BA]) == (25, 400, 0)


def test_a_hot_motor_is_not_ready_before_it_is_5_degrees_below_th():
    """1.98 A are 9.8 W, in the end 39.2 K above air of 50 °C.  TH=70 is exceeded at 71 °C; at 65 °C it is ready.

    The housing has 2.5 J/K, the winding 0.33 J/K, both at 25 °C at first.
    """
    rig = Rig(QUICK)
    machine.set_ambient(rig.i, rig.f, 50.0)
    machine.set_jam(rig.f, True)
    rig.i[state.THD] = 100
    rig.i[state.MODE], rig.i[state.T] = state.M_TORQUE, 212  # 1.99 A
    assert rig.until_overload(200_000) == pytest.approx(11.33 * log(64.2 / 18.2), rel=0.05) and rig.i[state.TEMP] == 71
    machine.set_ambient(rig.i, rig.f, 35.0)
    rig.i[state.DRIVE] = state.DRIVE_OPEN
    while rig.sample():
        assert rig.i[state.TEMP] > 65
    assert rig.i[state.TEMP] == 65


def test_the_rated_current_at_25_degrees_never_is_too_much():
    """10 W through 4 K/W give 65 °C, below TH even if the motor is jammed for days."""
    rig = Rig(QUICK)
    machine.set_jam(rig.f, True)
    rig.i[state.MODE], rig.i[state.T] = state.M_TORQUE, 212
    for _ in range(2000):
        rig.sample()
    assert rig.resting
    rig.rest(100_000_000)
    assert rig.i[state.TEMP] == 64  # 1.99 A
    assert rig.f[machine.HOUSING_C] == pytest.approx(25 + 1.98**2 * 2.5 * 4, abs=0.5)
    assert rig.f[machine.WINDING_C] == pytest.approx(25 + 1.98**2 * 2.5 * 5.5, abs=0.6) and not rig.sample()


# Rest


@pytest.mark.parametrize("samples", [1, 255, 256, 257, 5000])
def test_a_holding_motor_can_rest(samples):
    """One step of rest gives the same result as all its samples, for a motor that holds a weight after a move."""
    rigs = []
    for _ in range(2):
        rig = Rig(FRAME23, ServoLoad(gravity_torque_nm=-0.1))
        rig.trapezoid(3000, 30, 300)
        assert rig.resting
        rigs.append(rig)
    one, other = rigs
    one.rest(samples)
    for _ in range(samples):
        other.sample()
    assert (one.i, one.f) == (other.i, other.f) and one.i[state.PWM] != 0


def test_rest_takes_no_time_in_a_steady_state():
    """One step while the motor cools down gives exactly the temperatures of a calculation sample by sample."""
    cold = Rig(replace(QUICK, winding_time_constant_s=0.01, housing_time_constant_s=0.2))
    cold.i[state.DRIVE] = state.DRIVE_SHORTED
    machine.set_ambient(cold.i, cold.f, -20.0)
    once = Rig(cold.motor)
    once.i[:], once.f[:] = cold.i, cold.f
    once.rest(256 * 10**12 + 77)
    for _ in range(80_000):
        cold.turn(1)
    assert once.f == cold.f and once.i[state.HEAT_SAMPLES] == 77
    assert once.i[state.TEMP] == -20


def test_an_overheated_motor_can_rest_while_it_cools():
    """The motor can rest once the fault has been reported and the winding is below TH."""
    rigs = []
    for _ in range(2):
        rig = Rig(replace(QUICK, housing_time_constant_s=20.0))
        rig.i[state.DRIVE], rig.i[state.HOT], rig.i[state.BH], rig.i[state.OVERLOAD] = state.DRIVE_SHORTED, 1, 1, 12_000
        rig.f[machine.HOUSING_C], rig.f[machine.WINDING_C], rig.i[state.TEMP] = 72.5, 70.5, 72
        assert not rig.resting
        while rig.f[machine.WINDING_C] >= 70:
            rig.sample()
        assert rig.resting
        rigs.append(rig)
    one, other = rigs
    for samples, hot in ((1000, 1), (1001, 1), (30_000, 0)):
        one.rest(samples)
        for _ in range(samples):
            other.sample()
        assert (one.i, one.f) == (other.i, other.f) and one.i[state.HOT] == hot
    assert one.resting


@pytest.mark.parametrize(("slot", "value"), [
    (state.DRIVE, state.DRIVE_OPEN), (state.COMMANDED, 65536), (state.VELOCITY, 1), (state.CURRENT_SUM, 4000),
    (state.OVERLOAD, 1), (state.HOT, 1), (state.PWM, 700), (state.INTEGRAL, 5000), (state.TH, 20)])  # fmt: skip
def test_no_rest_while_something_changes(slot, value):
    """A motor that holds a weight cannot rest if something changes, e.g. if its drive is switched off."""
    rig = Rig(FRAME23, ServoLoad(gravity_torque_nm=-0.1))
    rig.trapezoid(3000, 30, 300)
    assert rig.resting
    rig.i[slot] = value
    assert not rig.resting


def test_no_rest_while_it_turns_or_would():
    rig = Rig(FRAME23)
    rig.i[state.DRIVE] = state.DRIVE_OPEN
    assert rig.resting
    machine.set_torque(rig.f, 0.02)
    assert not rig.resting
    rig.i[state.BRAKE] = 1
    assert rig.resting
    rig.f[machine.SPEED] = 1.0
    assert not rig.resting


# Without a data sheet


def test_the_ideal_motor_is_where_the_trajectory_is():
    rig = Rig(None)
    rig.i[state.DIRECTION], rig.i[state.ORIGIN], rig.i[state.COMMANDED] = -1, 100, 1234 << 16 | 5
    assert not rig.resting
    servo.ideal(rig.i, rig.f)
    assert (rig.i[state.SHAFT], rig.error, rig.resting) == (-1134, 0, True)


def test_the_ideal_motor_stays_where_it_is_when_off_or_jammed():
    rig = Rig(None)
    rig.i[state.COMMANDED] = 1234 << 16
    machine.set_jam(rig.f, True)
    servo.ideal(rig.i, rig.f)
    assert (rig.i[state.SHAFT], rig.resting) == (0, True)
    machine.set_jam(rig.f, False)
    rig.i[state.DRIVE] = state.DRIVE_OPEN
    machine.push(rig.i, 7)
    servo.ideal(rig.i, rig.f)
    assert (rig.i[state.SHAFT], rig.resting) == (7, True)


def test_the_ideal_motor_in_torque_mode_turns_by_a_count_a_sample_for_32():
    rig = Rig(None)
    rig.i[state.MODE] = state.M_TORQUE
    for torque, shaft in ((96, 3), (-96, 0), (31, 0), (-31, 0), (1023, 31)):
        rig.i[state.T] = torque
        servo.ideal(rig.i, rig.f)
        assert rig.i[state.SHAFT] == shaft
    assert not rig.resting


def test_the_ideal_motor_is_as_warm_as_the_air_and_rests_for_nothing():
    rig = Rig(None)
    assert (rig.i[state.TEMP], rig.i[state.IDEAL]) == (25, 1)
    machine.set_ambient(rig.i, rig.f, 30.7)
    assert rig.i[state.TEMP] == 30
    rig.rest(10**15)
    assert rig.i[state.SAMPLE] == 10**15
    machine.set_ambient(rig.i, rig.f, 80.0)
    assert not rig.resting


@pytest.mark.skipif(not jit.available(), reason="Numba is not installed")
def test_rest_is_the_same_compiled():
    """The samples before the rest are machine code or plain Python; the rest is always plain Python."""
    found = []
    for compiled in (False, True):
        rig = Rig(FRAME23)
        rig.i[state.MODE], rig.i[state.COMMANDED] = state.M_HOLD, 100 << 16
        whole = Whole(rig, compiled=compiled)
        assert whole.run(4000) == [ALL_DONE] and servo.resting(whole.i, whole.f)
        servo.rest(whole.i, whole.f, 1_000_000)
        found.append((whole.i, whole.v, whole.f))
    assert found[0] == found[1]


# Inductance of the windings


def inductive(**differences):
    return replace(FRAME17, winding_inductance_h=2.5e-3, **differences)


def test_without_inductance_the_current_is_there_at_once():
    assert FRAME17.winding_inductance_h == 0
    rig = Rig(FRAME17)
    machine.set_jam(rig.f, True)
    rig.i[state.PWM] = 427
    rig.turn(1)
    assert rig.f[machine.AMPS_NOW] == pytest.approx(24 * 427 / 1023 / 2.5)


@pytest.mark.parametrize("samples", [1, 2, 5, 20])
def test_current_rises_with_the_time_constant_of_the_windings(samples):
    """L/R = 2.5 mH / 2.5 Ω = 1 ms.  With a held shaft I(t) = U/R · (1 - exp(-t/1 ms)); shorted, I falls likewise."""
    rig = Rig(inductive())
    machine.set_jam(rig.f, True)
    settled = 24 * 427 / 1023 / 2.5
    rig.i[state.PWM] = 427
    rig.turn(samples)
    kept = exp(-samples * SAMPLE_S / 1e-3)
    assert rig.f[machine.AMPS_NOW] == pytest.approx(settled * (1 - kept))
    begin = rig.f[machine.AMPS_NOW]
    rig.i[state.DRIVE] = state.DRIVE_SHORTED
    rig.turn(samples)
    assert rig.f[machine.AMPS_NOW] == pytest.approx(begin * kept)
    rig.i[state.DRIVE] = state.DRIVE_OPEN
    rig.turn(1)
    assert rig.f[machine.AMPS_NOW] == 0.0


def test_the_torque_of_a_sample_is_that_of_its_mean_current():
    """The mean of 1 - exp(-t/1 ms) over the first 245.76 µs, without friction: 1 - (1 - exp(-0.24576)) / 0.24576."""
    rig = Rig(inductive(coulomb_friction_nm=0.0, viscous_friction_nm_s=0.0, torque_constant_nm_per_a=1e-6))
    rig.i[state.PWM] = 427
    rig.turn(1)
    mean = 24 * 427 / 1023 / 2.5 * (1 - (1 - exp(-0.24576)) / 0.24576)
    assert rig.rad_per_s == pytest.approx(mean * 1e-6 / 4e-6 * SAMPLE_S, rel=1e-6)


def test_inductance_is_no_way_round_the_limit_of_the_amplifier():
    rig = Rig(inductive(peak_current_a=2.0))
    machine.set_jam(rig.f, True)
    rig.i[state.PWM] = 1023
    currents = []
    for _ in range(30):
        rig.turn(1)
        currents.append(rig.f[machine.AMPS_NOW])
    assert max(currents) == 2.0 and rig.i[state.BA] == 1


def highest(rig, counts):
    """Step the commanded position by some counts; return the shaft's highest and final position."""
    rig.i[state.COMMANDED], most = counts << 16, 0
    for _ in range(3000):
        rig.sample()
        most = max(most, rig.i[state.SHAFT])
    return most, rig.i[state.SHAFT]


@pytest.mark.parametrize(("kd", "millihenry", "fine"), [
    (550, 0.0, 217), (550, 0.7, 216), (300, 1.4, 246), (200, 0.7, 226), (150, 0.0, 222), (150, 0.35, 224),
    (150, 0.7, 242)])  # fmt: skip
def test_inductance_matters_where_damping_is_small(kd, millihenry, fine):
    """A step of 200 counts of a frame 23 is within 2 counts of an integration in steps of 1.2 µs."""
    most, end = highest(Rig(replace(FRAME23, kd=kd, winding_inductance_h=millihenry / 1000)), 200)
    assert abs(most - fine) <= 2 and end == 200


def test_a_motor_with_inductance_comes_to_rest():
    """At the target, and with shorted windings, the current becomes constant; then one step of rest is exact."""
    rig = Rig(replace(FRAME23, winding_inductance_h=7e-4))
    highest(rig, 200)
    assert rig.resting
    before = list(rig.f), list(rig.i)
    rig.sample()
    assert rig.f[machine.AMPS_NOW] == before[0][machine.AMPS_NOW]
    rig.i[state.DRIVE], rig.i[state.MODE] = state.DRIVE_SHORTED, state.M_BRAKE
    rig.turn(400)
    assert rig.f[machine.AMPS_NOW] == 0.0


def test_inductance_is_a_figure_of_the_data_sheet(bench):
    motor = bench.add("smartmotor", shaft={"motor": {"model": "frame23", "winding_inductance_h": 7e-4}})
    assert motor.axes["shaft"].motor.winding_inductance_h == 7e-4
    with pytest.raises(UsageError, match="winding_inductance_h"):
        bench.add("smartmotor", shaft={"motor": {"winding_inductance_h": -1e-3}})
