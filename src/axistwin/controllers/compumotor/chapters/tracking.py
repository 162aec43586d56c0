"""The position tracking addendum: closed-loop moves, stalls, and position maintenance.

closed-loop move: encoder pulses x ratio (B0h) ──> a preset move in motor pulses
at rest:    every 2 ms, error = desired - count ──> K·e, K·√e or K·e² (B3h), while position maintenance (18h) is on
in motion:  every 2 ms, the rotor teeth by which pulses and counts differ; one or more: a stall

Updates are scheduled only while there is motion to supervise or an error to correct.  Until the next event of the
bench, updates that cannot detect a stall are left out.
"""

from functools import partial

from axistwin.controllers.compumotor.chapters.stop import kill_motion
from axistwin.controllers.compumotor.parts.events import Happening
from axistwin.controllers.compumotor.parts.pulses import Phase
from axistwin.controllers.compumotor.parts.tracking import Use
from axistwin.controllers.compumotor.state import IN_DEADBAND, State
from axistwin.core.units import MS

UPDATE_NS = 2 * MS


def phase_changed(board: State, phase: Phase) -> None:
    """Update position tracking after a change of phase, except during a correction."""
    loop = board.loop
    if loop.owns_motion:
        return
    if phase is not Phase.REST:
        loop.leave_zero()
    elif loop.ended is None:
        _end_move(board)
    wake(board)


def _end_move(board: State) -> None:
    """Make the present position the desired position, unless a closed-loop move has another target."""
    loop = board.loop
    _detect_stall(board)
    loop.ended = loop.encoder.count
    given_up = loop.reference is None and not loop.on
    if loop.use is not Use.CLOSED_LOOP or not (board.pulses.position == board.motion.end or given_up):
        loop.desired = loop.ended
    if loop.use is Use.CLOSED_LOOP:
        loop.use = Use.OPEN_LOOP


def joystick_moves(board: State, begins: bool) -> None:
    """Record the start or the end of motion by joystick, which the manual counts as a move (command 11h)."""
    if begins:
        board.loop.leave_zero()
    else:
        _end_move(board)


def refresh(board: State) -> None:
    """Record in the board's state whether the joystick is enabled.

    The position at the end of joystick control becomes the desired position.
    """
    loop = board.loop
    if board.joystick.enabled:
        loop.use = Use.JOYSTICK
    elif loop.use is Use.JOYSTICK:
        loop.use, loop.desired = Use.OPEN_LOOP, loop.encoder.count
    wake(board)


def wake(board: State, skipped: int = 0) -> None:
    """Schedule the next check of the position error if necessary; of checks every 2 ms, leave out `skipped`."""
    if not board.loop.ticking and board.alive and _busy(board):
        board.loop.ticking = True
        board.clock.call_later((skipped + 1) * UPDATE_NS, partial(_tick, board))


def _busy(board: State) -> bool:
    loop = board.loop
    # Without an encoder ratio (command B0h), the board neither detects stalls nor corrects position errors.
    if loop.ratio is None:
        return board.outputs.shows(IN_DEADBAND) and board.moving
    if board.moving and not loop.correcting:
        return loop.detects_stalls or board.outputs.shows(IN_DEADBAND)
    return loop.correcting or (loop.maintains and loop.error != 0)


def _tick(board: State) -> None:
    board.loop.ticking = False
    if board.alive:
        _detect_stall(board)
        _maintain(board)
        board.outputs.refresh()
        wake(board, _without_effect(board))


def _without_effect(board: State) -> int:
    """Return how many stall checks, one every 2 ms, can be skipped for speed.

    The last one before any other event is never skipped: it reads the encoder, whose count depends, by the backlash, on
    earlier readings.
    """
    loop = board.loop
    skipped = (board.clock.free_ns - 1) // UPDATE_NS - 1
    if skipped < 1 or not board.pulses.moving or loop.correcting or board.joystick.enabled or board.outputs.in_use:
        return 0
    while skipped and not loop.cannot_stall(skipped * UPDATE_NS):
        skipped //= 2
    return skipped


def _detect_stall(board: State) -> None:
    loop = board.loop
    if loop.watches and loop.slipped(*loop.since_reference):
        loop.reference = None
        board.events.happened(Happening.STALL, board.motion.begun)
        if loop.ends_stalled_moves:
            kill_motion(board)


def _maintain(board: State) -> None:
    loop, pulses = board.loop, board.pulses
    held = loop.use is Use.SEARCH or board.shutdown.on or board.stream.performing
    error = loop.error if loop.maintains and not held and (loop.correcting or not board.occupied) else 0
    sign = 1 if error > 0 else -1
    if not error or board.limits.blocks(sign):
        loop.give_way()
        return
    assert loop.law is not None
    profile = loop.law.velocity_profile(error)
    if loop.correcting and sign == pulses.sign and profile == pulses.velocity_profile:
        return
    if sign != pulses.sign:
        loop.give_way()
    loop.correction = profile
    pulses.run(profile, sign, further=True)
