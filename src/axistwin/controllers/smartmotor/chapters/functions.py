"""The command F= (chapter 7), which sets a word of option bits."""

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.cam import DWELLING, invalidate
from axistwin.controllers.smartmotor.kernel.position import position
from axistwin.controllers.smartmotor.processor import Processor

DECELERATE, REVERSE, CHANNEL_1, CLEAR_INTEGRAL, _, CALL_C1, _, _ = (1 << n for n in range(8))
ALL = 255


def functions(motor: Processor, value: int) -> None:
    """F=exp: switch functions of the motor on or off, e.g. F=2 reverses the direction of the shaft.

    Each bit of the value (0 to 255) switches one function (manual, table 7.1).  Any other value sets Bs.

    F=2 reverses the shaft's direction at once, in every mode; the position keeps its value.  In mode cam, a change of
    the bits 16 or 128 takes effect after CI, and invalidates an earlier CI (manual, section 9.5).
    """
    if not 0 <= value <= ALL:
        motor.syntax_error(f"{value} is out of range: expected 0 to {ALL}")
        return
    i = motor.i
    changed = i[s.F] ^ value
    i[s.F] = value
    if changed & REVERSE:
        kept = position(i)
        i[s.DIRECTION] = -1 if value & REVERSE else 1
        i[s.ORIGIN] = kept - i[s.DIRECTION] * i[s.SHAFT]
    if changed & DWELLING:
        invalidate(i)
