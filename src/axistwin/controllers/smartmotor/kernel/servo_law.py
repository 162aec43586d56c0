"""The servo law (base language, chapter 13), in integers: commanded and actual position to PWM.

    e = commanded - actual position        PWM = KP·e + KI·Σe (within KL) + KD·Δe + KV·velocity + KA·Δvelocity + KG

Δe is the difference between two errors KS samples apart; Δe is constant between differences.
"""

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.physics import Ints
from axistwin.controllers.smartmotor.kernel.position import following_error

FRACTION_BITS = 4  # Number of fraction bits of KP, KD, KV, KA and KG: they are in 1/16 of a PWM unit.
INTEGRAL_BITS = 7  # Number of additional fraction bits of KI, which is in 1/2048 of a PWM unit per count and sample.
LIMIT_BITS = 6
"""Number of bits of KL's unit: KL, in 4 PWM units, limits the integral term to 64 * KL in 1/16 of a unit."""
VELOCITY_BITS = 16
HALF = 1 << (FRACTION_BITS - 1)
FASTEST = 1 << 32  # Limit of a velocity in the servo law, twice the largest V, so that every product fits 64 bits.


@sampled
def control(i: Ints) -> None:
    """Set PWM for the next sample, from T or from the following error; 0 while the drive is off."""
    if i[s.DRIVE] != s.DRIVE_ON:
        i[s.PWM], i[s.ERROR_BEFORE], i[s.DIFFERENCE] = 0, 0, 0
        clear_integral(i)
    elif i[s.MODE] == s.M_TORQUE:
        i[s.PWM] = i[s.DIRECTION] * clipped(i[s.T], i[s.AMPS])
    elif (i[s.SAMPLE] & (i[s.PID_RATE] - 1)) == 0:
        pid(i, following_error(i))


@sampled
def pid(i: Ints, error: int) -> None:
    """Compute one step of the servo law.  The integral, the difference and the PWM value are updated."""
    i[s.INTEGRAL] = integrated(i, error)
    if i[s.TUNING + 4] <= 1 or (i[s.SAMPLE] // i[s.PID_RATE]) % i[s.TUNING + 4] == 0:
        i[s.DIFFERENCE] = error - i[s.ERROR_BEFORE]
        i[s.ERROR_BEFORE] = error
    i[s.PWM] = i[s.DIRECTION] * output(i, error)
    i[s.VELOCITY_BEFORE] = i[s.VELOCITY]


@sampled
def integrated(i: Ints, error: int) -> int:
    """Add this error to the integral, limit the sum by KL, and return it."""
    return clipped(i[s.INTEGRAL] + i[s.TUNING + 1] * error, i[s.TUNING + 3] << (LIMIT_BITS + INTEGRAL_BITS))


@sampled
def output(i: Ints, error: int) -> int:
    """Return the PWM value that KP, KI, KD, KV, KA and KG give, limited by AMPS, in the controller's direction."""
    total = i[s.TUNING] * error + (i[s.INTEGRAL] >> INTEGRAL_BITS) + i[s.TUNING + 2] * i[s.DIFFERENCE] + i[s.TUNING + 7]
    velocity, before = clipped(i[s.VELOCITY], FASTEST), clipped(i[s.VELOCITY_BEFORE], FASTEST)
    forward = i[s.TUNING + 5] * velocity + i[s.TUNING + 6] * (velocity - before)
    return clipped((total + (forward >> VELOCITY_BITS) + HALF) >> FRACTION_BITS, i[s.AMPS])


@sampled
def clipped(value: int, limit: int) -> int:
    if value > limit:
        return limit
    if value < -limit:
        return -limit
    return value


@sampled
def clear_integral(i: Ints) -> None:
    """Set the integral term of the servo law to 0."""
    i[s.INTEGRAL] = 0


@sampled
def steady(i: Ints) -> int:
    """Return 1 if the motor's PWM value will be the same in the next servo cycle, otherwise 0."""
    if i[s.MODE] == s.M_TORQUE:
        return 1 if i[s.PWM] == i[s.DIRECTION] * clipped(i[s.T], i[s.AMPS]) else 0
    error = following_error(i)
    if i[s.DIFFERENCE] != 0 or i[s.ERROR_BEFORE] != error or i[s.VELOCITY] != 0 or i[s.VELOCITY_BEFORE] != 0:
        return 0
    return 1 if integrated(i, error) == i[s.INTEGRAL] and i[s.PWM] == i[s.DIRECTION] * output(i, error) else 0
