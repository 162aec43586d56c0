"""The trajectory generator: the commanded position of each sample (chapters 4 and 5 of the base language).

    v  A ╱‾‾‾‾‾‾╲ A       In a sample the velocity changes by at most A and is at most V.  The generator selects the
      ╱          ╲        largest velocity that still allows a stop at the target, so the move ends there exactly.
    ─┴────────────┴─ t

Velocities and accelerations are in 1/65536 count per sample (squared), positions in 1/65536 count.
"""

import math

from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.machine import Ints
from axistwin.controllers.smartmotor.kernel.position import wrapped
from axistwin.controllers.smartmotor.kernel.state import (
    ACCELERATION,
    ANALOG,
    BT,
    BW,
    BY_HAND,
    CAM_ORIGIN,
    COMMANDED,
    CTR,
    FACTOR,
    FOLLOW_REM,
    M_FOLLOW,
    M_HOLD,
    M_POSITION,
    M_STEP,
    M_STOP,
    M_VELOCITY,
    MASTER,
    MASTER_ADD,
    MASTER_DIV,
    MASTER_END,
    MASTER_LEFT,
    MASTER_REM,
    MASTER_SEEN,
    MASTER_STEP,
    MASTER_WAY,
    MAX_VELOCITY,
    MODE,
    ORIGIN,
    PINS,
    PREDICTED,
    PREDICTED_AT,
    RESOLUTION,
    SHOWN,
    STEP_UP,
    STEPS,
    TARGET,
    VELOCITY,
)

FULL_SCALE = 1023
"""The analog value of a pin at 5 V (6.3)."""
WRAP = 1 << 48
"""2^32 counts in 1/65536 count."""


@sampled
def stopping_distance(speed: int, acceleration: int) -> int:
    """Return the distance to a stop, `speed` > 0 in this sample and `acceleration` less in each further one."""
    n = (speed + acceleration - 1) // acceleration
    return n * speed - acceleration * (n * (n - 1) // 2)


@sampled
def max_stoppable_speed(distance: int, acceleration: int) -> int:
    """Return the largest speed whose stopping distance is at most `distance` > 0."""
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
        return wanted * way  # still in the wrong direction, or at rest
    # An upper bound first: stopping_distance(w) <= w²/2A + w/2 + A/8
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
    """Turn the external encoder for a sample: to its announced count, or at constant speed."""
    if i[PREDICTED] > 0:
        i[MASTER] = predicted[i[PREDICTED_AT]]
        i[PREDICTED_AT] += 1
        i[PREDICTED] -= 1
        return
    if i[MASTER_LEFT] == 0:
        return
    i[MASTER_LEFT] -= 1
    i[MASTER] += i[MASTER_WAY] * i[MASTER_STEP]
    i[MASTER_REM] += i[MASTER_ADD]
    if i[MASTER_REM] >= i[MASTER_DIV]:
        i[MASTER_REM] -= i[MASTER_DIV]
        i[MASTER] += i[MASTER_WAY]
    if i[MASTER_LEFT] == 0:
        i[MASTER] = i[MASTER_END]


@sampled
def quadrature(count: int) -> int:
    """Return the levels of pins A (1) and B (2) at a count of the external encoder; both are high at 0."""
    phase = (count + 2) & 3
    return phase ^ (phase >> 1)


@sampled
def show_master(i: Ints, before: int) -> None:
    """Set pins A and B to the levels of the external encoder; for a step source, B is the direction and A is low."""
    if i[MASTER] != before:
        i[STEP_UP] = 1 if i[MASTER] > before else 0
    levels = 2 * i[STEP_UP] if i[STEPS] != 0 else quadrature(i[MASTER] - i[BY_HAND])
    i[PINS] = (i[PINS] & ~i[SHOWN]) | (levels & i[SHOWN])
    for bit in range(2):
        if i[SHOWN] >> bit & 1:
            i[ANALOG + bit] = FULL_SCALE * (levels >> bit & 1)


@sampled
def counted(i: Ints) -> int:
    """Update CTR; return its change since the last call."""
    counts = i[MASTER] * i[RESOLUTION] // 4
    moved = counts - i[MASTER_SEEN]
    if moved != 0:
        i[MASTER_SEEN] = counts
        i[CTR] = wrapped(i[CTR] + moved)
    return moved


@sampled
def follow(i: Ints, moved: int) -> None:
    """Follow CTR: MF1, MF2, MF4 and MS one to one, MFR and MSR by MFMUL/MFDIV keeping the remainder."""
    step = moved
    if i[MODE] != M_FOLLOW and i[MODE] != M_STEP:
        owed = moved * i[FACTOR] + i[FOLLOW_REM]
        step = owed // i[TARGET]
        i[FOLLOW_REM] = owed - step * i[TARGET]
    i[VELOCITY] = step << 16
    i[COMMANDED] += step << 16


@sampled
def profile(i: Ints) -> None:
    """Move by MP, MV or X: a trapezoid, a ramp to a velocity, a ramp to a stop."""
    mode = i[MODE]
    velocity = i[VELOCITY]
    acceleration = i[ACCELERATION]
    if mode == M_POSITION:
        remaining = (i[TARGET] << 16) - i[COMMANDED]
        if acceleration > 0:
            velocity = next_velocity(velocity, remaining, i[MAX_VELOCITY], acceleration)
        i[COMMANDED] += velocity
        if velocity == remaining and -acceleration <= velocity <= acceleration:
            velocity = 0
            i[BT] = 0
        elif velocity == 0 and (acceleration == 0 or i[MAX_VELOCITY] == 0):
            i[BT] = 0  # no distance
    elif mode == M_VELOCITY:
        velocity = ramp_velocity(velocity, i[MAX_VELOCITY], acceleration)
        i[COMMANDED] += velocity
        i[BT] = 0 if velocity == 0 and (i[MAX_VELOCITY] == 0 or acceleration == 0) else 1
    elif mode == M_STOP:
        velocity = ramp_velocity(velocity, 0, acceleration)
        i[COMMANDED] += velocity
        if velocity == 0:
            i[MODE] = M_HOLD
            i[BT] = 0
    i[VELOCITY] = velocity


@sampled
def wrap(i: Ints) -> None:
    """Continue a position beyond 2^31 counts at the other end of the scale, and set Bw.

    The target is shifted by the same amount, so that the move keeps its length.
    """
    turn = 0
    if i[COMMANDED] >= WRAP // 2:
        turn = -1
    elif i[COMMANDED] < -WRAP // 2:
        turn = 1
    if turn != 0:
        i[COMMANDED] += turn * WRAP
        i[ORIGIN] += turn * (WRAP >> 16)
        i[CAM_ORIGIN] += turn * (WRAP >> 16)
        if i[MODE] == M_POSITION:
            i[TARGET] += turn * (WRAP >> 16)
        i[BW] = 1
