"""Chapters Indexer mode, Pre-defined moves and Move zero: commands 2Eh to 34h, 40h, C8h to CEh, D6h, D7h."""

from dataclasses import replace

from axistwin.controllers.compumotor.chapters.tracking import wake
from axistwin.controllers.compumotor.parts.library import CLOSED_LOOP, Kind, Move
from axistwin.controllers.compumotor.parts.profiles import Speed, changed, continuous, preset, stopping
from axistwin.controllers.compumotor.parts.pulses import RAMPS, Phase, VelocityProfile
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES
from axistwin.controllers.compumotor.parts.tracking import Use
from axistwin.controllers.compumotor.state import IN_MOTION, SHUT_DOWN, State
from axistwin.sim.clock import Interrupt, Procedure

NO_DEFAULT = "31 (default velocity and acceleration) must be sent first"
MAINTAINS = "position maintenance is on: send 18 00 first, or a closed-loop move (35 or 36)"
AT_LIMIT = "the limit input in this direction is active: move in the other direction"
MOST_MOVES = 0x32
FARTHEST_ABSOLUTE = 0x3FFF_FFFF
FARTHEST_CLOSED_LOOP = 0x7FFF_FFFF  # Maximum number of motor pulses in a closed-loop move.


def set_default(board: State, ranges: tuple[int, int], velocity: int, acceleration: int) -> str | None:
    """Command 31h: define the default velocity, the default acceleration, and the ranges of both.

    Both are 0 after reset.  Ignored if the velocity is beyond its range.  Chapter Move zero.
    """
    move = Move(Kind.CONTINUOUS, ranges, velocity, acceleration)
    if move.rate is None:
        return ""
    board.library.default = move
    return None


def define(
    kind: Kind, board: State, number: int, ranges: tuple[int, int], velocity: int, acceleration: int, target: int
) -> str | None:
    """Commands C8h, CBh, CEh, D4h, D5h: store a move under a number from 1 to 50.

    Each opcode is for one kind of move, e.g. C8h for relative moves.  An earlier move with the same number is replaced.
    The board accepts the numbers 51 to 255, but stores no move for them (X2).  The commands are ignored if the velocity
    is beyond its range.
    """
    move = Move(kind, ranges, velocity, acceleration, target)
    if move.rate is None or number > MOST_MOVES:
        return ""
    board.library.define(number, move)
    return None


def delete(board: State, number: int) -> None:
    """Command D7h: delete move 1 to 255; no effect if the move is not defined."""
    board.library.delete(number)


def set_start_stop(board: State, velocity: int) -> None:
    """Command D6h: define the start/stop velocity, in pulses/s, of all later moves.  The velocity is 0 after reset."""
    board.start_stop = velocity


def define_position(board: State, position: int) -> str | None:
    """Command 2Eh: set the absolute position to `position`, in motor pulses.  The motor does not move.

    Ignored while the motor is moving.
    """
    if board.occupied:
        return IN_MOTION
    board.zero = board.pulses.position - position
    return None


def define_zero(board: State) -> str | None:
    """Command 30h: define the present position as absolute zero of the motor and of the encoder.

    Ignored while moving or with the joystick enabled.
    """
    if board.occupied:
        return IN_MOTION
    define_position(board, 0)
    board.loop.define(0)
    board.refresh()
    return None


def go_relative(board: State, distance: int) -> Procedure:
    """Command 33h: move by `distance` pulses at default velocity and acceleration.

    Needs the default move (31h). Ignored while moving, shut down or maintaining position.
    """
    return (yield from perform_default(board, Kind.RELATIVE, distance))


def go_absolute(board: State, position: int) -> Procedure:
    """Command 34h: move to an absolute position within ±(2³⁰-1), at default velocity and acceleration.

    Ignored under the conditions of 33h, and if the present position is out of that range.
    """
    return (yield from perform_default(board, Kind.ABSOLUTE, position))


def go_on(board: State, minus: bool) -> Procedure:
    """Command 32h: begin a continuous move at default velocity and acceleration.  Ignored before 31h."""
    return (yield from perform_default(board, Kind.CONTINUOUS, int(minus)))


def perform_default(board: State, kind: Kind, target: int) -> Procedure:
    """Perform a move at default velocity and acceleration.  Ignored before command 31h has defined a default move."""
    if board.library.default.speed(board.start_stop) is None:
        return NO_DEFAULT
    move = replace(board.library.default, kind=kind, target=target)
    return (yield from perform(board, move, board.library.calculation_ns))


def perform_move(board: State, number: int) -> Procedure:
    """Command 40h: perform the pre-defined move with the given number (1 to 50).

    The command is ignored if this move is undefined, or while another move is in progress.
    """
    move = board.library[number]
    if move is None:
        return ""
    return (yield from perform(board, move, board.library.calculate_ns(number)))


