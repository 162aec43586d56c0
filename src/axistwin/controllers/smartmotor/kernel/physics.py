"""The physical model: the floats `f`, calculated from the data sheets, and external influences on the shaft.

The units are counts and samples, so that a sample needs few operations (`servo.py`).
"""

from collections.abc import MutableSequence
from dataclasses import replace
from itertools import count
from math import exp, floor, inf

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.core.errors import UsageError
from axistwin.plant.servo import ServoLoad, ServoMotor

SAMPLE_S = 245_760e-9
FULL_PWM = 1023
HEAT_BLOCK = 256  # Samples between two updates of the temperatures; 63 ms.
AMBIENT_C = 25.0
MOST_TORQUE_NM = 1000.0
LEAST = 1e-6  # Smallest share of magnetism or voltage, so that no division by zero occurs.

Ints = MutableSequence[int]
Floats = MutableSequence[float]

# Indices of the physical model's values, e.g. the shaft speed, in the array of floats
_slots = count()
SPEED = next(_slots)  # Speed of the motor shaft, in encoder counts per servo sample.
FRACTION = next(_slots)  # Fraction of a count (0 to 1) that the shaft has moved past the integer shaft position.
OUTSIDE = next(_slots)  # Acceleration of the shaft by external torque and gravity, in counts/sample².
# COULOMB is the deceleration of the shaft by dry friction, in counts/sample².
# STATIC_BRAKE is the additional deceleration of the shaft by the engaged static brake, in counts/sample².
COULOMB, STATIC_BRAKE = next(_slots), next(_slots)
JAM = next(_slots)  # Additional friction of the shaft: infinite while the shaft is jammed, otherwise 0.
VISCOUS = next(_slots)  # Deceleration by viscous friction, in counts/sample², for a shaft speed of 1 count/sample.
# Windings open: in each servo sample, viscous friction reduces the shaft speed to OPEN_GAIN * speed.
# Windings shorted or driven: in each sample, viscous friction and back-EMF reduce the speed to CLOSED_GAIN * speed.
OPEN_GAIN, CLOSED_GAIN = next(_slots), next(_slots)
PER_AMP = next(_slots)  # Acceleration of the shaft by a motor current of 1 A, in counts/sample².
# AMPS_PER_PWM is the motor current at standstill for a PWM value of 1, in A.
# AMPS_PER_SPEED is the decrease of the motor current by the back-EMF at a speed of 1 count/sample, in A.
AMPS_PER_PWM, AMPS_PER_SPEED = next(_slots), next(_slots)
AMPS_NOW = next(_slots)  # Current through the motor windings at the end of the latest servo sample, in A.
# Current at the end of a servo sample = AMPS_KEPT * (current at its start) + (1 - AMPS_KEPT) * (steady current).
AMPS_KEPT = next(_slots)
# MEAN_KEPT is the weight of the initial motor current in the mean motor current of a servo sample.
# MEAN_REACHED = 1 - MEAN_KEPT is the weight of the steady motor current in the mean motor current of a servo sample.
MEAN_KEPT, MEAN_REACHED = next(_slots), next(_slots)
# Mean shaft speed in a servo sample = LAG * (speed at its start) + (1 - LAG) * (speed at its end).
LAG = next(_slots)
PEAK_AMPS = next(_slots)
# Temperatures of the motor's winding, of the motor's housing, and of the air, in °C
WINDING_C, HOUSING_C, AMBIENT = (next(_slots) for _ in range(3))
# WINDING_RISE is the steady temperature difference between winding and housing at a motor current of 1 A, in K.
# HOUSING_RISE is the steady temperature difference between motor housing and air at a motor current of 1 A, in K.
WINDING_RISE, HOUSING_RISE = next(_slots), next(_slots)
# Every 256 servo samples, winding temperature += WINDING_STEP * (steady winding temperature - winding temperature).
# Every 256 servo samples, housing temperature += HOUSING_STEP * (winding temperature - housing temperature).
# Every 256 servo samples, housing temperature += AIR_STEP * (air temperature - housing temperature).
WINDING_STEP, HOUSING_STEP, AIR_STEP = (next(_slots) for _ in range(3))
# MEAN_SQUARE is the mean square of the motor current, in A².
# RATED_SQUARE is the square of the motor's continuous current, in A².
MEAN_SQUARE, RATED_SQUARE = next(_slots), next(_slots)
# LOSS_NJ is the heat that a motor current of 1 A produces in one servo sample, in nJ.
# WORK_NJ is the mechanical work for a shaft movement of 1 count at a motor current of 1 A, in nJ.
LOSS_NJ, WORK_NJ = next(_slots), next(_slots)
PER_NM = next(_slots)  # Acceleration of the shaft by a torque of 1 N·m, in counts/sample².
TORQUE_NM, GRAVITY_NM = next(_slots), next(_slots)
FLOATS = next(_slots)

