"""Host mode (chapter 10): one sample of the trajectory between the points that the host has sent."""

from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.machine import Ints
from axistwin.controllers.smartmotor.kernel.state import (
    COMMANDED,
    HOST_CLOCK,
    HOST_COUNT,
    HOST_HEAD,
    HOST_LEFT,
    HOST_SIZE,
    HOST_STARTED,
    VELOCITY,
)

GOES_ON, UNDERFLOW, EXIT, LAST = range(4)


@sampled
def host(i: Ints, ring: Ints) -> int:
    """Compute one sample of host mode.  Return GOES_ON, UNDERFLOW, EXIT, or LAST at the end of the last point's
    segment.
    """
    size = i[HOST_SIZE]
    here = i[HOST_HEAD]
    following = (here + 2) % size
    if not i[HOST_STARTED]:
        if i[HOST_COUNT] == 0:
            return UNDERFLOW
        i[HOST_STARTED] = 1
        i[COMMANDED], i[HOST_CLOCK] = ring[here] << 16, ring[here + 1]
    if i[HOST_LEFT] == 0:
        if i[HOST_COUNT] < 2:
            return UNDERFLOW
        samples = ring[following + 1] - ring[here + 1]
        if samples == 0:
            return EXIT
        i[VELOCITY] = ((ring[following] - ring[here]) << 16) // samples
        i[HOST_LEFT] = samples
    i[COMMANDED] += i[VELOCITY]
    i[HOST_LEFT] -= 1
    i[HOST_CLOCK] += 1
    if i[HOST_LEFT] > 0:
        return GOES_ON
    i[COMMANDED] = ring[following] << 16
    i[HOST_HEAD] = following
    i[HOST_COUNT] -= 1
    if i[HOST_COUNT] < 2:
        return LAST
    return EXIT if ring[(following + 2) % size + 1] == ring[following + 1] else GOES_ON