def perform(board: State, move: Move, calculation_ns: int) -> Procedure:
    """Calculate and perform a move.

    Wait until the command for this move is finished, or until another command discontinues the command.  Return why the
    move is ignored, or None.
    """
    speed = move.speed(board.start_stop)
    if speed is None:
        return "the acceleration of the move is 0: define the move again"
    if (why := hindrance(board, move)) is not None:
        return why
    yield board.occupy(calculation_ns + board.start_ns)
    board.loop.give_way()
    if move.kind in CLOSED_LOOP:
        return (yield from _perform_closed_loop(board, move, speed))
    if move.kind is Kind.CONTINUOUS:
        return (yield from _perform_continuous(board, move, speed))
    if (distance := preset_distance(board, move)) and speed.rate:
        end = board.pulses.position + distance
        sign = distance // abs(distance)
        return (yield from excursion(board, move, speed, sign, preset(speed, abs(distance)), end))
    return None


def hindrance(board: State, move: Move) -> str | None:
    """Return why the move must not begin in the present state of the board, or None if it may.

    A preset move begins at rest only.  A continuous move begins at rest or at constant velocity.
    """
    if board.shutdown.on:
        return SHUT_DOWN
    if board.joystick.enabled:
        return IN_MOTION
    if move.kind is Kind.CONTINUOUS:
        return IN_MOTION if board.pulses.phase in RAMPS else None
    if move.kind in CLOSED_LOOP:
        return IN_MOTION if board.pulses.moving and not board.loop.correcting else None
    if board.pulses.moving:
        return IN_MOTION
    return MAINTAINS if board.loop.on else None


def preset_distance(board: State, move: Move) -> int:
    """Return the signed distance of a relative or absolute move from the present position; 0: no motion."""
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
    the wait.  The move does not start if motion in its direction is blocked; then the reason is returned.
    """
    if board.blocked(sign):
        return SHUT_DOWN if board.shutdown.on else AT_LIMIT
    board.begin_move(move, speed, end)
    board.pulses.start(profile, sign)
    yield from _until_performed(board, move)
    return None


def _perform_continuous(board: State, move: Move, speed: Speed) -> Procedure:
    sign, pulses = (-1 if move.target else +1), board.pulses
    if not pulses.moving:
        if speed.rate:
            return (yield from excursion(board, move, speed, sign, continuous(speed)))
        return None
    before = VELOCITY_RANGES[board.motion.move.ranges[0]] if board.motion.move else speed.range
    board.begin_move(move, speed, None)
    if speed.rate and sign == pulses.sign:
        pulses.change(changed(pulses.rate, before, speed))
        yield from _until_performed(board, move)
        return None
    pulses.change(stopping(pulses.rate, speed))
    yield from _until(board, Phase.REST)
    ended = board.motion.stopped or board.motion.at_limit
    if speed.rate and not (ended or board.blocked(sign)):
        pulses.start(continuous(speed), sign)
        yield from _until_performed(board, move)
    return None


def _perform_closed_loop(board: State, move: Move, speed: Speed) -> Procedure:
    """Perform a closed-loop move.  Ignored without a ratio (B0h), beyond the longest move, or if blocked."""
    loop = board.loop
    if loop.ratio is None:
        return "B0 (ratio) must be sent first"
    if not loop.moves:
        return "this board has no encoder for closed-loop moves: use an 1811, or an open-loop move"
    relative = move.kind is Kind.RELATIVE_ENCODER
    counts = move.target if relative else move.target - loop.absolute
    target = counts + (loop.desired if relative else loop.encoder.count)
    pulses = _to_pulses(counts, loop.ratio, move.target)
    sign = 1 if pulses > 0 else -1
    if abs(pulses) > FARTHEST_CLOSED_LOOP:
        return f"the distance is {abs(pulses)} motor pulses: expected at most {FARTHEST_CLOSED_LOOP}"
    if pulses and board.blocked(sign):
        return SHUT_DOWN if board.shutdown.on else AT_LIMIT
    if pulses and not speed.rate:
        return None
    loop.desired, loop.commanded = target, (move, target)
    if pulses:
        loop.use = Use.CLOSED_LOOP
        end = board.pulses.position + pulses
        yield from excursion(board, move, speed, sign, preset(speed, abs(pulses)), end)
    wake(board)
    return None


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
    """Wait for one of these phases.  If the move is discontinued, the motor keeps its present velocity."""
    try:
        while board.pulses.phase not in phases:
            yield board.pulses.changed()
    except Interrupt:
        board.pulses.hold()
        raise
