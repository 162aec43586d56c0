"""Positions of the shaft in the controller's coordinates, which `O=` and F=2 change, and wrapping to 32 bits."""

from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.physics import Ints
from axistwin.controllers.smartmotor.kernel.state import COMMANDED, DIRECTION, ORIGIN, SHAFT


@sampled
def wrapped(value: int) -> int:
    """Return the low 32 bits of a number as a signed integer."""
    return ((value + (1 << 31)) & 0xFFFF_FFFF) - (1 << 31)


@sampled
def position(i: Ints) -> int:
    """Return the position of the shaft in counts, without overflow at 32 bits."""
    return i[DIRECTION] * i[SHAFT] + i[ORIGIN]


@sampled
def commanded_shaft(i: Ints) -> int:
    return i[DIRECTION] * ((i[COMMANDED] >> 16) - i[ORIGIN])


@sampled
def actual_position(i: Ints) -> int:
    """Return `@P`, the position of the shaft in counts, as a 32-bit number."""
    return wrapped(position(i))


@sampled
def following_error(i: Ints) -> int:
    """Return `@PE`, the commanded minus the actual position in counts, as a 32-bit number."""
    return wrapped((i[COMMANDED] >> 16) - position(i))
