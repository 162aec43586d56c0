"""Host mode (chapter 10): the host sends positions, each with the clock value at which the motor reaches the position.

position  ╱──●      Between two points the velocity is constant.  A clock value may be omitted: the last difference
       ●─╱          then applies.  The same clock value twice ends host mode: the buffered mode continues from the
 ●────╱             position and the velocity reached (manual, section 10.2).  A buffer that becomes empty
                     otherwise is an underflow.
 clock →
"""

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.processor import Processor, Reception

CLOCK_TURN = 1 << 32
QUERY = 0xF9
RUNNING, UNDERFLOW, OVERFLOW, TIME_DELTA, ENTERED, PENDING = 0x80, 0x40, 0x20, 0x04, 0x02, 0x01
MOST_PLACES = 127


def clear(motor: Processor) -> None:
    """MD: delete all trajectory points that the host has sent for host mode."""
    motor.reception = Reception()
    motor.i[s.HOST_HEAD] = motor.i[s.HOST_COUNT] = motor.i[s.HOST_LEFT] = motor.i[s.HOST_STARTED] = 0


def position(motor: Processor, value: int) -> None:
    """Record 0xFA: a position in counts.  A preceding position without a clock value gets the last clock difference."""
    complete(motor)
    motor.reception.position = value


def clock(motor: Processor, value: int) -> None:
    """Binary record 0xFB: receive the time at which the motor must reach the last received position.

    The time is a clock value in samples.  The same clock value a second time ends host mode.  The clock has 32 bits; 0
    follows FFFFFFFFh.  A clock value before the last clock value sets Bs.
    """
    waiting = motor.reception
    ahead = 0 if waiting.clock is None else (value - waiting.clock) % CLOCK_TURN
    if ahead >= CLOCK_TURN // 2:
        motor.i[s.HOST_FLAGS] |= TIME_DELTA
        motor.syntax_error()
    elif waiting.clock is not None and ahead == 0:
        waiting.position = None
        _append(motor, 0, waiting.clock)
    elif waiting.position is not None:
        _point(motor, value % CLOCK_TURN if waiting.clock is None else waiting.clock + ahead)


def complete(motor: Processor) -> None:
    """Complete a position that has no clock value with the last clock difference, if both exist."""
    waiting = motor.reception
    if waiting.position is not None and waiting.clock is not None and waiting.delta is not None:
        _point(motor, waiting.clock + waiting.delta)


def status(motor: Processor) -> bytes:
    """Return the answer to the byte F9h and to Q: five bytes, F9h first.

    While the trajectory runs: 80h + free places, and 24 bits of its clock.  Otherwise flags (40h underflow, 20h
    overflow, 04h invalid time delta, 02h in host mode, 01h waiting for G), free places, and 16 bits of the clock.  The
    errors are kept until the next MD.
    """
    i = motor.i
    places, clock = min(_free(motor), MOST_PLACES), i[s.HOST_CLOCK]
    entered = i[s.MODE] == s.M_HOST
    if entered and i[s.HOST_STARTED]:
        return bytes((QUERY, RUNNING | places)) + (clock & 0xFFFFFF).to_bytes(3, "big")
    flags = i[s.HOST_FLAGS] | ENTERED * entered | PENDING * i[s.HOST_ARMED]
    return bytes((QUERY, flags, places)) + (clock & 0xFFFF).to_bytes(2, "big")


def _free(motor: Processor) -> int:
    return len(motor.ring) // 2 - motor.i[s.HOST_COUNT]


def _point(motor: Processor, clock: int) -> None:
    waiting = motor.reception
    assert waiting.position is not None
    if waiting.clock is not None:
        waiting.delta = clock - waiting.clock
    _append(motor, waiting.position, clock)
    waiting.position, waiting.clock = None, clock


def _append(motor: Processor, position: int, clock: int) -> None:
    """Append a point to the buffer.  If the buffer is full, drop the point and flag a communication overflow."""
    if not _free(motor):
        motor.i[s.HOST_FLAGS] |= OVERFLOW
        motor.overflow()
        return
    at = (motor.i[s.HOST_HEAD] + 2 * motor.i[s.HOST_COUNT]) % len(motor.ring)
    motor.ring[at], motor.ring[at + 1] = position, clock
    motor.i[s.HOST_COUNT] += 1