MACHINE = s.SHAFT, s.CURRENT_SUM, s.HEAT, s.HEAT_SAMPLES, s.TEMP, s.BUS_VOLTAGE
"""Integers that belong to the machine; they keep their values without power, as all floats do."""


def fit(i: Ints, f: Floats, motor: ServoMotor | None = None, load: ServoLoad | None = None) -> None:
    """Set up motor and load by their data sheets, at rest, at 25 °C; ideal without a data sheet."""
    i[s.IDEAL] = int(motor is None)
    f[WINDING_C] = f[HOUSING_C] = f[AMBIENT] = AMBIENT_C
    i[s.TEMP] = floor(AMBIENT_C)
    if motor is not None:
        _fit_shaft(f, motor, load or ServoLoad())
        _fit_windings(f, motor)
        _fit_heat(f, motor)
        i[s.BUS_VOLTAGE], i[s.COUNTS_PER_REV] = round(10 * motor.supply_voltage_v), motor.counts_per_rev


def _fit_shaft(f: Floats, motor: ServoMotor, load: ServoLoad) -> None:
    inertia = motor.rotor_inertia_kg_m2 + load.inertia_kg_m2
    f[PER_NM] = SAMPLE_S**2 * motor.counts_per_radian / inertia
    f[COULOMB] = (motor.coulomb_friction_nm + load.coulomb_friction_nm) * f[PER_NM]
    f[STATIC_BRAKE] = motor.brake_torque_nm * f[PER_NM]
    f[GRAVITY_NM] = load.gravity_torque_nm
    set_torque(f, 0.0)
    f[VISCOUS] = (motor.viscous_friction_nm_s + load.viscous_friction_nm_s) * SAMPLE_S / inertia
    f[OPEN_GAIN] = 1 / (1 + f[VISCOUS])


def _fit_windings(f: Floats, motor: ServoMotor) -> None:
    """Set the electrical constants of the motor.

    The torque constant in N·m per A equals the back-EMF constant in V per rad/s.  With inductance the current settles
    exponentially.  Without inductance the distance of a sample is its final speed, which compensates the back-EMF of
    the final speed.  Inductance delays back-EMF, so that less compensation is needed.
    """
    f[PER_AMP] = motor.torque_constant_nm_per_a * f[PER_NM]
    f[AMPS_PER_PWM] = motor.supply_voltage_v / FULL_PWM / motor.winding_resistance_ohm
    volts_per_speed = motor.torque_constant_nm_per_a / (SAMPLE_S * motor.counts_per_radian)
    f[AMPS_PER_SPEED] = volts_per_speed / motor.winding_resistance_ohm
    f[AMPS_KEPT] = f[MEAN_KEPT] = 0.0
    if motor.winding_inductance_h > 0.0:
        time_constants = SAMPLE_S * motor.winding_resistance_ohm / motor.winding_inductance_h
        f[AMPS_KEPT] = exp(-time_constants)
        f[MEAN_KEPT] = (1 - f[AMPS_KEPT]) / time_constants
    f[MEAN_REACHED] = 1 - f[MEAN_KEPT]
    f[LAG] = f[MEAN_KEPT] / 2
    f[CLOSED_GAIN] = 1 / (1 + f[VISCOUS] + f[PER_AMP] * f[AMPS_PER_SPEED] * f[MEAN_REACHED])
    f[PEAK_AMPS] = motor.peak_current_a
    f[LOSS_NJ] = motor.winding_resistance_ohm * SAMPLE_S * 1e9
    f[WORK_NJ] = motor.torque_constant_nm_per_a / motor.counts_per_radian * 1e9


