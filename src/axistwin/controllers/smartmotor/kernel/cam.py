"""Mode cam (chapter 9): the position follows a table, aw[0] to aw[SIZE], over the counts of the external encoder.

aw[1]  ╱╲          BASE counts are one cycle; then, with F=16 or F=128, D counts of dwell at the last position.
      ╱  ╲____     Passing the end of base plus dwell, or aw[0] backwards, is crossing the zero point: there, a cycle
aw[0]╱ aw[2] D     begins at the end of the last cycle, and after CI changed parameters come into force.
"""

from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.machine import Ints
from axistwin.controllers.smartmotor.kernel.state import (
    ARRAY_BASE,
    CAM_BASE,
    CAM_DWELL,
    CAM_F,
    CAM_FACTOR,
    CAM_ORIGIN,
    CAM_PHASE,
    CAM_SIZE,
    CAM_TABLE,
    CI_PENDING,
    CI_SPOILT,
    COMMANDED,
    CTR,
    CX,
    MC_BASE,
    MC_FACTOR,
    MC_SIZE,
    ORIGIN,
    VELOCITY,
    D,
    F,
)

RELATIVE_CAM, MODULO_CAM = 16, 128
DWELLING = RELATIVE_CAM | MODULO_CAM
"""Bits of F with which there is a dwell."""
TABLE_MOST = 101


@sampled
def entry(i: Ints, v: Ints, n: int) -> int:
    """Return aw[n], times the factor of MCn if that multiplies the table."""
    word = v[i[ARRAY_BASE] + n // 2]
    word = word >> 16 if n % 2 == 0 else (word & 0xFFFF ^ 0x8000) - 0x8000
    return word * i[CAM_FACTOR] if i[CAM_TABLE] else word


@sampled
def take_over(i: Ints) -> None:
    """Put the buffered parameters in force: at G, and at the zero point after CI."""
    i[CAM_BASE], i[CAM_SIZE], i[CAM_FACTOR] = i[MC_BASE], i[MC_SIZE], i[MC_FACTOR]
    i[CAM_F] = i[F] & DWELLING
    i[CAM_DWELL] = max(i[D], 0) if i[CAM_F] else 0
    i[CI_PENDING] = i[CI_SPOILT] = 0


def invalidate(i: Ints) -> None:
    """Cancel a CI that waits for the zero point, because a cam parameter has changed; the next CI needs an MCn
    (9.5).
    """
    if i[CI_PENDING]:
        i[CI_PENDING], i[CI_SPOILT] = 0, 1


@sampled
def cross(i: Ints, v: Ints, way: int) -> None:
    """Cross the zero point forwards (+1) or backwards (-1)."""
    end = entry(i, v, i[CAM_SIZE])
    cycle = i[CAM_BASE] + i[CAM_DWELL]
    word = i[CAM_F]
    left = i[CAM_PHASE] if way > 0 else i[CAM_PHASE] - cycle  # counts beyond the zero point
    if way > 0 and i[CI_PENDING]:
        take_over(i)
    elif i[CI_PENDING]:
        take_over(i)
        end = entry(i, v, i[CAM_SIZE])  # of the next cycle
        i[CAM_PHASE] = max(left + i[CAM_BASE] + i[CAM_DWELL], 0)
    if word & MODULO_CAM:  # position and counter restart
        shift = i[CAM_ORIGIN] + end * way
        i[CAM_ORIGIN] = 0
        i[COMMANDED] -= shift << 16
        i[ORIGIN] -= shift
        factor = 1 if i[CAM_TABLE] else i[CAM_FACTOR]
        i[CTR] = i[CAM_PHASE] // factor
    elif word & RELATIVE_CAM:
        i[CAM_ORIGIN] += end * way
    if i[CAM_F] == 0:  # absolute positions from here on
        i[CAM_ORIGIN] = 0


@sampled
def turn(i: Ints, v: Ints, moved: int) -> None:
    """Update the place in the cycle after a movement of the external encoder.

    A quarter of BASE or more in one sample is too fast: the zero point may be missed.
    """
    step = moved if i[CAM_TABLE] else moved * i[CAM_FACTOR]
    cycle = i[CAM_BASE] + i[CAM_DWELL]
    phase = i[CAM_PHASE] + step
    seen = -i[CAM_BASE] < 4 * step < i[CAM_BASE]
    way = 1 if phase >= cycle else (-1 if phase < 0 else 0)
    i[CAM_PHASE] = phase % cycle
    if seen and way != 0:
        cross(i, v, way)


@sampled
def cam_position(i: Ints, v: Ints) -> int:
    """Return the position at this place of the cycle, in counts, interpolated between the points; set CX."""
    base, size, phase = i[CAM_BASE], i[CAM_SIZE], i[CAM_PHASE]
    if phase >= base:
        i[CX] = size
        return entry(i, v, size)
    n = phase * size // base
    i[CX] = n
    here = entry(i, v, n)
    following = n + 1 if i[CAM_F] or n + 1 < size else 0  # otherwise the table is closed: the last point is the first
    return here + (entry(i, v, following) - here) * (phase * size - n * base) // base


@sampled
def cam(i: Ints, v: Ints, moved: int) -> None:
    """Compute one sample of mode cam."""
    before = i[COMMANDED]
    origin = i[ORIGIN]
    if moved != 0:
        turn(i, v, moved)
    i[COMMANDED] = (i[CAM_ORIGIN] + cam_position(i, v)) << 16
    i[VELOCITY] = i[COMMANDED] - before - ((i[ORIGIN] - origin) << 16)
