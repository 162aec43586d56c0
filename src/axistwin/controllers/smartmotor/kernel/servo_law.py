"""The servo law (base language, chapter 13), in integers: commanded and actual position to PWM.

    e = commanded - actual position        PWM = KP·e + KI·Σe (within KL) + KD·Δe + KV·velocity + KA·Δvelocity + KG

Δe is the difference between two errors KS samples apart; Δe is constant between differences.
"""

from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.machine import Ints
from axistwin.controllers.smartmotor.kernel.position import following_error
from axistwin.controllers.smartmotor.kernel.state import (
    AMPS,
    DIFFERENCE,
    DIRECTION,
    DRIVE,
    DRIVE_ON,
    ERROR_BEFORE,
    INTEGRAL,
    M_TORQUE,
    MODE,
    PID_RATE,
    PWM,
    SAMPLE,
    TUNING,
    VELOCITY,
    VELOCITY_BEFORE,
    T,
)

FRACTION_BITS = 4
"""KP, KD, KV, KA and KG are in 1/16 of a PWM unit per count, count/sample, count/sample² and by itself."""
INTEGRAL_BITS = 7
"""KI is in 1/2048 of a PWM unit per count and sample: 1/16, and 7 bits more."""
LIMIT_BITS = 6
"""KL is in 4 PWM units: it limits the integral term, in 1/16 of a unit, to 64 KL."""
VELOCITY_BITS = 16
HALF = 1 << (FRACTION_BITS - 1)
FASTEST = 1 << 32
"""Limit of a velocity in the law, twice the largest V: every product fits 64 bits."""


@sampled
def control(i: Ints) -> None:
    """Set PWM for the next sample, from T or from the following error; 0 while the drive is off."""
    if i[DRIVE] != DRIVE_ON:
        i[PWM], i[ERROR_BEFORE], i[DIFFERENCE] = 0, 0, 0
        clear_integral(i)
    elif i[MODE] == M_TORQUE:
        i[PWM] = i[DIRECTION] * clipped(i[T], i[AMPS])
    elif (i[SAMPLE] & (i[PID_RATE] - 1)) == 0:
        pid(i, following_error(i))


@sampled
def pid(i: Ints, error: int) -> None:
    """Do one step of the PID: keep the integral and the difference, set PWM to the output."""
    i[INTEGRAL] = integrated(i, error)
    if i[TUNING + 4] <= 1 or (i[SAMPLE] // i[PID_RATE]) % i[TUNING + 4] == 0:
        i[DIFFERENCE] = error - i[ERROR_BEFORE]
        i[ERROR_BEFORE] = error
    i[PWM] = i[DIRECTION] * output(i, error)
    i[VELOCITY_BEFORE] = i[VELOCITY]


@sampled
def integrated(i: Ints, error: int) -> int:
    """Return the integral with this error added, within KL."""
    return clipped(i[INTEGRAL] + i[TUNING + 1] * error, i[TUNING + 3] << (LIMIT_BITS + INTEGRAL_BITS))


@sampled
def output(i: Ints, error: int) -> int:
    """Return PWM in the controller's direction: KP, KI, KD, KV, KA, KG, within AMPS."""
    total = i[TUNING] * error + (i[INTEGRAL] >> INTEGRAL_BITS) + i[TUNING + 2] * i[DIFFERENCE] + i[TUNING + 7]
    velocity, before = clipped(i[VELOCITY], FASTEST), clipped(i[VELOCITY_BEFORE], FASTEST)
    forward = i[TUNING + 5] * velocity + i[TUNING + 6] * (velocity - before)
    return clipped((total + (forward >> VELOCITY_BITS) + HALF) >> FRACTION_BITS, i[AMPS])


@sampled
def clipped(value: int, limit: int) -> int:
    """Return the value within -limit … +limit."""
    if value > limit:
        return limit
    if value < -limit:
        return -limit
    return value


@sampled
def clear_integral(i: Ints) -> None:
    """Set the integral term to 0 (F=8)."""
    i[INTEGRAL] = 0


@sampled
def steady(i: Ints) -> int:
    """Return 1 if the servo law would repeat its output."""
    if i[MODE] == M_TORQUE:
        return 1 if i[PWM] == i[DIRECTION] * clipped(i[T], i[AMPS]) else 0
    error = following_error(i)
    if i[DIFFERENCE] != 0 or i[ERROR_BEFORE] != error or i[VELOCITY] != 0 or i[VELOCITY_BEFORE] != 0:
        return 0
    return 1 if integrated(i, error) == i[INTEGRAL] and i[PWM] == i[DIRECTION] * output(i, error) else 0