def _fit_heat(f: Floats, motor: ServoMotor) -> None:
    """Set the thermal constants.  Heat flows are calculated at the end of a block (implicit Euler method)."""
    block_s, ohm = HEAT_BLOCK * SAMPLE_S, motor.winding_resistance_ohm
    inwards, outwards = motor.winding_to_housing_k_per_w, motor.housing_to_ambient_k_per_w
    f[WINDING_RISE], f[HOUSING_RISE] = ohm * inwards, ohm * outwards
    from_winding, to_air = (
        block_s / motor.housing_time_constant_s * outwards / inwards,
        block_s / motor.housing_time_constant_s,
    )
    f[WINDING_STEP] = block_s / (block_s + motor.winding_time_constant_s)
    f[HOUSING_STEP] = from_winding / (1 + from_winding + to_air)
    f[AIR_STEP] = to_air / (1 + from_winding + to_air)
    f[RATED_SQUARE] = motor.continuous_current_a**2


def set_torque(f: Floats, newton_metres: float) -> None:
    """Set the external torque on the shaft, -1000 to 1000 N·m.

    A positive torque turns the shaft in the positive direction.  An ideal motor ignores the torque.
    """
    if not abs(newton_metres) <= MOST_TORQUE_NM:
        raise UsageError(f"invalid torque of {newton_metres} N·m: expected a number from -1000 to 1000")
    f[TORQUE_NM] = newton_metres
    f[OUTSIDE] = (newton_metres + f[GRAVITY_NM]) * f[PER_NM]


def set_jam(f: Floats, on: bool) -> None:
    f[JAM] = inf if on else 0.0


def set_windings(i: Ints, f: Floats, motor: ServoMotor, strength: float, supply: float) -> None:
    """Set the strength of the magnets and the supply voltage, as fractions (at most 1) of the data sheet's values."""
    weak = replace(
        motor,
        torque_constant_nm_per_a=max(strength, LEAST) * motor.torque_constant_nm_per_a,
        supply_voltage_v=max(supply, LEAST) * motor.supply_voltage_v,
    )
    _fit_windings(f, weak)
    i[s.BUS_VOLTAGE] = round(10 * weak.supply_voltage_v)


def set_encoder(i: Ints, of: int, out_of: int) -> None:
    """Make the encoder report `of` counts for every `out_of` counts of the shaft."""
    good = of == out_of
    i[s.COUNTS_OF], i[s.COUNTS_OUT_OF] = (0, 0) if good else (of, out_of)
    if good:
        i[s.UNCOUNTED] = 0


def slip(i: Ints, counts: int) -> None:
    """Shift the encoder relative to the motor shaft, by a number of counts."""
    i[s.SHAFT] += counts
    i[s.SLIPPED] -= counts


def push(i: Ints, counts: int) -> None:
    """Displace the shaft by a number of counts.  If the servo is on, the motor then moves the shaft back."""
    i[s.SHAFT] += counts


def set_ambient(i: Ints, f: Floats, celsius: float) -> None:
    """Set the ambient temperature, -273 to 1000 °C; a motor without a data sheet has it at once."""
    if not -273.0 <= celsius <= 1000.0:
        raise UsageError(f"ambient={celsius}: expected a temperature from -273 to 1000 °C")
    f[AMBIENT] = celsius
    if i[s.IDEAL]:
        f[WINDING_C] = f[HOUSING_C] = celsius
        i[s.TEMP] = floor(celsius)
