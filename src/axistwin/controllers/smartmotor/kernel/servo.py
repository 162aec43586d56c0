"""The brushless motor that the servo law (`servo_law.py`) drives, its protection, and its rest; once per sample.

The shaft's speed is found from the torques at the end of the sample (the implicit Euler method), so that no inertia,
winding or friction makes it unstable.  In units of counts and samples, with `amps` through the windings on average:

    speed = (speed before + PER_AMP · amps + OUTSIDE ∓ friction) · gain        amps = (voltage - back-EMF) / resistance

Friction stops a motion and never reverses it: a torque below friction leaves the shaft exactly at rest.  Inductance
of the windings, if the data sheet has any, keeps a part of the current from one sample to the next.  Heat goes from
the winding to the housing, whose temperature is TEMP, and on to the air; the flow is calculated once in
256 samples.
"""

from math import floor

from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.machine import (
    AIR_STEP,
    AMBIENT,
    AMPS_KEPT,
    AMPS_NOW,
    AMPS_PER_PWM,
    AMPS_PER_SPEED,
    CLOSED_GAIN,
    COULOMB,
    FRACTION,
    HEAT_BLOCK,
    HOUSING_C,
    HOUSING_RISE,
    HOUSING_STEP,
    JAM,
    LAG,
    MEAN_KEPT,
    MEAN_REACHED,
    MEAN_SQUARE,
    OPEN_GAIN,
    OUTSIDE,
    PEAK_AMPS,
    PER_AMP,
    RATED_SQUARE,
    SAMPLE_S,
    SPEED,
    STATIC_BRAKE,
    WINDING_C,
    WINDING_RISE,
    WINDING_STEP,
    Floats,
    Ints,
)
from axistwin.controllers.smartmotor.kernel.servo_law import VELOCITY_BITS, clipped, steady
from axistwin.controllers.smartmotor.kernel.state import (
    AMPS,
    BA,
    BH,
    BRAKE,
    COMMANDED,
    COUNTS_OF,
    COUNTS_OUT_OF,
    CURRENT,
    CURRENT_SUM,
    DIRECTION,
    DRIVE,
    DRIVE_ON,
    DRIVE_OPEN,
    HEAT,
    HEAT_SAMPLES,
    HOT,
    IDEAL,
    M_TORQUE,
    MODE,
    ORIGIN,
    OVERLOAD,
    PWM,
    SAMPLE,
    SHAFT,
    SLIPPED,
    TEMP,
    TH,
    THD,
    UNCOUNTED,
    T,
)

CURRENT_BITS = 4
"""The measured current is filtered over 16 samples."""
MOST_CENTIAMPS = 100_000.0
LEAST_AMPS = 1e-9
"""A current below this is 0, so that a current in an inductance ends."""
RMS_SECONDS = 1.0
"""RMS current is taken over about this time."""
RMS_STEP = HEAT_BLOCK * SAMPLE_S / RMS_SECONDS
COOLER = 5
"""°C below TH: an overheated motor can be switched on again."""
IDEAL_BITS = 5
"""An ideal motor in torque mode turns by a count per sample for each 32 PWM units."""


# The motor


@sampled
def rotate(i: Ints, f: Floats) -> None:
    """Turn the shaft for one sample under PWM, drive, brake and all torques; update current and heat."""
    push, against = f[SPEED] + f[OUTSIDE], friction(i, f)
    amps, settled, limited = 0.0, 0.0, False
    if i[DRIVE] == DRIVE_OPEN:
        speed = slowed(push, against) * f[OPEN_GAIN]
    else:
        settled = stall_amps(i, f)
        amps = mean_amps(f, settled)
        speed = slowed(push + amps * f[PER_AMP], against) * f[CLOSED_GAIN]
        amps -= speed * f[AMPS_PER_SPEED] * f[MEAN_REACHED]
        settled -= speed * f[AMPS_PER_SPEED]
        limited = i[DRIVE] == DRIVE_ON and not -f[PEAK_AMPS] <= amps <= f[PEAK_AMPS]
        if limited:
            amps = f[PEAK_AMPS] if amps > 0.0 else -f[PEAK_AMPS]
            speed = slowed(push + amps * f[PER_AMP], against) * f[OPEN_GAIN]
            i[BA] = 1
    place = f[FRACTION] + speed + f[LAG] * (f[SPEED] - speed)
    f[SPEED] = speed
    f[AMPS_NOW] = 0.0 if i[DRIVE] == DRIVE_OPEN else amps if limited else amps_after(f, settled)
    counts = floor(place)
    i[SHAFT] += counts
    if i[COUNTS_OUT_OF] != 0:
        miscount(i, counts)
    f[FRACTION] = place - counts
    measure(i, f, amps)


