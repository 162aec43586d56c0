"""Model of the brushless motor in each sample: motion, current, heat, overload protection, and rest.

The shaft's speed is found from the torques at the end of the sample (the implicit Euler method), so that the
calculation is stable for every inertia, winding and friction.  In units of counts and samples, with `amps` through the
windings on average:

    speed = (speed before + PER_AMP · amps + OUTSIDE ∓ friction) · gain        amps = (voltage - back-EMF) / resistance

Friction stops a motion and never reverses it: a torque below friction leaves the shaft exactly at rest.  Inductance
of the windings, if the data sheet has any, keeps a part of the current from one sample to the next.  Heat goes from
the winding to the housing, whose temperature is TEMP, and on to the air; the flow is calculated once in
256 samples.
"""

from math import floor

from axistwin.controllers.smartmotor.kernel import physics as m
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.physics import Floats, Ints
from axistwin.controllers.smartmotor.kernel.servo_law import VELOCITY_BITS, clipped, steady

CURRENT_BITS = 4  # Number of bits (4 for 16 samples) over which the measured current is filtered.
MOST_CENTIAMPS = 100_000.0
LEAST_AMPS = 1e-9  # Current in A below which a current counts as 0, so that a current in an inductance ends.
RMS_SECONDS = 1.0  # Approximate time in seconds over which the RMS current is calculated.
RMS_STEP = m.HEAT_BLOCK * m.SAMPLE_S / RMS_SECONDS
COOLER = 5  # Number of °C below TH at which an overheated motor can be switched on again.
IDEAL_BITS = 5  # An ideal motor in torque mode turns by a count per sample for each 32 PWM units.


@sampled
def rotate(i: Ints, f: Floats) -> None:
    """Turn the shaft for one sample under PWM, drive, brake and all torques; update current and heat."""
    push, against = f[m.SPEED] + f[m.OUTSIDE], friction(i, f)
    amps, settled, limited = 0.0, 0.0, False
    if i[s.DRIVE] == s.DRIVE_OPEN:
        speed = slowed(push, against) * f[m.OPEN_GAIN]
    else:
        settled = stall_amps(i, f)
        amps = mean_amps(f, settled)
        speed = slowed(push + amps * f[m.PER_AMP], against) * f[m.CLOSED_GAIN]
        amps -= speed * f[m.AMPS_PER_SPEED] * f[m.MEAN_REACHED]
        settled -= speed * f[m.AMPS_PER_SPEED]
        limited = i[s.DRIVE] == s.DRIVE_ON and not -f[m.PEAK_AMPS] <= amps <= f[m.PEAK_AMPS]
        if limited:
            amps = f[m.PEAK_AMPS] if amps > 0.0 else -f[m.PEAK_AMPS]
            speed = slowed(push + amps * f[m.PER_AMP], against) * f[m.OPEN_GAIN]
            i[s.BA] = 1
    place = f[m.FRACTION] + speed + f[m.LAG] * (f[m.SPEED] - speed)
    f[m.SPEED] = speed
    f[m.AMPS_NOW] = 0.0 if i[s.DRIVE] == s.DRIVE_OPEN else amps if limited else amps_after(f, settled)
    counts = floor(place)
    i[s.SHAFT] += counts
    if i[s.COUNTS_OUT_OF] != 0:
        miscount(i, counts)
    f[m.FRACTION] = place - counts
    i[s.ENERGY] += energy(f, amps, speed)
    measure(i, f, amps)


@sampled
def stall_amps(i: Ints, f: Floats) -> float:
    """Return the steady motor current at standstill for the present PWM value, in A."""
    return i[s.PWM] * f[m.AMPS_PER_PWM] if i[s.DRIVE] == s.DRIVE_ON else 0.0


@sampled
def mean_amps(f: Floats, settled: float) -> float:
    """Return the mean current of this sample in A, on the way from AMPS_NOW to `settled`."""
    return f[m.MEAN_KEPT] * f[m.AMPS_NOW] + f[m.MEAN_REACHED] * settled


@sampled
def amps_after(f: Floats, settled: float) -> float:
    """Return the motor current at the end of the present servo sample, in A."""
    amps = f[m.AMPS_KEPT] * f[m.AMPS_NOW] + (1.0 - f[m.AMPS_KEPT]) * settled
    return 0.0 if -LEAST_AMPS < amps < LEAST_AMPS else clipped_amps(f, amps)


@sampled
def clipped_amps(f: Floats, amps: float) -> float:
    return min(max(amps, -f[m.PEAK_AMPS]), f[m.PEAK_AMPS])


