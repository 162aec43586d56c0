"""Host mode (chapter 10): one sample of the trajectory between the points that the host has sent."""

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.jit import sampled
from axistwin.controllers.smartmotor.kernel.physics import Ints

GOES_ON, UNDERFLOW, EXIT, LAST = range(4)


@sampled
def host(i: Ints, ring: Ints) -> int:
    """Compute one sample of host mode.  Return GOES_ON, UNDERFLOW, EXIT, or LAST at the end of the last point's
    segment.
    """
    size = i[s.HOST_SIZE]
    here = i[s.HOST_HEAD]
    following = (here + 2) % size
    if not i[s.HOST_STARTED]:
        if i[s.HOST_COUNT] == 0:
            return UNDERFLOW
        i[s.HOST_STARTED] = 1
        i[s.COMMANDED], i[s.HOST_CLOCK] = ring[here] << 16, ring[here + 1]
    if i[s.HOST_LEFT] == 0:
        if i[s.HOST_COUNT] < 2:
            return UNDERFLOW
        samples = ring[following + 1] - ring[here + 1]
        if samples == 0:
            return EXIT
        i[s.VELOCITY] = ((ring[following] - ring[here]) << 16) // samples
        i[s.HOST_LEFT] = samples
    i[s.COMMANDED] += i[s.VELOCITY]
    i[s.HOST_LEFT] -= 1
    i[s.HOST_CLOCK] += 1
    if i[s.HOST_LEFT] > 0:
        return GOES_ON
    i[s.COMMANDED] = ring[following] << 16
    i[s.HOST_HEAD] = following
    i[s.HOST_COUNT] -= 1
    if i[s.HOST_COUNT] < 2:
        return LAST
    return EXIT if ring[(following + 2) % size + 1] == ring[following + 1] else GOES_ON
