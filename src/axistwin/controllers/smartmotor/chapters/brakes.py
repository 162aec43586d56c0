"""Brake functions (chapter 5): the static brake and its signals, and dynamic braking by shorted windings (MTB)."""

from enum import Enum
from typing import TYPE_CHECKING

from axistwin.controllers.smartmotor.kernel.state import (
    BO,
    BRAKE,
    BRAKE_PIN,
    BT,
    DRIVE,
    DRIVE_ON,
    DRIVE_OPEN,
    DRIVE_SHORTED,
    M_BRAKE,
    M_HOLD,
    M_OFF,
    MODE,
    STOPPING,
    USER_PINS,
    VELOCITY,
)

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor


PIN_C, PIN_G = 1 << USER_PINS.index("C"), 1 << USER_PINS.index("G")
SIGNALS = {"C": PIN_C, "G": PIN_G}
"""The pins that can carry the brake's signal, by their bits."""


class Control(Enum):
    """What works the static brake."""

    SERVO = "BRKSRV"
    TRAJECTORY = "BRKTRJ"
    RELEASED = "BRKRLS"
    ENGAGED = "BRKENG"


def servo(motor: "Motor") -> None:
    """BRKSRV: the brake is released while the servo is on (Bo = 0).  The default.  Section 5.2."""
    motor.brake_control = Control.SERVO


def trajectory_brake(motor: "Motor") -> None:
    """BRKTRJ: the brake is released while a trajectory is in progress (Bt = 1); without one MTB is active.  5.2."""
    motor.brake_control = Control.TRAJECTORY


def release(motor: "Motor") -> None:
    """BRKRLS: the brake is released.  OFF after this deactivates MTB until the command MTB.  5.2."""
    motor.brake_control = Control.RELEASED


def engage(motor: "Motor") -> None:
    """BRKENG: the brake is engaged.  It does not activate MTB.  5.2."""
    motor.brake_control = Control.ENGAGED


def internal(motor: "Motor") -> None:
    """BRKI: the signal is on the internal brake pin only.  The default.  5.1."""
    motor.i[BRAKE_PIN] = 0


def pin_c(motor: "Motor") -> None:
    """BRKC: the signal is on pin C too, if UCO has made that an output.  Not together with BRKG.  5.1."""
    motor.i[BRAKE_PIN] = PIN_C


def pin_g(motor: "Motor") -> None:
    """BRKG: the signal is on pin G too, if UGO has made that an output.  Not together with BRKC.  5.1."""
    motor.i[BRAKE_PIN] = PIN_G


def mode_torque_brake(motor: "Motor") -> None:
    """MTB: the windings are shorted at once, and again whenever the motor is off, until BRKRLS and OFF.  5.2."""
    motor.mtb_enabled = True
    switch_off(motor)


def switch_off(motor: "Motor", mode: int = M_OFF) -> None:
    """The servo is off in this mode, or with shorted windings while MTB is enabled."""
    i = motor.i
    i[MODE] = M_BRAKE if motor.mtb_enabled else mode
    i[BT] = i[STOPPING] = i[VELOCITY] = 0
    i[BO] = 1


def settle(motor: "Motor") -> None:
    """After anything that may have changed Bt, Bo or the brake's control: windings, brake and signals follow."""
    i = motor.i
    if motor.brake_control is Control.TRAJECTORY and motor.mtb_enabled and not i[BT] and i[MODE] >= M_HOLD:
        switch_off(motor)
    if i[MODE] == M_BRAKE:
        i[DRIVE] = DRIVE_SHORTED
    else:
        i[DRIVE] = DRIVE_OPEN if i[BO] else DRIVE_ON
    on = engaged(motor)
    i[BRAKE] = on and motor.options.brake
    motor.brake_line.set(on)
    for name, bit in SIGNALS.items():
        if i[BRAKE_PIN] == bit and motor.pins[name].is_output:
            motor.pins[name].output(on)


def engaged(motor: "Motor") -> bool:
    """Whether the static brake is to be engaged."""
    match motor.brake_control:
        case Control.SERVO:
            return bool(motor.i[BO])
        case Control.TRAJECTORY:
            return not motor.i[BT]
        case Control.ENGAGED:
            return True
    return False
