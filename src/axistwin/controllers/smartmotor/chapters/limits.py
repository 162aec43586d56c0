"""Limits (chapter 3): pins C and D, active high and directional, and limits in software."""

from axistwin.controllers.smartmotor.chapters import io
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.kernel import beyond_minus, beyond_plus
from axistwin.controllers.smartmotor.processor import Processor


def enable_soft(motor: Processor) -> None:
    """SLE: a measured position at or beyond SLN or SLP is a limit fault.  Section 3.2."""
    motor.i[s.SOFT_LIMITS] = 1


def disable_soft(motor: Processor) -> None:
    """SLD: disable the software limits.  At power-up, the software limits are disabled (manual, section 3.2)."""
    motor.i[s.SOFT_LIMITS] = 0


def soft_negative(motor: Processor, value: int) -> None:
    """SLN=exp: the negative software limit in counts; while enabled, it stays, and Bs is set (3.2)."""
    _set(motor, s.SLN, value)


def soft_positive(motor: Processor, value: int) -> None:
    """SLP=exp: the positive software limit in counts; while enabled, it stays, and Bs is set (3.2)."""
    _set(motor, s.SLP, value)


def _set(motor: Processor, slot: int, value: int) -> None:
    if motor.i[s.SOFT_LIMITS]:
        motor.syntax_error("the software limits are enabled: send SLD first")
    else:
        motor.i[slot] = value


def limit_pin_c(motor: Processor) -> None:
    """UCP: pin C is the positive (right) limit, high is a fault, not the brake's signal (5.1).  The default. 3.1."""
    io.direction_in(motor, "C")
    motor.i[s.LIMIT_C] = 1


def limit_pin_d(motor: Processor) -> None:
    """UDM: pin D is the negative (left) limit, high is a fault.  The default. 3.1."""
    io.direction_in(motor, "D")
    motor.i[s.LIMIT_D] = 1


def directional(motor: Processor) -> None:
    """LIMD: no effect, because limits are always directional in firmware 4.76."""


def update_flags(motor: Processor) -> None:
    """Clear the flags of limits that are no longer asserted.  The next sample sets the flags of asserted limits."""
    motor.i[s.BP] &= beyond_plus(motor.i)
    motor.i[s.BM] &= beyond_minus(motor.i)
