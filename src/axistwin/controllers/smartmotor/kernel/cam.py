"""Cam mode (chapter 9): the position follows a table, aw[0] to aw[SIZE], over the counts of the external encoder.

aw[1]  ╱╲          BASE counts are one cycle; then, with F=16 or F=128, D counts of dwell at the last position.
      ╱  ╲____     Passing the end of base plus dwell, or aw[0] backwards, is crossing the zero point: there, a cycle
aw[0]╱ aw[2] D     begins at the end of the last cycle, and after CI changed parameters come into force.
"""

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.physics import Ints

RELATIVE_CAM, MODULO_CAM = 16, 128
DWELLING = RELATIVE_CAM | MODULO_CAM  # Bits of F that enable the dwell.
TABLE_MOST = 101


@sampled
def entry(i: Ints, v: Ints, n: int) -> int:
    """Return table entry aw[n] in counts; multiplied by the factor of MCn if CAM_TABLE is 1."""
    word = v[i[s.ARRAY_BASE] + n // 2]
    word = word >> 16 if n % 2 == 0 else (word & 0xFFFF ^ 0x8000) - 0x8000
    return word * i[s.CAM_FACTOR] if i[s.CAM_TABLE] else word


@sampled
def take_over(i: Ints) -> None:
    """Commands G and CI: make the buffered cam parameters effective."""
    i[s.CAM_BASE], i[s.CAM_SIZE], i[s.CAM_FACTOR] = i[s.MC_BASE], i[s.MC_SIZE], i[s.MC_FACTOR]
    i[s.CAM_F] = i[s.F] & DWELLING
    i[s.CAM_DWELL] = max(i[s.D], 0) if i[s.CAM_F] else 0
    i[s.CI_PENDING] = i[s.CI_SPOILT] = 0


def invalidate(i: Ints) -> None:
    """Cancel a CI that waits for the zero point after a changed parameter; the next CI needs an MCn (9.5)."""
    if i[s.CI_PENDING]:
        i[s.CI_PENDING], i[s.CI_SPOILT] = 0, 1


@sampled
def cross(i: Ints, v: Ints, way: int) -> None:
    """Handle a crossing of the cam's zero point, forwards (+1) or backwards (-1)."""
    end = entry(i, v, i[s.CAM_SIZE])
    cycle = i[s.CAM_BASE] + i[s.CAM_DWELL]
    word = i[s.CAM_F]
    # Position of the external encoder relative to the zero point of the cam, in counts
    left = i[s.CAM_PHASE] if way > 0 else i[s.CAM_PHASE] - cycle
    if way > 0 and i[s.CI_PENDING]:
        take_over(i)
    elif i[s.CI_PENDING]:
        take_over(i)
        # The command CI may have changed the size of the cam table, so read the last entry again.
        end = entry(i, v, i[s.CAM_SIZE])
        i[s.CAM_PHASE] = max(left + i[s.CAM_BASE] + i[s.CAM_DWELL], 0)
    if word & MODULO_CAM:  # With F=128, each new cam cycle resets the motor's position and the counter CTR.
        shift = i[s.CAM_ORIGIN] + end * way
        i[s.CAM_ORIGIN] = 0
        i[s.COMMANDED] -= shift << 16
        i[s.ORIGIN] -= shift
        factor = 1 if i[s.CAM_TABLE] else i[s.CAM_FACTOR]
        i[s.CTR] = i[s.CAM_PHASE] // factor
    elif word & RELATIVE_CAM:
        i[s.CAM_ORIGIN] += end * way
    # If the cam options F=16 and F=128 are both off, the positions in the cam table are absolute.
    if i[s.CAM_F] == 0:
        i[s.CAM_ORIGIN] = 0


@sampled
def turn(i: Ints, v: Ints, moved: int) -> None:
    """Update the phase of the cam cycle after a movement of the external encoder.

    A movement of a quarter of BASE or more in one sample is too fast: the zero point may be missed.
    """
    step = moved if i[s.CAM_TABLE] else moved * i[s.CAM_FACTOR]
    cycle = i[s.CAM_BASE] + i[s.CAM_DWELL]
    phase = i[s.CAM_PHASE] + step
    seen = -i[s.CAM_BASE] < 4 * step < i[s.CAM_BASE]
    way = 1 if phase >= cycle else (-1 if phase < 0 else 0)
    i[s.CAM_PHASE] = phase % cycle
    if seen and way != 0:
        cross(i, v, way)


@sampled
def cam_position(i: Ints, v: Ints) -> int:
    """Return the interpolated position in counts at the present place in the cycle, and set CX."""
    base, size, phase = i[s.CAM_BASE], i[s.CAM_SIZE], i[s.CAM_PHASE]
    if phase >= base:
        i[s.CX] = size
        return entry(i, v, size)
    n = phase * size // base
    i[s.CX] = n
    here = entry(i, v, n)
    # Without the cam options F=16 and F=128, the cam table describes a closed curve.
    following = n + 1 if i[s.CAM_F] or n + 1 < size else 0
    return here + (entry(i, v, following) - here) * (phase * size - n * base) // base


@sampled
def cam(i: Ints, v: Ints, moved: int) -> None:
    """Compute the commanded position in cam mode for one servo sample."""
    before = i[s.COMMANDED]
    origin = i[s.ORIGIN]
    if moved != 0:
        turn(i, v, moved)
    i[s.COMMANDED] = (i[s.CAM_ORIGIN] + cam_position(i, v)) << 16
    i[s.VELOCITY] = i[s.COMMANDED] - before - ((i[s.ORIGIN] - origin) << 16)
