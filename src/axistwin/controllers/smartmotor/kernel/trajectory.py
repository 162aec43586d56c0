"""The trajectory generator: what the position loop is to do in this sample (chapter 4 and 5 of the base language).

    v  A ╱‾‾‾‾‾‾╲ A       Every sample the velocity changes by at most A and is at most V.  The largest one is taken
      ╱          ╲        from which it is still possible to stop at the target, so the move lands on it exactly.
    ─┴────────────┴─ t

Velocities and accelerations are in 1/65536 count per sample (squared), positions in 1/65536 count.
"""

import math

from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.machine import Ints
from axistwin.controllers.smartmotor.kernel.position import wrapped
from axistwin.controllers.smartmotor.kernel.state import (
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
    MODE,
    ORIGIN,
    PINS,
    RATE,
    RESOLUTION,
    SHOWN,
    STEP_UP,
    STEPS,
    TARGET,
    TOLD,
    TOLD_AT,
    TOP,
    VELOCITY,
)

FULL_SCALE = 1023
"""The analog value of a pin at 5 V (6.3)."""
WRAP = 1 << 48
"""2^32 counts in 1/65536 count."""


@sampled
def way_to_stop(speed: int, rate: int) -> int:
    """How far it is to a stop if this sample goes `speed` > 0 and every further one `rate` less."""
    n = (speed + rate - 1) // rate
    return n * speed - rate * (n * (n - 1) // 2)


@sampled
def fastest(distance: int, rate: int) -> int:
    """The largest speed whose way to a stop is no longer than `distance` > 0."""
    n = int((math.sqrt(1.0 + 8.0 * distance / rate) - 1.0) / 2.0)
    while rate * (n * (n + 1) // 2) < distance:
        n += 1
    while n > 1 and rate * (n * (n - 1) // 2) >= distance:
        n -= 1
    return (distance + rate * (n * (n - 1) // 2)) // n


@sampled
def approach(velocity: int, remaining: int, top: int, rate: int) -> int:
    """The velocity of this sample on the way to a target that is `remaining` away."""
    way = 1 if remaining >= 0 else -1
    distance = remaining * way
    speed = velocity * way
    wanted = min(speed + rate, top)
    if speed > top:
        wanted = max(speed - rate, top)
    if wanted <= 0:
        return wanted * way  # still going the wrong way, or nowhere
    # A quick look first: way_to_stop(w) <= w²/2A + w/2 + A/8
    needed = 4.0 * wanted * wanted + 4.0 * rate * wanted + 1.0 * rate * rate
    if needed > 8.0 * rate * distance and (distance == 0 or way_to_stop(wanted, rate) > distance):
        best = 0 if distance == 0 else fastest(distance, rate)
        wanted = max(min(wanted, best), speed - rate)
    return wanted * way


@sampled
def towards(velocity: int, wanted: int, rate: int) -> int:
    """The velocity of this sample on the way to the velocity `wanted`."""
    if velocity < wanted:
        return min(velocity + rate, wanted)
    return max(velocity - rate, wanted)


@sampled
def master_turns(i: Ints, told: Ints) -> None:
    """The external encoder turns for a sample: to what has been told of it, or steadily."""
    if i[TOLD] > 0:
        i[MASTER] = told[i[TOLD_AT]]
        i[TOLD_AT] += 1
        i[TOLD] -= 1
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
    """Pins A and B take the levels of the external encoder; of a step source B is the direction, and A low."""
    if i[MASTER] != before:
        i[STEP_UP] = 1 if i[MASTER] > before else 0
    levels = 2 * i[STEP_UP] if i[STEPS] != 0 else quadrature(i[MASTER] - i[BY_HAND])
    i[PINS] = (i[PINS] & ~i[SHOWN]) | (levels & i[SHOWN])
    for bit in range(2):
        if i[SHOWN] >> bit & 1:
            i[ANALOG + bit] = FULL_SCALE * (levels >> bit & 1)


@sampled
def counted(i: Ints) -> int:
    """How much CTR has counted since the trajectory looked last."""
    counts = i[MASTER] * i[RESOLUTION] // 4
    moved = counts - i[MASTER_SEEN]
    if moved != 0:
        i[MASTER_SEEN] = counts
        i[CTR] = wrapped(i[CTR] + moved)
    return moved


@sampled
def follow(i: Ints, moved: int) -> None:
    """MF1, MF2, MF4 and MS: one count for each of the external counter; MFR and MSR: MFMUL/MFDIV, remainders kept."""
    step = moved
    if i[MODE] != M_FOLLOW and i[MODE] != M_STEP:
        owed = moved * i[FACTOR] + i[FOLLOW_REM]
        step = owed // i[TARGET]
        i[FOLLOW_REM] = owed - step * i[TARGET]
    i[VELOCITY] = step << 16
    i[COMMANDED] += step << 16


@sampled
def profile(i: Ints) -> None:
    """MP, MV, X: a trapezoid, a ramp to a velocity, a ramp to a stop."""
    mode = i[MODE]
    velocity = i[VELOCITY]
    rate = i[RATE]
    if mode == M_POSITION:
        remaining = (i[TARGET] << 16) - i[COMMANDED]
        if rate > 0:
            velocity = approach(velocity, remaining, i[TOP], rate)
        i[COMMANDED] += velocity
        if velocity == remaining and -rate <= velocity <= rate:
            velocity = 0
            i[BT] = 0
        elif velocity == 0 and (rate == 0 or i[TOP] == 0):
            i[BT] = 0  # no travel, ever
    elif mode == M_VELOCITY:
        velocity = towards(velocity, i[TOP], rate)
        i[COMMANDED] += velocity
        i[BT] = 0 if velocity == 0 and (i[TOP] == 0 or rate == 0) else 1
    elif mode == M_STOP:
        velocity = towards(velocity, 0, rate)
        i[COMMANDED] += velocity
        if velocity == 0:
            i[MODE] = M_HOLD
            i[BT] = 0
    i[VELOCITY] = velocity


@sampled
def wrap(i: Ints) -> None:
    """Beyond 2^31 counts the position continues at the other end; flag Bw.

    The target of a move goes with it, so that a move ends where it would on a longer scale.
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
