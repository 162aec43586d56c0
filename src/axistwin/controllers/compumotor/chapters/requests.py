"""Chapter Requests: commands 01h, 80h to 97h, E2h, FDh.  A handler returns the bytes that follow the opcode."""

from axistwin.controllers.compumotor.chapters import streaming
from axistwin.controllers.compumotor.parts.library import NO_MOVE
from axistwin.controllers.compumotor.parts.pulses import Phase
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES
from axistwin.controllers.compumotor.state import State

YES, NO = b"\xff", b"\x00"
LEVEL_TRIGGERS = (2, 3, 4, 5)


def position_bytes(number: int, size: int = 4) -> bytes:
    """Return a number in two's complement, most significant byte first; a number that is too large overflows."""
    return (number % (1 << 8 * size)).to_bytes(size, "big")


def interrupt(board: State, identifier: int) -> bytes:  # noqa: ARG001  # handlers are given the board
    """Command 01h: send the host a message that contains the parameter `identifier` of the command."""
    return bytes([identifier])


def from_start(board: State) -> bytes:
    """Command 80h: report the excursion, i.e. the number of pulses since the motor last started from rest."""
    return position_bytes(board.pulses.excursion)


def from_end(board: State) -> bytes:
    """Command 81h: the remaining pulses of a preset move, negative beyond its end; 0 after other moves."""
    end = board.motion.end
    missing = 0 if end is None else (end - board.pulses.position) * board.motion.sign
    return position_bytes(missing)


def from_home(board: State) -> bytes:
    """Command 82h: position from HOME, six bytes.  Until 39h or 3Ah finds HOME, it is the position at reset."""
    return position_bytes(board.pulses.position - board.home, 6)


def from_zero(board: State) -> bytes:
    """Command 83h: report the position from absolute zero, in six bytes."""
    return position_bytes(board.absolute, 6)


def direction(board: State) -> bytes:
    """Commands 84h, 8Bh: report the direction of the present or last motion, 00h for + and FFh for -."""
    return NO if board.pulses.sign > 0 else YES


def velocity(board: State) -> bytes:
    """Command 85h: ranges and velocity number, always positive; in a streaming mode a streamed velocity.

    At the velocity of the move, the number is that of its definition.
    """
    if board.in_streaming_mode:
        return streaming.velocity(board)
    move, rate = board.motion.move or NO_MOVE, board.pulses.rate
    number = move.velocity if rate == move.rate else VELOCITY_RANGES[move.ranges[0]].number(rate)
    return bytes([move.xy]) + number.to_bytes(4, "big")


def acceleration(board: State) -> bytes:
    """Command 86h: ranges and acceleration number of the present or most recent move."""
    move = board.motion.move or NO_MOVE
    return bytes([move.xy]) + move.acceleration.to_bytes(4, "big")


def status(board: State) -> bytes:
    """Command 88h: limits + and -, home, direction, moving, constant velocity, accelerating, decelerating."""
    return bytes([move_bits(board)])


def move_bits(board: State) -> int:
    """Return the byte that command 88h reports: limits, home input, direction and phase of the motion."""
    phase = board.pulses.phase
    bits = (
        board.limits.blocks(+1), board.limits.blocks(-1), _at_home_switch(board), board.pulses.sign < 0, board.moving,
        phase is Phase.CONSTANT, phase is Phase.ACCELERATING, phase is Phase.DECELERATING,
    )  # fmt: skip
    return sum(bit << number for number, bit in enumerate(bits))


def limits(board: State) -> bytes:
    """Command 89h: report F0h if the + limit is active, 0Fh if the - limit is active, FFh if both are active."""
    return bytes([0xF0 * board.limits.blocks(+1) | 0x0F * board.limits.blocks(-1)])


def home_switch(board: State) -> bytes:
    """Command 8Ah: report FFh while the home input is active, otherwise 00h."""
    return YES if _at_home_switch(board) else NO


def _at_home_switch(board: State) -> bool:
    """True while the home input is active.  The active level is high, unless 38h defines low as active."""
    return board.pins["home"].level is (board.home_definition is None or board.home_definition.active_high)


def moving(board: State) -> bytes:
    """Command 8Ch: report FFh while the motor is moving, otherwise 00h."""
    return YES if board.moving else NO


def in_phase(phase: Phase, board: State) -> bytes:
    """Commands 8Dh, 8Eh, 8Fh: FF at constant, non-zero velocity; accelerating; decelerating."""
    return YES if board.pulses.phase is phase else NO


def mode(board: State) -> bytes:
    """Command 90h: the opcode that entered the present mode, and for streaming modes the parameters."""
    return bytes([board.mode]) + (board.stream.setting.parameters if board.stream.setting else b"")


def move_parameters(board: State, number: int) -> bytes | None:
    """Command 91h: the definition of move 0 to 255; no reply for an undefined move.

    Move 0 is defined after reset, with velocity and acceleration 0.  While streaming, only move 0 is reported.
    """
    move = board.library[number]
    return None if move is None or (number and board.in_streaming_mode) else move.definition(number)


def crunched(board: State) -> bytes:
    """Command 93h: report FFh if the board has calculated all moves in advance, otherwise 00h."""
    return YES if board.library.crunched else NO


def triggers(board: State) -> bytes:
    """Command 94h: report the levels of triggers 2 to 5 in bits 2 to 5.  A set bit means high."""
    return bytes([sum(board.pins[f"trigger{number}"].level << number for number in LEVEL_TRIGGERS)])


def channel_z(board: State) -> bytes:
    """Command 96h: FF while channel Z of the encoder, as inverted by JU16, is high."""
    return YES if board.pins["channel_z"].level is not board.options.invert_z else NO


def free_bytes(board: State) -> bytes:
    """Command E2h: the number of free bytes for sequences; while streaming, of the streaming buffer."""
    free = board.stream.free if board.in_streaming_mode else board.sequences.free
    return free.to_bytes(4, "big")


def part_number(board: State) -> bytes:
    """Command FDh: report the software's part number and revision as ASCII text."""
    return board.options.part_number.encode()
