"""Chapters Joystick interface and Remote power shutdown: commands 10h to 14h, 95h."""

from axistwin.controllers.compumotor.state import State
from axistwin.sim.clock import Procedure


def disable_joystick(board: State) -> None:
    """Command 10h: end the joystick's control, whether the motor is moving or not."""
    disabled = board.joystick.disabled
    if board.joystick.enabled and disabled is not None and not disabled.triggered:
        disabled.succeed()


def enable_joystick(board: State) -> Procedure:
    """Command 11h: give control to the joystick until 10h.  Ignored if shut down or moving."""
    if board.shutdown.on or board.moving:
        return
    board.motion.end = None
    yield from board.joystick.control(board.clock.event())
    board.refresh()


def shut_down(board: State, on: bool) -> None:
    """Command 12h: remote power shutdown on or off.  While it is on, there are no moves.

    Ignored if the joystick or the shutdown input is enabled, or while moving.
    """
    if not (board.occupied or board.shutdown.input_enabled):
        board.shutdown.commanded = on
        board.shutdown.refresh()


def enable_shutdown_input(board: State, on: bool) -> None:
    """Command 13h: enable or disable the shutdown input.  Ignored if the joystick is enabled."""
    if not board.joystick.enabled:
        board.shutdown.input_enabled = on
        board.shutdown.refresh()


def set_direction_sense(board: State, ccw_is_plus: bool) -> None:
    """Command 14h: CW is + (00) or CCW is +.  Moves keep their signs, positions their values.  Ignored while moving."""
    if not board.occupied:
        board.pulses.cw_is_plus = not ccw_is_plus
        board.loop.encoder.face(-1 if ccw_is_plus else +1)


def request_joystick(board: State) -> bytes:
    """Command 95h: the joystick's request, FF while its input is high."""
    return b"\xff" if board.pins["remote_enable"].level else b"\0"
