"""Chapters Indexer mode, Pre-defined moves and Move zero: commands 2Eh to 34h, 40h, C8h to CEh, D6h, D7h."""

from dataclasses import replace

from axistwin.controllers.compumotor.chapters.tracking import wake
from axistwin.controllers.compumotor.parts.library import CLOSED_LOOP, Kind, Move
from axistwin.controllers.compumotor.parts.profiles import Speed, changed, continuous, preset, stopping
from axistwin.controllers.compumotor.parts.pulses import RAMPS, Phase, VelocityProfile
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES
from axistwin.controllers.compumotor.parts.tracking import Use
from axistwin.controllers.compumotor.state import State
from axistwin.sim.clock import Interrupt, Procedure

MOST_MOVES = 0x32
FARTHEST_ABSOLUTE = 0x3FFF_FFFF
FARTHEST_CLOSED_LOOP = 0x7FFF_FFFF
"""Maximum number of motor pulses in a closed-loop move."""


def set_default(board: State, ranges: tuple[int, int], velocity: int, acceleration: int) -> None:
    """Command 31h: define the default velocity, the default acceleration, and the ranges of both.

    Both are 0 after reset.  Ignored if the velocity is beyond its range.  Chapter Move zero.
    """
    move = Move(Kind.CONTINUOUS, ranges, velocity, acceleration)
    if move.rate is not None:
        board.library.default = move


def define(
    kind: Kind, board: State, number: int, ranges: tuple[int, int], velocity: int, acceleration: int, target: int
) -> None:
    """Commands C8h, CBh, CEh, D4h, D5h: store a move under a number from 1 to 50.

    Each opcode is for one kind of move, e.g. C8h for relative moves.  An earlier move with the same number is replaced.
    The board accepts the numbers 51 to 255, but stores no move for them (X2).  The commands are ignored if the velocity
    is beyond its range.
    """
    move = Move(kind, ranges, velocity, acceleration, target)
    if move.rate is not None and number <= MOST_MOVES:
        board.library.define(number, move)


def delete(board: State, number: int) -> None:
    """Command D7h: delete the move with the given number (1 to 255).

    The command has no effect if this move is not defined.
    """
    board.library.delete(number)


def set_start_stop(board: State, velocity: int) -> None:
    """Command D6h: define the start/stop velocity, in pulses/s, of all later moves.

    The velocity is 0 after reset.
    """
    board.start_stop = velocity


def define_position(board: State, position: int) -> None:
    """Command 2Eh: set the absolute position to `position`, in motor pulses.  The motor does not move.

    Ignored while the motor is moving.
    """
    if not board.occupied:
        board.zero = board.pulses.position - position


def define_zero(board: State) -> None:
    """Command 30h: define the present position as absolute zero of the motor and of the encoder.

    Ignored while moving or with the joystick enabled.
    """
    define_position(board, 0)
    if not board.occupied:
        board.loop.define(0)
        board.refresh()


def go_relative(board: State, distance: int) -> Procedure:
    """Command 33h: move by `distance` pulses at default velocity and acceleration.

    Needs the default move (31h). Ignored while moving, shut down or maintaining position.
    """
    yield from perform_default(board, Kind.RELATIVE, distance)


def go_absolute(board: State, position: int) -> Procedure:
    """Command 34h: move to an absolute position within ±(2³⁰-1), at default velocity and acceleration.

    Ignored under the conditions of 33h, and if the present position is out of that range.
    """
    yield from perform_default(board, Kind.ABSOLUTE, position)


def go_on(board: State, minus: bool) -> Procedure:
    """Command 32h: begin a continuous move at default velocity and acceleration.

    Ignored before command 31h has defined a default move.
    """
    yield from perform_default(board, Kind.CONTINUOUS, int(minus))


def perform_default(board: State, kind: Kind, target: int) -> Procedure:
    """Perform a move at default velocity and acceleration.

    Ignored before command 31h has defined a default move.
    """
    move = replace(board.library.default, kind=kind, target=target)
    yield from perform(board, move, board.library.calculation_ns)


def perform_move(board: State, number: int) -> Procedure:
    """Command 40h: perform the pre-defined move with the given number (1 to 50).

    The command is ignored if this move is undefined, or while another move is in progress.
    """
    move = board.library[number]
    if move is not None:
        yield from perform(board, move, board.library.calculate_ns(number))


