"""Brake functions (chapter 5): the static brake and its signals, and dynamic braking by shorted windings (MTB)."""

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.processor import Control, Processor

PIN_C, PIN_G = 1 << s.USER_PINS.index("C"), 1 << s.USER_PINS.index("G")
SIGNALS = {"C": PIN_C, "G": PIN_G}  # The pins that can carry the brake's signal, by their bits.


def servo(motor: Processor) -> None:
    """BRKSRV: the brake is released while the servo is on (Bo = 0).  The default.  Section 5.2."""
    motor.brake_control = Control.SERVO


def trajectory_brake(motor: Processor) -> None:
    """BRKTRJ: the brake is released while a trajectory is in progress (Bt = 1); otherwise MTB is active.  5.2."""
    motor.brake_control = Control.TRAJECTORY


def release(motor: Processor) -> None:
    """BRKRLS: release the brake.  A later OFF deactivates MTB until the next command MTB (5.2)."""
    motor.brake_control = Control.RELEASED


def engage(motor: Processor) -> None:
    """BRKENG: the brake is engaged.  BRKENG does not activate MTB.  5.2."""
    motor.brake_control = Control.ENGAGED


def internal(motor: Processor) -> None:
    """BRKI: send the brake signal to the internal brake pin only.  This is the default (manual, section 5.1)."""
    motor.i[s.BRAKE_PIN] = 0


def pin_c(motor: Processor) -> None:
    """BRKC: send the brake signal also to pin C, if UCO has made it an output.  Ends BRKG. 5.1."""
    motor.i[s.BRAKE_PIN] = PIN_C


def pin_g(motor: Processor) -> None:
    """BRKG: send the brake signal also to pin G, if UGO has made it an output.  Ends BRKC. 5.1."""
    motor.i[s.BRAKE_PIN] = PIN_G


def mode_torque_brake(motor: Processor) -> None:
    """MTB: short the windings now and whenever the motor is off, until BRKRLS followed by OFF.  5.2."""
    motor.mtb_enabled = True
    switch_off(motor)


def switch_off(motor: Processor, mode: int = s.M_OFF) -> None:
    """Switch the servo off: enter this mode, or mode torque brake while MTB is enabled."""
    i = motor.i
    i[s.MODE] = s.M_BRAKE if motor.mtb_enabled else mode
    i[s.BT] = i[s.STOPPING] = i[s.VELOCITY] = 0
    i[s.BO] = 1


def update_outputs(motor: Processor) -> None:
    """Set the state of the windings (driven, open or shorted), of the static brake and of the brake signals.

    Called after a change of the flags Bt or Bo, or of the signal that controls the brake.
    """
    i = motor.i
    if motor.brake_control is Control.TRAJECTORY and motor.mtb_enabled and not i[s.BT] and i[s.MODE] >= s.M_HOLD:
        switch_off(motor)
        i[s.BO] = 0
    if i[s.MODE] == s.M_BRAKE:
        i[s.DRIVE] = s.DRIVE_SHORTED
    else:
        i[s.DRIVE] = s.DRIVE_OPEN if i[s.BO] else s.DRIVE_ON
    on = engaged(motor)
    i[s.BRAKE] = on and motor.options.brake
    motor.brake_line.set(on)
    for name, bit in SIGNALS.items():
        if i[s.BRAKE_PIN] == bit and motor.pins[name].is_output:
            motor.pins[name].output(on)


def engaged(motor: Processor) -> bool:
    """True if the static brake must be engaged."""
    match motor.brake_control:
        case Control.SERVO:
            return bool(motor.i[s.BO])
        case Control.TRAJECTORY:
            return not motor.i[s.BT]
        case Control.ENGAGED:
            return True
    return False
