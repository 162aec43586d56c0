"""Limits (chapter 3): pins C and D, active high and directional, and limits in software."""

from axistwin.controllers.smartmotor.chapters import io
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.kernel import beyond_minus, beyond_plus
from axistwin.controllers.smartmotor.processor import Processor


def enable_soft(motor: Processor) -> None:
    """SLE: enable the software limits SLN and SLP (manual, section 3.2).

    A position of SLN or less, or of SLP or more, is then a fault.
    """
    motor.i[s.SOFT_LIMITS] = 1


def disable_soft(motor: Processor) -> None:
    """SLD: disable the software limits.  At power-up, the software limits are disabled (manual, section 3.2)."""
    motor.i[s.SOFT_LIMITS] = 0


def soft_negative(motor: Processor, value: int) -> None:
    """SLN=exp: set the negative software limit, in counts (manual, section 3.2).

    While the software limits are enabled, SLN= does not change the limit, but sets the flag Bs.
    """
    _set(motor, s.SLN, value)


def soft_positive(motor: Processor, value: int) -> None:
    """SLP=exp: set the positive software limit, in counts (manual, section 3.2).

    While the software limits are enabled, SLP= does not change the limit, but sets the flag Bs.
    """
    _set(motor, s.SLP, value)


def _set(motor: Processor, slot: int, value: int) -> None:
    if motor.i[s.SOFT_LIMITS]:
        motor.syntax_error("the software limits are enabled: send SLD first")
    else:
        motor.i[slot] = value


def limit_pin_c(motor: Processor) -> None:
    """UCP: make pin C the input of the positive (right) limit (manual, section 3.1).

    A high level is a fault.  UCP is the default.

    The pin is no longer the brake's signal (manual, section 5.1).
    """
    io.direction_in(motor, "C")
    motor.i[s.LIMIT_C] = 1


def limit_pin_d(motor: Processor) -> None:
    """UDM: make pin D the input of the negative (left) limit (manual, section 3.1).

    A high level is a fault.  UDM is the default.
    """
    io.direction_in(motor, "D")
    motor.i[s.LIMIT_D] = 1


def directional(motor: Processor) -> None:
    """LIMD: no effect, because limits are always directional in firmware 4.76."""


def update_flags(motor: Processor) -> None:
    """Clear the flags of limits that are no longer asserted: Bp (positive limit) and Bm (negative limit).

    The next servo sample sets the flags of asserted limits.
    """
    motor.i[s.BP] &= beyond_plus(motor.i)
    motor.i[s.BM] &= beyond_minus(motor.i)
