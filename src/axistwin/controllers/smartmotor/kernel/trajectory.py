"""The trajectory generator: the commanded position of each sample (chapters 4 and 5 of the base language).

    v  A ╱‾‾‾‾‾‾╲ A       In a sample the velocity changes by at most A and is at most V.  The generator selects the
      ╱          ╲        largest velocity that still allows a stop at the target, so the move ends there exactly.
    ─┴────────────┴─ t

Positions are in 1/65536 count, velocities in 1/65536 count/sample, accelerations in 1/65536 count/sample².
"""

import math

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.physics import Ints
from axistwin.controllers.smartmotor.kernel.position import wrapped

FULL_SCALE = 1023  # The analog value of a pin at 5 V (manual, section 6.3).
WRAP = 1 << 48  # Number of 1/65536 counts in 2^32 counts, at which a position wraps.


@sampled
def stopping_distance(speed: int, acceleration: int) -> int:
    """Return the stopping distance of a speed above 0 that falls by `acceleration` in each sample."""
    n = (speed + acceleration - 1) // acceleration
    return n * speed - acceleration * (n * (n - 1) // 2)


@sampled
def max_stoppable_speed(distance: int, acceleration: int) -> int:
    """Return the largest speed whose stopping distance is at most `distance`.  `distance` is greater than 0."""
    n = int((math.sqrt(1.0 + 8.0 * distance / acceleration) - 1.0) / 2.0)
    while acceleration * (n * (n + 1) // 2) < distance:
        n += 1
    while n > 1 and acceleration * (n * (n - 1) // 2) >= distance:
        n -= 1
    return (distance + acceleration * (n * (n - 1) // 2)) // n


@sampled
def next_velocity(velocity: int, remaining: int, max_velocity: int, acceleration: int) -> int:
    """Return the velocity of this sample towards a target at the distance `remaining`."""
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
    """Return the velocity of this sample on a ramp to the velocity `wanted`."""
    if velocity < wanted:
        return min(velocity + acceleration, wanted)
    return max(velocity - acceleration, wanted)


@sampled
def master_turns(i: Ints, predicted: Ints) -> None:
    """Advance the external encoder by one sample: by the prediction, or at constant speed."""
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
    """Return the levels of pins A (1) and B (2) at a count of the external encoder; both are high at 0."""
    phase = (count + 2) & 3
    return phase ^ (phase >> 1)


@sampled
def show_master(i: Ints, before: int) -> None:
    """Set pins A and B to the encoder's levels; for a step source, B is the direction and A is low."""
    if i[s.MASTER] != before:
        i[s.STEP_UP] = 1 if i[s.MASTER] > before else 0
    levels = 2 * i[s.STEP_UP] if i[s.STEPS] != 0 else quadrature(i[s.MASTER] - i[s.PIN_EDGES])
    i[s.PINS] = (i[s.PINS] & ~i[s.SHOWN]) | (levels & i[s.SHOWN])
    for bit in range(2):
        if i[s.SHOWN] >> bit & 1:
            i[s.ANALOG + bit] = FULL_SCALE * (levels >> bit & 1)


@sampled
def counted(i: Ints) -> int:
    """Update the external counter CTR, and return its change since the last call."""
    counts = i[s.MASTER] * i[s.RESOLUTION] // 4
    moved = counts - i[s.MASTER_SEEN]
    if moved != 0:
        i[s.MASTER_SEEN] = counts
        i[s.CTR] = wrapped(i[s.CTR] + moved)
    return moved


@sampled
def follow(i: Ints, moved: int) -> None:
    """Follow the counter CTR: one to one in MF1, MF2, MF4 and MS, by the ratio MFMUL/MFDIV in MFR and MSR."""
    step = moved
    if i[s.MODE] != s.M_FOLLOW and i[s.MODE] != s.M_STEP:
        owed = moved * i[s.FACTOR] + i[s.FOLLOW_REM]
        step = owed // i[s.TARGET]
        i[s.FOLLOW_REM] = owed - step * i[s.TARGET]
    i[s.VELOCITY] = step << 16
    i[s.COMMANDED] += step << 16


@sampled
def profile(i: Ints) -> None:
    """Compute one sample of MP (a trapezoidal move), of MV (a ramp to a velocity) or of X (a ramp to a stop)."""
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
    """Continue a position beyond 2^31 counts at the other end of the scale, and set Bw.

    The target is shifted by the same amount, so that the move keeps its length.
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