def perform(board: State, move: Move, calculation_ns: int) -> Procedure:
    """Calculate and perform a move.

    Wait until the command for this move is finished, or until another command discontinues the command.
    """
    speed = move.speed(board.start_stop)
    if speed is None or not may_perform(board, move):
        return
    yield board.occupy(calculation_ns + board.start_ns)
    board.loop.give_way()
    if move.kind in CLOSED_LOOP:
        yield from _perform_closed_loop(board, move, speed)
    elif move.kind is Kind.CONTINUOUS:
        yield from _perform_continuous(board, move, speed)
    elif (distance := preset_distance(board, move)) and speed.rate:
        end = board.pulses.position + distance
        yield from excursion(board, move, speed, distance // abs(distance), preset(speed, abs(distance)), end)


def may_perform(board: State, move: Move) -> bool:
    """True if the move may begin in the present state of the board.

    A preset move begins at rest only.  A continuous move begins at rest or at constant velocity.
    """
    if board.shutdown.on or board.joystick.enabled:
        return False
    if move.kind is Kind.CONTINUOUS:
        return board.pulses.phase not in RAMPS
    if move.kind in CLOSED_LOOP:
        return not board.pulses.moving or board.loop.correcting
    return not board.pulses.moving and not board.loop.on


def preset_distance(board: State, move: Move) -> int:
    """Return the number of pulses from the present position to the target of a preset move.

    The sign of the number is the direction of the move.  0 means that the motor does not move.
    """
    if move.kind is Kind.RELATIVE:
        return move.target
    if abs(board.absolute) > FARTHEST_ABSOLUTE:
        return 0
    return move.target - board.absolute


def excursion(
    board: State, move: Move, speed: Speed, sign: int, profile: VelocityProfile, end: int | None = None
) -> Procedure:
    """Start a move from standstill, and wait until the move has ended.

    For a continuous move, wait only until the velocity is constant.  A command that discontinues the move (73h) ends
    the wait.  The move does not start if motion in its direction is blocked.
    """
    if board.blocked(sign):
        return
    board.begin_move(move, speed, end)
    board.pulses.start(profile, sign)
    yield from _until_performed(board, move)


def _perform_continuous(board: State, move: Move, speed: Speed) -> Procedure:
    sign, pulses = (-1 if move.target else +1), board.pulses
    if not pulses.moving:
        if speed.rate:
            yield from excursion(board, move, speed, sign, continuous(speed))
        return
    before = VELOCITY_RANGES[board.motion.move.ranges[0]] if board.motion.move else speed.range
    board.begin_move(move, speed, None)
    if speed.rate and sign == pulses.sign:
        pulses.change(changed(pulses.rate, before, speed))
        yield from _until_performed(board, move)
        return
    pulses.change(stopping(pulses.rate, speed))
    yield from _until(board, Phase.REST)
    ended = board.motion.stopped or board.motion.at_limit
    if speed.rate and not (ended or board.blocked(sign)):
        pulses.start(continuous(speed), sign)
        yield from _until_performed(board, move)


def _perform_closed_loop(board: State, move: Move, speed: Speed) -> Procedure:
    """Perform a closed-loop move.

    Ignored without a ratio (B0h), beyond the longest closed-loop move, or if motion is blocked.
    """
    loop = board.loop
    if loop.ratio is None or not loop.moves:
        return
    relative = move.kind is Kind.RELATIVE_ENCODER
    counts = move.target if relative else move.target - loop.absolute
    target = counts + (loop.desired if relative else loop.encoder.count)
    pulses = _to_pulses(counts, loop.ratio, move.target)
    sign = 1 if pulses > 0 else -1
    if abs(pulses) > FARTHEST_CLOSED_LOOP or (pulses and (not speed.rate or board.blocked(sign))):
        return
    loop.desired, loop.commanded = target, (move, target)
    if pulses:
        loop.use = Use.CLOSED_LOOP
        end = board.pulses.position + pulses
        yield from excursion(board, move, speed, sign, preset(speed, abs(pulses)), end)
    wake(board)


def _to_pulses(counts: int, ratio: tuple[int, int], side: int) -> int:
    """Convert encoder pulses to motor pulses, rounded to the nearest integer.

    A half is rounded in the direction of `side`.  `side` is the target of an absolute move, so the end position does
    not depend on the direction of the move.
    """
    motor, encoder = ratio
    upwards = +1 if side >= 0 else -1
    return upwards * ((2 * upwards * counts * motor + encoder) // (2 * encoder))


def _until_performed(board: State, move: Move) -> Procedure:
    if move.kind is Kind.CONTINUOUS:
        yield from _until(board, Phase.REST, Phase.CONSTANT)
    else:
        yield from _until(board, Phase.REST)


def _until(board: State, *phases: Phase) -> Procedure:
    """Wait until the motion reaches one of the given phases, e.g. constant velocity or rest.

    If the move is discontinued, the motor keeps its present velocity.
    """
    try:
        while board.pulses.phase not in phases:
            yield board.pulses.changed()
    except Interrupt:
        board.pulses.hold()
        raise
