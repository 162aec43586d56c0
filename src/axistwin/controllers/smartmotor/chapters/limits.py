"""Limits (chapter 3): pins C and D, active high and directional, and limits in software."""

from typing import TYPE_CHECKING

from axistwin.controllers.smartmotor.chapters import io
from axistwin.controllers.smartmotor.kernel.kernel import beyond_minus, beyond_plus
from axistwin.controllers.smartmotor.kernel.state import BM, BP, LIMIT_C, LIMIT_D, SLN, SLP, SOFT_LIMITS

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor


def enable_soft(motor: "Motor") -> None:
    """SLE: a measured position at or beyond SLN or SLP is a limit fault.  Section 3.2."""
    motor.i[SOFT_LIMITS] = 1


def disable_soft(motor: "Motor") -> None:
    """SLD: no software limits.  The default.  3.2."""
    motor.i[SOFT_LIMITS] = 0


def soft_negative(motor: "Motor", value: int) -> None:
    """SLN=exp: in counts.  Ignored while the limits are enabled, "SLD before their values are changed" (3.2)."""
    _set(motor, SLN, value)


def soft_positive(motor: "Motor", value: int) -> None:
    """SLP=exp: in counts.  Ignored while the limits are enabled, "SLD before their values are changed" (3.2)."""
    _set(motor, SLP, value)


def _set(motor: "Motor", slot: int, value: int) -> None:
    if motor.i[SOFT_LIMITS]:
        motor.syntax_error()
    else:
        motor.i[slot] = value


def limit_pin_c(motor: "Motor") -> None:
    """UCP: pin C is the positive (right) limit: an input, high is a fault.  The default.  3.1.

    Where it was the brake's signal (5.1) it is that no more.
    """
    io.direction_in(motor, "C")
    motor.i[LIMIT_C] = 1


def limit_pin_d(motor: "Motor") -> None:
    """UDM: pin D is the negative (left) limit: an input, high is a fault.  The default.  3.1."""
    io.direction_in(motor, "D")
    motor.i[LIMIT_D] = 1


def directional(motor: "Motor") -> None:
    """LIMD: limits are directional; they always are in 4.76."""


def settle(motor: "Motor") -> None:
    """A limit that is no longer asserted reads 0 at once; one that is asserted is found by the next sample."""
    motor.i[BP] &= beyond_plus(motor.i)
    motor.i[BM] &= beyond_minus(motor.i)
