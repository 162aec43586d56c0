"""The trajectory generator: the commanded position of each sample (chapters 4 and 5 of the base language).

    v  A ╱‾‾‾‾‾‾╲ A       In a sample the velocity changes by at most A and is at most V.  The generator selects the
      ╱          ╲        largest velocity that still allows a stop at the target, so the move ends there exactly.
    ─┴────────────┴─ t

Positions are in 1/65536 count, velocities in 1/65536 count/sample, accelerations in 1/65536 count/sample².
"""

import math

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.machine import Ints
from axistwin.controllers.smartmotor.kernel.position import wrapped

FULL_SCALE = 1023
"""The analog value of a pin at 5 V (manual, section 6.3)."""
WRAP = 1 << 48
"""Number of 1/65536 counts in 2^32 counts, at which a position wraps."""


@sampled
def stopping_distance(speed: int, acceleration: int) -> int:
    """Return the distance in which a decelerating motor stops.

    The speed is above 0, and decreases by `acceleration` in each sample.
    """
    n = (speed + acceleration - 1) // acceleration
    return n * speed - acceleration * (n * (n - 1) // 2)


@sampled
def max_stoppable_speed(distance: int, acceleration: int) -> int:
    """Return the largest speed whose stopping distance is at most `distance`.

    `distance` is greater than 0.
    """
    n = int((math.sqrt(1.0 + 8.0 * distance / acceleration) - 1.0) / 2.0)
    while acceleration * (n * (n + 1) // 2) < distance:
        n += 1
    while n > 1 and acceleration * (n * (n - 1) // 2) >= distance:
        n -= 1
    return (distance + acceleration * (n * (n - 1) // 2)) // n


@sampled
def next_velocity(velocity: int, remaining: int, max_velocity: int, acceleration: int) -> int:
    """Return the commanded velocity of a position move in the present servo sample.

    `velocity`: commanded velocity in the last sample.  `remaining`: distance to the target.
    """
    way = 1 if remaining >= 0 else -1
    distance = remaining * way
    speed = velocity * way
    wanted = min(speed + acceleration, max_velocity)
    if speed > max_velocity:
        wanted = max(speed - acceleration, max_velocity)
    if wanted <= 0:
        return wanted * way  # Velocity 0, or a velocity away from the target, cannot cause an overshoot.
    # The stopping distance is at most w²/(2A) + w/2 + A/8 for the velocity w and the acceleration A.
    needed = 4.0 * wanted * wanted + 4.0 * acceleration * wanted + 1.0 * acceleration * acceleration
    if needed > 8.0 * acceleration * distance and (distance == 0 or stopping_distance(wanted, acceleration) > distance):
        best = 0 if distance == 0 else max_stoppable_speed(distance, acceleration)
        wanted = max(min(wanted, best), speed - acceleration)
    return wanted * way


@sampled
def ramp_velocity(velocity: int, wanted: int, acceleration: int) -> int:
    """Return the next velocity of a linear ramp from `velocity` towards `wanted`.

    The velocity changes by at most `acceleration` in one servo sample.
    """
    if velocity < wanted:
        return min(velocity + acceleration, wanted)
    return max(velocity - acceleration, wanted)


@sampled
def master_turns(i: Ints, predicted: Ints) -> None:
    """Advance the simulated external encoder by one servo sample.

    The new encoder count is either predicted, or follows from a constant speed.
    """
    if i[s.PREDICTED] > 0:
        i[s.MASTER] = predicted[i[s.PREDICTED_AT]]
        i[s.PREDICTED_AT] += 1
        i[s.PREDICTED] -= 1
        return
    if i[s.MASTER_LEFT] == 0:
        return
    i[s.MASTER_LEFT] -= 1
    i[s.MASTER] += i[s.MASTER_WAY] * i[s.MASTER_STEP]
    i[s.MASTER_REM] += i[s.MASTER_ADD]
    if i[s.MASTER_REM] >= i[s.MASTER_DIV]:
        i[s.MASTER_REM] -= i[s.MASTER_DIV]
        i[s.MASTER] += i[s.MASTER_WAY]
    if i[s.MASTER_LEFT] == 0:
        i[s.MASTER] = i[s.MASTER_END]


@sampled
def quadrature(count: int) -> int:
    """Return the levels of pins A and B for a count of the external encoder.

    Bit 0 is pin A, and bit 1 is pin B.  Both pins are high at count 0.
    """
    phase = (count + 2) & 3
    return phase ^ (phase >> 1)


@sampled
def show_master(i: Ints, before: int) -> None:
    """Set pins A and B to the levels of the external encoder.

    For a step source, pin B is the direction, and pin A is low.
    """
    if i[s.MASTER] != before:
        i[s.STEP_UP] = 1 if i[s.MASTER] > before else 0
    levels = 2 * i[s.STEP_UP] if i[s.STEPS] != 0 else quadrature(i[s.MASTER] - i[s.PIN_EDGES])
    i[s.PINS] = (i[s.PINS] & ~i[s.SHOWN]) | (levels & i[s.SHOWN])
    for bit in range(2):
        if i[s.SHOWN] >> bit & 1:
            i[s.ANALOG + bit] = FULL_SCALE * (levels >> bit & 1)


@sampled
def counted(i: Ints) -> int:
    """Update CTR, which counts the pulses of the external encoder.

    Returns the change of CTR since the previous call of this function.
    """
    counts = i[s.MASTER] * i[s.RESOLUTION] // 4
    moved = counts - i[s.MASTER_SEEN]
    if moved != 0:
        i[s.MASTER_SEEN] = counts
        i[s.CTR] = wrapped(i[s.CTR] + moved)
    return moved


@sampled
def follow(i: Ints, moved: int) -> None:
    """Compute the commanded position in mode MF1, MF2, MF4, MS, MFR or MSR for one servo sample.

    In these modes, the commanded position follows the external counter.

    The ratio is MFMUL/MFDIV in MFR and MSR, and 1 in all other modes.
    """
    step = moved
    if i[s.MODE] != s.M_FOLLOW and i[s.MODE] != s.M_STEP:
        owed = moved * i[s.FACTOR] + i[s.FOLLOW_REM]
        step = owed // i[s.TARGET]
        i[s.FOLLOW_REM] = owed - step * i[s.TARGET]
    i[s.VELOCITY] = step << 16
    i[s.COMMANDED] += step << 16


@sampled
def profile(i: Ints) -> None:
    """Compute one servo sample of a trajectory: a position move (MP), velocity mode (MV) or a stop (X).

    MP is a trapezoidal move, MV is a ramp to a velocity, and X is a ramp to a stop.
    """
    mode = i[s.MODE]
    velocity = i[s.VELOCITY]
    acceleration = i[s.ACCELERATION]
    if mode == s.M_POSITION:
        remaining = (i[s.TARGET] << 16) - i[s.COMMANDED]
        if acceleration > 0:
            velocity = next_velocity(velocity, remaining, i[s.MAX_VELOCITY], acceleration)
        i[s.COMMANDED] += velocity
        if velocity == remaining and -acceleration <= velocity <= acceleration:
            velocity = 0
            i[s.BT] = 0
    elif mode == s.M_VELOCITY:
        velocity = ramp_velocity(velocity, i[s.MAX_VELOCITY], acceleration)
        i[s.COMMANDED] += velocity
    elif mode == s.M_STOP:
        velocity = ramp_velocity(velocity, 0, acceleration)
        i[s.COMMANDED] += velocity
        if velocity == 0:
            i[s.MODE] = s.M_HOLD
            i[s.BT] = 0
    i[s.VELOCITY] = velocity


@sampled
def wrap(i: Ints) -> None:
    """Wrap the commanded position at the ends of the 32-bit range.

    After the highest position, the count continues at the lowest position, and vice versa.  The flag Bw is then set,
    and the target is shifted by the same amount, so that the move keeps its length.
    """
    turn = 0
    if i[s.COMMANDED] >= WRAP // 2:
        turn = -1
    elif i[s.COMMANDED] < -WRAP // 2:
        turn = 1
    if turn != 0:
        i[s.COMMANDED] += turn * WRAP
        i[s.ORIGIN] += turn * (WRAP >> 16)
        i[s.CAM_ORIGIN] += turn * (WRAP >> 16)
        if i[s.MODE] == s.M_POSITION:
            i[s.TARGET] += turn * (WRAP >> 16)
        i[s.BW] = 1
