"""The servo motor: the simulation agrees with formulas from the data sheet."""

from dataclasses import replace
from itertools import pairwise
from math import exp, inf

import pytest

from axistwin.controllers.smartmotor.kernel import physics as machine
from axistwin.controllers.smartmotor.kernel import servo, state
from axistwin.core.errors import UsageError
from axistwin.plant.servo import FRAME17, FRAME23, FRAME34, SERVO_MOTORS, ServoLoad

from .rig import Rig
from .talking import SAMPLE_S

FRAMES = sorted(SERVO_MOTORS)


def driven(motor, pwm, load=None, drive=state.DRIVE_ON):
    """Return a rig with this PWM in torque mode."""
    rig = Rig(motor, load)
    rig.i[state.DRIVE], rig.i[state.PWM] = drive, pwm
    return rig


@pytest.mark.parametrize("pwm", [1023, -1023, 300])
@pytest.mark.parametrize("frame", FRAMES)
def test_no_load_speed(frame, pwm):
    """At the no-load speed Kt·(U - Ke·ω)/R = Tc + b·ω, so ω = (Kt·U/R - Tc) / (b + Kt·Ke/R)."""
    motor = SERVO_MOTORS[frame]
    k, ohm = motor.torque_constant_nm_per_a, motor.winding_resistance_ohm
    volts = motor.supply_voltage_v * abs(pwm) / 1023
    expected = (k * volts / ohm - motor.coulomb_friction_nm) / (motor.viscous_friction_nm_s + k * k / ohm)
    rig = driven(motor, pwm)
    rig.seconds(0.5)
    assert rig.rad_per_s == pytest.approx(expected if pwm > 0 else -expected, rel=1e-9)
    assert abs(rig.rad_per_s) < volts / k


def test_energy_is_the_integral_of_voltage_times_current():
    """Energy per second is U·I at constant speed, R·I² at a locked shaft; `rest` gives the same in one step."""
    rig = driven(FRAME23, 600)
    rig.seconds(0.5)
    before, elapsed = rig.i[state.ENERGY], rig.seconds(0.1)
    volts = FRAME23.supply_voltage_v * 600 / 1023
    amps = (volts - FRAME23.torque_constant_nm_per_a * rig.rad_per_s) / FRAME23.winding_resistance_ohm
    assert (rig.i[state.ENERGY] - before) / 1e9 == pytest.approx(volts * amps * elapsed, rel=1e-5)
    rig = driven(FRAME17, 100)
    machine.set_jam(rig.f, True)
    elapsed = rig.seconds(0.1)
    assert rig.i[state.ENERGY] / 1e9 == pytest.approx((100 * 24 / 1023) ** 2 / 2.5 * elapsed, rel=1e-5)
    before = rig.i[state.ENERGY]
    servo.rest(rig.i, rig.f, 1000)
    at_once, before = rig.i[state.ENERGY] - before, rig.i[state.ENERGY]
    for _ in range(1000):
        servo.rotate(rig.i, rig.f)
    assert rig.i[state.ENERGY] - before == at_once


def test_stall_current():
    """The current of a jammed shaft is U/R; above the amplifier's peak it is limited, and an over-current."""
    rig = driven(FRAME17, 100)
    machine.set_jam(rig.f, True)
    rig.seconds(0.1)
    assert (rig.i[state.CURRENT], rig.i[state.BA]) == (int(100 * 24 * 100 / 1023 / 2.5), 0)
    rig.i[state.PWM] = -1023  # full PWM would be 9.6 A
    rig.seconds(0.1)
    assert (rig.i[state.CURRENT], rig.i[state.BA], rig.i[state.SHAFT]) == (600, 1, 0)


def test_acceleration_at_peak_current():
    """The acceleration is (Kt·I - Tc)/J, for a frame 34 far below its top speed with a load of four rotors."""
    rig = driven(FRAME34, 1023, ServoLoad(inertia_kg_m2=4 * FRAME34.rotor_inertia_kg_m2))
    elapsed = rig.seconds(0.02)
    acceleration = (0.125 * 24 - 0.03) / (5 * 1.2e-4)
    assert rig.rad_per_s == pytest.approx(acceleration * elapsed, rel=0.001)
    assert rig.radians == pytest.approx(acceleration * elapsed**2 / 2, rel=0.02)


