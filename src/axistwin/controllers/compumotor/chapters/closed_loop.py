"""Commands of the position tracking addendum: 18h, 19h, 2Fh, 35h to 37h, 98h to 9Fh, B0h to B5h."""

from dataclasses import replace

from axistwin.controllers.compumotor.chapters import moves
from axistwin.controllers.compumotor.chapters.requests import position_bytes
from axistwin.controllers.compumotor.chapters.tracking import wake
from axistwin.controllers.compumotor.parts.library import Kind
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES
from axistwin.controllers.compumotor.parts.tracking import Law, wrapped
from axistwin.controllers.compumotor.state import IN_MOTION, State
from axistwin.sim.clock import Procedure


def define_position(board: State, position: int) -> str | None:
    """Command 2Fh: set the closed-loop position to `position`, in encoder pulses.  The motor does not move.

    Ignored while moving.  Every signed 32-bit number is valid.
    """
    if board.occupied:
        return IN_MOTION
    board.loop.define(position)
    board.refresh()
    return None


def go(kind: Kind, board: State, target: int) -> Procedure:
    """Commands 35h and 36h: move by a distance (35h) or to a position (36h) in encoder pulses, at default velocity.

    Needs the default move (31h) and B0h to B4h. Ignored while moving or shut down, and beyond 2³¹-1 motor pulses.
    """
    if not board.loop.complete:
        return "B0 to B4 (ratio, resolution, sigma, algorithm, teeth) must be sent first"
    return (yield from moves.perform_default(board, kind, target))


def resume(board: State) -> Procedure:
    """Command 37h: move again to the target of the last closed-loop move.

    The velocity and the acceleration are also those of the last closed-loop move.  Ignored without an earlier
    closed-loop move.  Loose sheet on command 37h.
    """
    if board.loop.commanded is None:
        return "no closed-loop move has been sent: send 35 or 36 first"
    move, target = board.loop.commanded
    again = replace(move, kind=Kind.ABSOLUTE_ENCODER, target=wrapped(target - board.loop.zero))
    return (yield from moves.perform(board, again, board.library.calculation_ns))


def maintain(board: State, on: bool) -> None:
    """Command 18h: switch position maintenance on or off.

    Off after reset.  While it is on, preset open-loop moves (33h, 34h, C8h, CBh) are ignored.
    """
    board.loop.on = on
    if not on:
        board.loop.give_way()
    wake(board)


def end_on_stall(board: State, on: bool) -> None:
    """Command 19h: define whether a stall ends the move.  After reset, a stall does not end the move."""
    board.loop.ends_stalled_moves = on


def set_ratio(board: State, motor: int, encoder: int) -> None:
    """Command B0h: define the ratio of motor pulses to encoder pulses (encoder lines x 4); both are positive."""
    board.loop.ratio = motor, encoder
    wake(board)


def set_resolution(board: State, resolution: int) -> None:
    """Command B1h: define the motor pulses per revolution."""
    board.loop.resolution = resolution
    wake(board)


def set_sigma(board: State, sigma: int) -> None:
    """Command B2h: define the total backlash between motor and encoder, in motor pulses."""
    board.loop.sigma = sigma
    wake(board)


def set_law(board: State, algorithm: int, gain: int, ranges: int, maximum: int) -> str | None:
    """Command B3h: select the formula for the velocity at which the motor corrects a position error.

    Algorithm 1 is K·e, algorithm 2 is K·√e, and algorithm 3 is K·e².  The position error is e, and `gain` is K.  The
    velocity is at most `maximum`.  The calculated velocity and `maximum` are in units of the velocity range.  The
    command is ignored if `maximum` is beyond the range.
    """
    velocities = VELOCITY_RANGES[ranges >> 4]
    if velocities.rate(maximum) is None:
        return f"velocity {maximum} is beyond its range: expected at most {velocities.highest}"
    board.loop.law = Law(algorithm, gain, ranges, maximum)
    wake(board)
    return None


def set_teeth(board: State, teeth: int) -> None:
    """Command B4h: define the number of rotor teeth of the motor."""
    board.loop.teeth = teeth
    wake(board)


def set_deadband(board: State, deadband: int) -> None:
    """Command B5h: define the deadband in encoder pulses.  State 80h: error within the deadband. 1811 only."""
    board.loop.deadband = deadband
    board.refresh()


def relative_count(board: State) -> bytes:
    """Command 98h: encoder pulses since the start of the present move, or of the whole last move."""
    return position_bytes(board.loop.relative)


def error(board: State) -> bytes:
    """Command 99h: report the desired position minus the actual position, in encoder pulses."""
    return position_bytes(board.loop.error)


def absolute_count(board: State) -> bytes:
    """Command 9Ah: report the distance from absolute zero to the present position, in encoder pulses."""
    return position_bytes(board.loop.absolute)


def slip(board: State) -> bytes:
    """Command 9Bh: rotor teeth slipped since absolute zero was defined (30h); 0 without B0h, B1h and B4h."""
    return position_bytes(min(board.loop.slipped(board.absolute, board.loop.absolute), 0xFFFF))


def ratio(board: State) -> bytes:
    """Command 9Ch: the ratio that B0h has defined; zeros before B0h."""
    motor, encoder = board.loop.ratio or (0, 0)
    return position_bytes(motor, 2) + position_bytes(encoder, 2)


def resolution(board: State) -> bytes:
    """Command 9Dh: the motor pulses per revolution that B1h has defined; 0 before B1h."""
    return position_bytes(board.loop.resolution or 0)


def sigma(board: State) -> bytes:
    """Command 9Eh: the backlash in motor pulses that B2h has defined; 0 before B2h."""
    return position_bytes(board.loop.sigma or 0)


def law(board: State) -> bytes:
    """Command 9Fh: algorithm, K, range and maximum velocity that B3h has defined; zeros before B3h."""
    found = board.loop.law
    return (
        position_bytes(0)
        if found is None
        else bytes((found.algorithm, found.gain, found.ranges)) + position_bytes(found.maximum)
    )
