"""Host mode (chapter 10): the host sends positions and the clock values at which they are to be reached.

position  ╱──●      Between two points the position is straight in time.  A clock value may be left out: the last
       ●─╱          difference holds.  The same clock value twice ends host mode: the buffered mode goes on from the
 ●────╱             position and the velocity reached (10.2).  Nothing more to do without that is an underflow.
 clock →
"""

from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

GOES_ON, UNDERFLOW, EXIT, LAST = range(4)
CLOCK_TURN = 1 << 32


@sampled
def host(i: Ints, ring: Ints) -> int:
    """One sample of host mode: GOES_ON, UNDERFLOW, EXIT, or LAST: this was the end of the last point's segment."""
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


class Reception:
    """What of the host's records has not become a point yet."""

    def __init__(self) -> None:
        self.position: int | None = None
        """A position that waits for its clock value."""
        self.clock: int | None = None
        """The last point's clock value."""
        self.delta: int | None = None
        """The difference between the last two clock values."""


def clear(motor: "Motor") -> None:
    """MD: an empty buffer."""
    motor.reception = Reception()
    motor.i[HOST_HEAD] = motor.i[HOST_COUNT] = motor.i[HOST_LEFT] = motor.i[HOST_STARTED] = 0


def position(motor: "Motor", value: int) -> None:
    """Record 0xFA: a position in counts.  The one before it, if it still lacks its clock value, gets the next one."""
    complete(motor)
    motor.reception.position = value


def clock(motor: "Motor", value: int) -> None:
    """Record 0xFB: the clock value, in samples, of the position before it; the value of the last point again: exit.

    The clock has 32 bits and goes on from FFFFFFFFh at 0.  A value behind the last point's sets Bs.
    """
    waiting = motor.reception
    ahead = 0 if waiting.clock is None else (value - waiting.clock) % CLOCK_TURN
    if ahead >= CLOCK_TURN // 2:
        motor.syntax_error()
    elif waiting.clock is not None and ahead == 0:
        waiting.position = None
        _append(motor, 0, waiting.clock)
    elif waiting.position is not None:
        _point(motor, value % CLOCK_TURN if waiting.clock is None else waiting.clock + ahead)


def complete(motor: "Motor") -> bool:
    """Give the position that waits for its clock value the usual one; returns whether there is one."""
    waiting = motor.reception
    if waiting.position is None or waiting.clock is None or waiting.delta is None:
        return False
    _point(motor, waiting.clock + waiting.delta)
    return True


def free(motor: "Motor") -> int:
    """How many points still find room."""
    return len(motor.ring) // 2 - motor.i[HOST_COUNT]


def _point(motor: "Motor", clock: int) -> None:
    waiting = motor.reception
    assert waiting.position is not None
    if waiting.clock is not None:
        waiting.delta = clock - waiting.clock
    _append(motor, waiting.position, clock)
    waiting.position, waiting.clock = None, clock


def _append(motor: "Motor", position: int, clock: int) -> None:
    """Put a point into the buffer; without room it is lost, which is a communication overflow."""
    if not free(motor):
        motor.overflow()
        return
    at = (motor.i[HOST_HEAD] + 2 * motor.i[HOST_COUNT]) % len(motor.ring)
    motor.ring[at], motor.ring[at + 1] = position, clock
    motor.i[HOST_COUNT] += 1