def test_back_emf_at_speed():
    """At half of the no-load speed, full PWM gives half of the stall current, which is within the peak."""
    motor = replace(FRAME17, peak_current_a=20.0)
    rig = driven(motor, 1023, ServoLoad(inertia_kg_m2=1.0))
    rig.f[machine.SPEED] = 0.5 * 24 / 0.036 * SAMPLE_S * motor.counts_per_radian
    rig.seconds(0.05)
    assert rig.i[state.CURRENT] == pytest.approx(480, abs=1)


def test_shorted_windings_brake_with_the_mechanical_time_constant():
    """Without friction, ω = ω₀·exp(-t/τ), where τ = J / (Kt·Ke/R + b)."""
    motor = replace(FRAME23, coulomb_friction_nm=0.0)
    load = ServoLoad(inertia_kg_m2=2e-3)
    tau = (2e-3 + 1.6e-5) / (0.075**2 / 0.7 + 1e-5)
    rig = driven(motor, 0, load, state.DRIVE_SHORTED)
    rig.f[machine.SPEED] = 20.0
    speed, elapsed = rig.rad_per_s, rig.seconds(tau)
    assert rig.rad_per_s == pytest.approx(speed * exp(-elapsed / tau), rel=0.001)
    assert rig.i[state.CURRENT] == pytest.approx(100 * 0.075 * rig.rad_per_s / 0.7, rel=0.02)  # filtered


def test_open_windings_coast_by_friction_alone():
    """ω falls by Tc/J·t and stays at 0: 0.012 N·m on 2.016·10⁻³ kg·m² stop 5.95 rad/s in a second."""
    motor = replace(FRAME23, viscous_friction_nm_s=1e-12)
    rig = driven(motor, 500, ServoLoad(inertia_kg_m2=2e-3), state.DRIVE_OPEN)
    rig.f[machine.SPEED] = 5.0 * SAMPLE_S * motor.counts_per_radian
    elapsed = rig.seconds(0.5)
    assert rig.rad_per_s == pytest.approx(5.0 - 0.012 / 2.016e-3 * elapsed, rel=1e-6)
    rig.seconds(0.5)
    assert rig.rad_per_s == 0.0


def test_friction_holds_the_shaft_exactly_at_rest():
    """Friction is 12 mN·m of the motor and 8 mN·m of the load: 0.0199 N·m never moves the shaft, 0.0201 N·m does."""
    rig = driven(FRAME23, 0, ServoLoad(coulomb_friction_nm=0.008), state.DRIVE_OPEN)
    machine.set_torque(rig.f, -0.0199)
    rig.seconds(1)
    assert (rig.rad_per_s, rig.radians) == (0.0, 0.0)
    machine.set_torque(rig.f, -0.0201)
    elapsed = rig.seconds(0.1)
    assert rig.rad_per_s == pytest.approx(-0.0001 / 1.6e-5 * elapsed, rel=0.1)


def test_a_weight_drops_when_the_brake_is_released():
    """The shaft turns by ½·(T - Tc)/J·t², with T = 0.1 N·m and J = 2·10⁻³ kg·m²; the brake holds up to 1 N·m."""
    load = ServoLoad(inertia_kg_m2=2e-3 - 1.6e-5, gravity_torque_nm=-0.1)
    rig = driven(replace(FRAME23, viscous_friction_nm_s=1e-12), 0, load, state.DRIVE_OPEN)
    rig.i[state.BRAKE] = 1
    rig.seconds(0.5)
    assert rig.radians == 0.0
    machine.set_torque(rig.f, -0.92)
    rig.seconds(0.1)
    assert rig.rad_per_s < 0
    machine.set_torque(rig.f, 0.0)
    rig.seconds(1)
    assert rig.rad_per_s == 0.0
    before = rig.radians
    rig.i[state.BRAKE] = 0
    elapsed = rig.seconds(0.5)
    assert rig.radians - before == pytest.approx(-0.5 * 0.088 / 2e-3 * elapsed**2, rel=0.001)