@sampled
def energy(f: Floats, amps: float, speed: float) -> int:
    """Return the electrical energy supplied to the motor windings during one servo sample, in nJ.

    The energy is negative if the motor brakes into the supply.
    """
    return int(amps * (amps * f[m.LOSS_NJ] + speed * f[m.WORK_NJ]))


@sampled
def miscount(i: Ints, counts: int) -> None:
    """Count a movement of `counts` with a defective encoder, and correct SHAFT."""
    counted, of = i[s.UNCOUNTED] + counts * i[s.COUNTS_OF], i[s.COUNTS_OUT_OF]
    whole = counted // of
    i[s.UNCOUNTED] = counted - whole * of
    i[s.SHAFT] += whole - counts
    i[s.SLIPPED] += counts - whole


@sampled
def friction(i: Ints, f: Floats) -> float:
    """Return the deceleration by friction, static brake and jam, in counts/sample²."""
    if i[s.BRAKE] != 0:
        return f[m.COULOMB] + f[m.STATIC_BRAKE] + f[m.JAM]
    return f[m.COULOMB] + f[m.JAM]


@sampled
def slowed(push: float, against: float) -> float:
    """Return the speed `push` less friction, at most `against` in one sample; 0 if friction stops the shaft."""
    if push > against:
        return push - against
    if push < -against:
        return push + against
    return 0.0


@sampled
def measure(i: Ints, f: Floats, amps: float) -> None:
    """Add the current of this sample to CURRENT (0.01 A, filtered) and to the heat."""
    centiamps = in_centiamps(amps)
    i[s.CURRENT_SUM] += centiamps - (i[s.CURRENT_SUM] >> CURRENT_BITS)
    i[s.CURRENT] = i[s.CURRENT_SUM] >> CURRENT_BITS
    i[s.HEAT] += centiamps * centiamps
    i[s.HEAT_SAMPLES] += 1
    if i[s.HEAT_SAMPLES] == m.HEAT_BLOCK:
        warm(i, f)


@sampled
def in_centiamps(amps: float) -> int:
    """Convert a current to its absolute value in units of 0.01 A.  The absolute value is limited to 1000 A."""
    return int(min(abs(amps) * 100.0, MOST_CENTIAMPS))


@sampled
def warm(i: Ints, f: Floats) -> None:
    """Update winding, housing and RMS current after 256 samples."""
    square = i[s.HEAT] * (1e-4 / m.HEAT_BLOCK)
    i[s.HEAT], i[s.HEAT_SAMPLES] = 0, 0
    f[m.WINDING_C] += (f[m.HOUSING_C] + square * f[m.WINDING_RISE] - f[m.WINDING_C]) * f[m.WINDING_STEP]
    flow = (f[m.WINDING_C] - f[m.HOUSING_C]) * f[m.HOUSING_STEP]
    f[m.HOUSING_C] += flow + (f[m.AMBIENT] - f[m.HOUSING_C]) * f[m.AIR_STEP]
    f[m.MEAN_SQUARE] += (square - f[m.MEAN_SQUARE]) * RMS_STEP
    i[s.TEMP] = floor(f[m.HOUSING_C])


@sampled
def ideal(i: Ints, f: Floats) -> None:
    """Simulate one sample: the shaft follows exactly; in torque mode it turns in proportion to T."""
    if i[s.DRIVE] != s.DRIVE_ON or f[m.JAM] > 0.0:
        return
    if i[s.MODE] == s.M_TORQUE:
        i[s.SHAFT] += i[s.DIRECTION] * ideal_turn(i)
    else:
        i[s.SHAFT] = tracked(i)


@sampled
def ideal_turn(i: Ints) -> int:
    """Return the counts by which an ideal motor turns in one sample of torque mode."""
    torque = clipped(i[s.T], i[s.AMPS])
    return torque >> IDEAL_BITS if torque > 0 else -(-torque >> IDEAL_BITS)


@sampled
def tracked(i: Ints) -> int:
    """Return the commanded position of the motor shaft, in encoder counts."""
    return i[s.DIRECTION] * ((i[s.COMMANDED] >> VELOCITY_BITS) - i[s.ORIGIN])


@sampled
def ideal_rests(i: Ints, f: Floats) -> int:
    """Return 1 if `ideal` would not move the shaft."""
    if i[s.DRIVE] != s.DRIVE_ON or f[m.JAM] > 0.0:
        return 1
    if i[s.MODE] == s.M_TORQUE:
        return 1 if ideal_turn(i) == 0 else 0
    return 1 if i[s.SHAFT] == tracked(i) else 0


