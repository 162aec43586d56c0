"""Chapters Joystick interface and Remote power shutdown: commands 10h to 14h, 95h."""

from axistwin.controllers.compumotor.state import IN_MOTION, SHUT_DOWN, State
from axistwin.sim.clock import Procedure


def disable_joystick(board: State) -> None:
    """Command 10h: end joystick control, even while the motor is moving."""
    disabled = board.joystick.disabled
    if board.joystick.enabled and disabled is not None and not disabled.triggered:
        disabled.succeed()


def enable_joystick(board: State) -> Procedure:
    """Command 11h: begin joystick control, until command 10h.  Ignored while shut down or moving."""
    if board.shutdown.on or board.moving:
        return SHUT_DOWN if board.shutdown.on else IN_MOTION
    board.motion.end = None
    disabled = board.clock.event()
    board.joystick.enable(disabled)
    board.refresh()
    try:
        yield disabled
    finally:
        board.joystick.disable()
    board.refresh()
    return None


def shut_down(board: State, on: bool) -> str | None:
    """Command 12h: switch the current in the motor windings off, or on again.

    While the current is off (remote power shutdown), the board performs no moves.  Ignored if the joystick or the
    shutdown input is enabled, or while moving.
    """
    if board.occupied:
        return IN_MOTION
    if board.shutdown.input_enabled:
        return "the shutdown input is enabled: send 13 00 first"
    board.shutdown.commanded = on
    board.shutdown.refresh()
    return None


def enable_shutdown_input(board: State, on: bool) -> str | None:
    """Command 13h: enable or disable the shutdown input.  Ignored if the joystick is enabled."""
    if board.joystick.enabled:
        return IN_MOTION
    board.shutdown.input_enabled = on
    board.shutdown.refresh()
    return None


def set_direction_sense(board: State, ccw_is_plus: bool) -> str | None:
    """Command 14h: define CW (00) or CCW as the + direction; positions stay.  Ignored while moving."""
    if board.occupied:
        return IN_MOTION
    board.pulses.cw_is_plus = not ccw_is_plus
    board.loop.encoder.face(-1 if ccw_is_plus else +1)
    return None


def request_joystick(board: State) -> bytes:
    """Command 95h: report the level of the input `remote_enable`: 00 (low) is a request for control, FF is none."""
    return b"\xff" if board.pins["remote_enable"].level else b"\0"