def test_a_jam_stops_it_at_once_and_it_goes_on_afterwards():
    rig = driven(FRAME23, 500)
    rig.seconds(0.1)
    machine.set_jam(rig.f, True)
    where = rig.radians
    rig.seconds(0.1)
    assert (rig.rad_per_s, rig.radians) == (0.0, where)
    machine.set_jam(rig.f, False)
    rig.seconds(0.1)
    assert rig.radians > where + 1


def test_a_push_displaces_it_and_nothing_brings_it_back_with_the_drive_off():
    rig = driven(FRAME23, 0, drive=state.DRIVE_SHORTED)
    machine.push(rig.i, -250)
    rig.seconds(0.1)
    assert rig.i[state.SHAFT] == -250


def test_the_shaft_counts_downwards_below_the_first_count():
    """A shaft at -0.4 counts reads -1, because positions are rounded down to the count."""
    rig = driven(FRAME23, 0, drive=state.DRIVE_OPEN)
    rig.f[machine.SPEED] = -0.4 - rig.f[machine.COULOMB]
    rig.turn(1)
    assert (rig.i[state.SHAFT], round(rig.f[machine.FRACTION], 3)) == (-1, 0.6)


def test_heat_goes_from_the_winding_to_the_housing_to_the_air():
    """1.98 A in 2.5 Ω are 9.8 W: after 100 s the winding is 14.7 K above the housing, which rises towards 39.2 K."""
    rig = driven(FRAME17, 212)
    machine.set_jam(rig.f, True)
    elapsed = rig.seconds(20)
    square = (int(100 * 24 * 212 / 1023 / 2.5) / 100) ** 2
    lead = rig.f[machine.WINDING_C] - rig.f[machine.HOUSING_C]
    assert lead == pytest.approx(square * 2.5 * 1.5 * (1 - exp(-elapsed / 20)), rel=0.06)
    # The winding's heat has not reached the housing: 20 s at 1.5 K/W are 13.3 J/K, 900 s at 4 K/W are 225 J/K.
    joules = square * 2.5 * elapsed - 20 / 1.5 * (rig.f[machine.WINDING_C] - 25)
    assert rig.f[machine.HOUSING_C] - 25 == pytest.approx(joules / 225, rel=0.03)


@pytest.mark.parametrize("load", [1e-9, 1.0, 1e4])
@pytest.mark.parametrize("drive", [state.DRIVE_OPEN, state.DRIVE_SHORTED, state.DRIVE_ON])
def test_extreme_data_are_stable(load, drive):
    """A tiny winding resistance, a huge friction and an extreme torque cause no oscillation."""
    motor = replace(FRAME23, winding_resistance_ohm=1e-4, rotor_inertia_kg_m2=1e-8, viscous_friction_nm_s=10.0)
    rig = driven(motor, 700, ServoLoad(inertia_kg_m2=load), drive)
    machine.set_torque(rig.f, 1000.0)
    speeds = []
    for _ in range(2000):
        rig.turn(1)
        speeds.append(rig.rad_per_s)
    assert all(0 <= before <= after for before, after in pairwise(speeds)) and speeds[-1] < inf


def test_the_processor_reads_voltage_and_temperature():
    """UJA is in 0.1 V, TEMP in °C."""
    i = Rig(replace(FRAME34, supply_voltage_v=36.54)).i
    assert (i[state.BUS_VOLTAGE], i[state.COUNTS_PER_REV], i[state.TEMP], i[state.IDEAL]) == (365, 4000, 25, 0)


@pytest.mark.parametrize("torque", [1001, -1001, inf, float("nan")])
def test_a_torque_beyond_reason(torque):
    rig = Rig(FRAME23)
    with pytest.raises(UsageError, match="expected a number from -1000 to 1000"):
        machine.set_torque(rig.f, torque)


@pytest.mark.parametrize("celsius", [-274, 1001, float("nan")])
def test_no_such_temperature(celsius):
    rig = Rig(FRAME23)
    with pytest.raises(UsageError, match="expected a temperature from -273 to 1000"):
        machine.set_ambient(rig.i, rig.f, celsius)