@sampled
def stall_amps(i: Ints, f: Floats) -> float:
    """Return the final current of closed windings at standstill, in A."""
    return i[PWM] * f[AMPS_PER_PWM] if i[DRIVE] == DRIVE_ON else 0.0


@sampled
def mean_amps(f: Floats, settled: float) -> float:
    """Return the average current over this sample, on the way from AMPS_NOW to `settled`."""
    return f[MEAN_KEPT] * f[AMPS_NOW] + f[MEAN_REACHED] * settled


@sampled
def amps_after(f: Floats, settled: float) -> float:
    """Return the current at the end of this sample."""
    amps = f[AMPS_KEPT] * f[AMPS_NOW] + (1.0 - f[AMPS_KEPT]) * settled
    return 0.0 if -LEAST_AMPS < amps < LEAST_AMPS else clipped_amps(f, amps)


@sampled
def clipped_amps(f: Floats, amps: float) -> float:
    """Return a current within the peak of the amplifier."""
    return min(max(amps, -f[PEAK_AMPS]), f[PEAK_AMPS])


@sampled
def miscount(i: Ints, counts: int) -> None:
    """Count a turn of `counts` with a defective encoder, and correct SHAFT."""
    counted, of = i[UNCOUNTED] + counts * i[COUNTS_OF], i[COUNTS_OUT_OF]
    whole = counted // of
    i[UNCOUNTED] = counted - whole * of
    i[SHAFT] += whole - counts
    i[SLIPPED] += counts - whole


@sampled
def friction(i: Ints, f: Floats) -> float:
    """Return friction at the shaft, counts/sample²: bearings, static brake, a jam."""
    if i[BRAKE] != 0:
        return f[COULOMB] + f[STATIC_BRAKE] + f[JAM]
    return f[COULOMB] + f[JAM]


@sampled
def slowed(push: float, against: float) -> float:
    """Return a push reduced by friction."""
    if push > against:
        return push - against
    if push < -against:
        return push + against
    return 0.0


@sampled
def measure(i: Ints, f: Floats, amps: float) -> None:
    """Add the current of this sample to CURRENT (0.01 A, filtered) and to the heat."""
    centiamps = in_centiamps(amps)
    i[CURRENT_SUM] += centiamps - (i[CURRENT_SUM] >> CURRENT_BITS)
    i[CURRENT] = i[CURRENT_SUM] >> CURRENT_BITS
    i[HEAT] += centiamps * centiamps
    i[HEAT_SAMPLES] += 1
    if i[HEAT_SAMPLES] == HEAT_BLOCK:
        warm(i, f)


@sampled
def in_centiamps(amps: float) -> int:
    """Return the magnitude in 0.01 A, up to 1000 A."""
    return int(min(abs(amps) * 100.0, MOST_CENTIAMPS))


@sampled
def warm(i: Ints, f: Floats) -> None:
    """Update winding, housing and RMS current after 256 samples."""
    square = i[HEAT] * (1e-4 / HEAT_BLOCK)
    i[HEAT], i[HEAT_SAMPLES] = 0, 0
    f[WINDING_C] += (f[HOUSING_C] + square * f[WINDING_RISE] - f[WINDING_C]) * f[WINDING_STEP]
    flow = (f[WINDING_C] - f[HOUSING_C]) * f[HOUSING_STEP]
    f[HOUSING_C] += flow + (f[AMBIENT] - f[HOUSING_C]) * f[AIR_STEP]
    f[MEAN_SQUARE] += (square - f[MEAN_SQUARE]) * RMS_STEP
    i[TEMP] = floor(f[HOUSING_C])


# The motor without a data sheet


@sampled
def ideal(i: Ints, f: Floats) -> None:
    """Move the shaft of a motor without a data sheet to the commanded position, or by T in torque mode."""
    if i[DRIVE] != DRIVE_ON or f[JAM] > 0.0:
        return
    if i[MODE] == M_TORQUE:
        i[SHAFT] += i[DIRECTION] * ideal_turn(i)
    else:
        i[SHAFT] = tracked(i)


@sampled
def ideal_turn(i: Ints) -> int:
    """Return the counts of one sample in torque mode."""
    torque = clipped(i[T], i[AMPS])
    return torque >> IDEAL_BITS if torque > 0 else -(-torque >> IDEAL_BITS)


@sampled
def tracked(i: Ints) -> int:
    """Return the commanded position in the machine's counts."""
    return i[DIRECTION] * ((i[COMMANDED] >> VELOCITY_BITS) - i[ORIGIN])


