"""The position tracking addendum and the loose sheets: commands 18h, 19h, 2Fh, 35h to 37h, 98h to 9Fh, B0h to B5h."""

from dataclasses import replace

from axistwin.controllers.compumotor.chapters import moves
from axistwin.controllers.compumotor.chapters.requests import position_bytes
from axistwin.controllers.compumotor.chapters.tracking import wake
from axistwin.controllers.compumotor.parts.library import Kind
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES
from axistwin.controllers.compumotor.parts.tracking import Law, wrapped
from axistwin.controllers.compumotor.state import State
from axistwin.sim.clock import Procedure

# Positions and moves


def define_position(board: State, position: int) -> None:
    """Command 2Fh: the present closed-loop position is `position`, signed encoder pulses.  Ignored while moving.

    Any number of the 32-bit counter will do.
    """
    if not board.occupied:
        board.loop.define(position)


def go(kind: Kind, board: State, target: int) -> Procedure:
    """Commands 35h and 36h: move by or to `target` encoder pulses at default velocity.

    Ignored unless the default move (31h) and B0h to B4h are defined, while moving, shut down, or if it takes more than
    2³¹-1 motor pulses.
    """
    if board.loop.complete:
        yield from moves.perform_default(board, kind, target)


def resume(board: State) -> Procedure:
    """Command 37h: move to the target of the last closed-loop move, at the speed of that move.

    Ignored if there was none.  Loose sheet on command 37h.
    """
    if board.loop.commanded is not None:
        move, target = board.loop.commanded
        again = replace(move, kind=Kind.ABSOLUTE_ENCODER, target=wrapped(target - board.loop.zero))
        yield from moves.perform(board, again, board.library.calculation_ns)


def maintain(board: State, on: bool) -> None:
    """Command 18h: position maintenance on or off; off after reset.  While it is on, 33h, 34h, C8h, CBh are refused."""
    board.loop.on = on
    if not on:
        board.loop.give_way()
    wake(board)


def end_on_stall(board: State, on: bool) -> None:
    """Command 19h: a stall ends the move, or not; off after reset."""
    board.loop.ends_stalled_moves = on


def set_ratio(board: State, motor: int, encoder: int) -> None:
    """Command B0h: motor pulses per encoder pulses (encoder lines x 4), both positive."""
    board.loop.ratio = motor, encoder
    wake(board)


def set_resolution(board: State, resolution: int) -> None:
    """Command B1h: motor pulses per revolution."""
    board.loop.resolution = resolution
    wake(board)


def set_sigma(board: State, sigma: int) -> None:
    """Command B2h: backlash between motor and encoder, all of it, in motor pulses."""
    board.loop.sigma = sigma
    wake(board)


def set_law(board: State, algorithm: int, gain: int, ranges: int, maximum: int) -> None:
    """Command B3h: correct by K·e (1), K·√e (2) or K·e² (3), at `maximum` units of the range or less.

    K and e make a velocity in units of the range.  Ignored if the maximum is beyond the range.
    """
    if VELOCITY_RANGES[ranges >> 4].rate(maximum) is not None:
        board.loop.law = Law(algorithm, gain, ranges, maximum)
        wake(board)


def set_teeth(board: State, teeth: int) -> None:
    """Command B4h: rotor teeth of the motor."""
    board.loop.teeth = teeth
    wake(board)


def set_deadband(board: State, deadband: int) -> None:
    """Command B5h: the error in encoder pulses, to either side, up to which 0Fh shows state 80h.  1811 only."""
    board.loop.deadband = deadband
    board.outputs.refresh()


def relative_count(board: State) -> bytes:
    """Command 98h: encoder pulses since zero velocity was left, or of the last move."""
    return position_bytes(board.loop.relative)


def error(board: State) -> bytes:
    """Command 99h: desired less actual position, encoder pulses."""
    return position_bytes(board.loop.error)


def absolute_count(board: State) -> bytes:
    """Command 9Ah: encoder pulses from absolute zero."""
    return position_bytes(board.loop.absolute)


def slip(board: State) -> bytes:
    """Command 9Bh: rotor teeth slipped since absolute zero was defined (30h); 0 without B0h, B1h and B4h."""
    return position_bytes(min(board.loop.slipped(board.absolute, board.loop.absolute), 0xFFFF))


def ratio(board: State) -> bytes:
    """Command 9Ch: the ratio as it was given; zeros if it was not."""
    motor, encoder = board.loop.ratio or (0, 0)
    return position_bytes(motor, 2) + position_bytes(encoder, 2)


def resolution(board: State) -> bytes:
    """Command 9Dh: motor pulses per revolution as given; 0 if they were not."""
    return position_bytes(board.loop.resolution or 0)


def sigma(board: State) -> bytes:
    """Command 9Eh: backlash in motor pulses as given; 0 if it was not."""
    return position_bytes(board.loop.sigma or 0)


def law(board: State) -> bytes:
    """Command 9Fh: algorithm, K, range and maximum velocity; zeros if they were not given."""
    found = board.loop.law
    return (
        position_bytes(0)
        if found is None
        else bytes((found.algorithm, found.gain, found.ranges)) + position_bytes(found.maximum)
    )