@sampled
def overloaded(i: Ints, f: Floats) -> int:
    """Return 1 if the motor has been too hot, or its RMS current too high, for THD samples; call once per sample.

    The overload lasts until the motor has cooled to 5 °C below TH and the current is within its limit.
    """
    if i[s.HOT] != 0:
        cool(i, f)
    elif i[s.TEMP] <= i[s.TH] and f[m.MEAN_SQUARE] <= f[m.RATED_SQUARE]:
        i[s.OVERLOAD] = 0
    else:
        i[s.OVERLOAD] += 1
        if i[s.OVERLOAD] >= i[s.THD]:
            i[s.HOT] = 1
    return i[s.HOT]


@sampled
def cool(i: Ints, f: Floats) -> None:
    """Clear the overload state of a motor that is cool enough."""
    if i[s.TEMP] <= i[s.TH] - COOLER and f[m.MEAN_SQUARE] <= f[m.RATED_SQUARE]:
        i[s.HOT], i[s.OVERLOAD] = 0, 0


@sampled
def resting(i: Ints, f: Floats) -> int:
    """Return 1 if only temperatures will change, until an input or the trajectory changes."""
    if (cools(i, f) if i[s.HOT] != 0 else keeps_cool(i, f)) == 0:
        return 0
    if i[s.IDEAL] != 0:
        return ideal_rests(i, f)
    amps = 0.0
    if i[s.DRIVE] != s.DRIVE_OPEN:
        settled = stall_amps(i, f)
        amps = mean_amps(f, settled)
        if f[m.AMPS_KEPT] != 0.0 and amps_after(f, settled) != f[m.AMPS_NOW]:
            return 0
    if i[s.DRIVE] == s.DRIVE_ON and (not -f[m.PEAK_AMPS] <= amps <= f[m.PEAK_AMPS] or steady(i) == 0):
        return 0
    if f[m.SPEED] != 0.0 or in_centiamps(amps) != i[s.CURRENT_SUM] >> CURRENT_BITS:
        return 0
    return 1 if slowed(f[m.OUTSIDE] + amps * f[m.PER_AMP], friction(i, f)) == 0.0 else 0


@sampled
def keeps_cool(i: Ints, f: Floats) -> int:
    """Return 1 if neither TEMP nor RMS current can exceed its limit at the present current.

    Neither temperature rises further above its final value than the larger of the two present differences.
    """
    if i[s.OVERLOAD] != 0:
        return 0
    if i[s.IDEAL] != 0:
        return 1 if i[s.TEMP] <= i[s.TH] else 0
    centiamps = i[s.CURRENT_SUM] >> CURRENT_BITS
    square = centiamps * centiamps * 1e-4
    housing = f[m.AMBIENT] + square * f[m.HOUSING_RISE]
    winding = housing + square * f[m.WINDING_RISE]
    above = max(f[m.WINDING_C] - winding, f[m.HOUSING_C] - housing, 0.0)
    return 1 if housing + above < i[s.TH] and max(square, f[m.MEAN_SQUARE]) < f[m.RATED_SQUARE] else 0


@sampled
def cools(i: Ints, f: Floats) -> int:
    """Return 1 if an overheated motor, with the fault reported, will cool down and stay cool."""
    if i[s.BH] == 0 or i[s.IDEAL] != 0 or i[s.CURRENT_SUM] >> CURRENT_BITS != 0:
        return 0
    return 1 if f[m.AMBIENT] < i[s.TH] and f[m.WINDING_C] < i[s.TH] else 0


@sampled
def rest(i: Ints, f: Floats, samples: int) -> None:
    """Advance a motor at rest by many samples at once, as if each were computed."""
    i[s.SAMPLE] += samples
    if i[s.IDEAL] != 0:
        return
    centiamps = i[s.CURRENT_SUM] >> CURRENT_BITS
    square = centiamps * centiamps
    i[s.ENERGY] += samples * energy(f, f[m.AMPS_NOW], 0.0)
    left = samples
    while left >= m.HEAT_BLOCK - i[s.HEAT_SAMPLES]:
        step = m.HEAT_BLOCK - i[s.HEAT_SAMPLES]
        before = f[m.WINDING_C], f[m.HOUSING_C], f[m.MEAN_SQUARE]
        i[s.HEAT] += square * step
        warm(i, f)
        if i[s.HOT] != 0:
            cool(i, f)
        left -= step
        if step == m.HEAT_BLOCK and before == (f[m.WINDING_C], f[m.HOUSING_C], f[m.MEAN_SQUARE]):
            # The temperatures have become constant, so omit all further updates of the temperatures.
            left %= m.HEAT_BLOCK
    i[s.HEAT] += square * left
    i[s.HEAT_SAMPLES] += left