@sampled
def ideal_rests(i: Ints, f: Floats) -> int:
    """Return 1 if `ideal` changes nothing."""
    if i[DRIVE] != DRIVE_ON or f[JAM] > 0.0:
        return 1
    if i[MODE] == M_TORQUE:
        return 1 if ideal_turn(i) == 0 else 0
    return 1 if i[SHAFT] == tracked(i) else 0


# Protection


@sampled
def overloaded(i: Ints, f: Floats) -> int:
    """Return 1 if the motor has been too hot, or its RMS current too high, for THD samples; call once per sample.

    The overload lasts until the motor has cooled to 5 °C below TH and the current is within its limit.
    """
    if i[HOT] != 0:
        cool(i, f)
    elif i[TEMP] <= i[TH] and f[MEAN_SQUARE] <= f[RATED_SQUARE]:
        i[OVERLOAD] = 0
    else:
        i[OVERLOAD] += 1
        if i[OVERLOAD] >= i[THD]:
            i[HOT] = 1
    return i[HOT]


@sampled
def cool(i: Ints, f: Floats) -> None:
    """End the overload of a motor that has cooled enough."""
    if i[TEMP] <= i[TH] - COOLER and f[MEAN_SQUARE] <= f[RATED_SQUARE]:
        i[HOT], i[OVERLOAD] = 0, 0


# Rest


@sampled
def resting(i: Ints, f: Floats) -> int:
    """Return 1 if only temperatures will change while the inputs and the trajectory do not."""
    if (cools(i, f) if i[HOT] != 0 else keeps_cool(i, f)) == 0:
        return 0
    if i[IDEAL] != 0:
        return ideal_rests(i, f)
    amps = 0.0
    if i[DRIVE] != DRIVE_OPEN:
        settled = stall_amps(i, f)
        amps = mean_amps(f, settled)
        if f[AMPS_KEPT] != 0.0 and amps_after(f, settled) != f[AMPS_NOW]:
            return 0
    if i[DRIVE] == DRIVE_ON and (not -f[PEAK_AMPS] <= amps <= f[PEAK_AMPS] or steady(i) == 0):
        return 0
    if f[SPEED] != 0.0 or in_centiamps(amps) != i[CURRENT_SUM] >> CURRENT_BITS:
        return 0
    return 1 if slowed(f[OUTSIDE] + amps * f[PER_AMP], friction(i, f)) == 0.0 else 0


@sampled
def keeps_cool(i: Ints, f: Floats) -> int:
    """Return 1 if neither TEMP nor RMS current can exceed its limit at the present current.

    Neither temperature rises further above its final value than the larger of the two present differences.
    """
    if i[OVERLOAD] != 0:
        return 0
    if i[IDEAL] != 0:
        return 1 if i[TEMP] <= i[TH] else 0
    centiamps = i[CURRENT_SUM] >> CURRENT_BITS
    square = centiamps * centiamps * 1e-4
    housing = f[AMBIENT] + square * f[HOUSING_RISE]
    winding = housing + square * f[WINDING_RISE]
    above = max(f[WINDING_C] - winding, f[HOUSING_C] - housing, 0.0)
    return 1 if housing + above < i[TH] and max(square, f[MEAN_SQUARE]) < f[RATED_SQUARE] else 0


@sampled
def cools(i: Ints, f: Floats) -> int:
    """Return 1 if an overheated motor, with the fault reported, will cool down and stay cool."""
    if i[BH] == 0 or i[IDEAL] != 0 or i[CURRENT_SUM] >> CURRENT_BITS != 0:
        return 0
    return 1 if f[AMBIENT] < i[TH] and f[WINDING_C] < i[TH] else 0


@sampled
def rest(i: Ints, f: Floats, samples: int) -> None:
    """Pass samples at rest in one step, with the same bits as one by one."""
    i[SAMPLE] += samples
    if i[IDEAL] != 0:
        return
    centiamps = i[CURRENT_SUM] >> CURRENT_BITS
    square = centiamps * centiamps
    left = samples
    while left >= HEAT_BLOCK - i[HEAT_SAMPLES]:
        step = HEAT_BLOCK - i[HEAT_SAMPLES]
        winding, housing, mean = f[WINDING_C], f[HOUSING_C], f[MEAN_SQUARE]
        i[HEAT] += square * step
        warm(i, f)
        if i[HOT] != 0:
            cool(i, f)
        left -= step
        if step == HEAT_BLOCK and winding == f[WINDING_C] and housing == f[HOUSING_C] and mean == f[MEAN_SQUARE]:
            left %= HEAT_BLOCK  # all further blocks are equal
    i[HEAT] += square * left
    i[HEAT_SAMPLES] += left
