"""Chapter Requests: commands 01h, 80h to 97h, E2h, FDh.  A handler returns the bytes that follow the opcode."""

from axistwin.controllers.compumotor.chapters import streaming
from axistwin.controllers.compumotor.parts.library import NO_MOVE
from axistwin.controllers.compumotor.parts.pulses import Phase
from axistwin.controllers.compumotor.parts.ranges import VELOCITY_RANGES
from axistwin.controllers.compumotor.state import State

YES, NO = b"\xff", b"\x00"
LEVEL_TRIGGERS = (2, 3, 4, 5)


def position_bytes(number: int, size: int = 4) -> bytes:
    """Return a number in two's complement, most significant byte first, modulo its size."""
    return (number % (1 << 8 * size)).to_bytes(size, "big")


def interrupt(board: State, identifier: int) -> bytes:  # noqa: ARG001  # handlers are given the board
    """Command 01h: send a message with this identifier."""
    return bytes([identifier])


def from_start(board: State) -> bytes:
    """Command 80h: position from the start of the present or most recent excursion, where the velocity was zero."""
    return position_bytes(board.pulses.excursion)


def from_end(board: State) -> bytes:
    """Command 81h: pulses short of (+) or beyond (-) the end of the preset move; 0 after any other move."""
    end = board.motion.end
    missing = 0 if end is None else (end - board.pulses.position) * board.motion.sign
    return position_bytes(missing)


def from_home(board: State) -> bytes:
    """Command 82h: position from HOME, six bytes.  Until 39h or 3Ah finds HOME, it is the position at reset."""
    return position_bytes(board.pulses.position - board.home, 6)


def from_zero(board: State) -> bytes:
    """Command 83h: position from absolute zero, six bytes."""
    return position_bytes(board.absolute, 6)


def direction(board: State) -> bytes:
    """Commands 84h, 8Bh: present or most recent direction of travel, 00 + and FF -."""
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
    """Return the eight bits of the answer to 88h."""
    phase = board.pulses.phase
    bits = (
        board.limits.blocks(+1),
        board.limits.blocks(-1),
        _at_home_switch(board),
        board.pulses.sign < 0,
        board.moving,
        phase is Phase.CONSTANT,
        phase is Phase.ACCELERATING,
        phase is Phase.DECELERATING,
    )
    return sum(bit << number for number, bit in enumerate(bits))


def limits(board: State) -> bytes:
    """Command 89h: F0 if the + limit is active, 0F if the - limit is active, FF if both are."""
    return bytes([0xF0 * board.limits.blocks(+1) | 0x0F * board.limits.blocks(-1)])


def home_switch(board: State) -> bytes:
    """Command 8Ah: FF while the home input is active."""
    return YES if _at_home_switch(board) else NO


def _at_home_switch(board: State) -> bool:
    """True while the home input is active: high, unless 38h defines low as active."""
    active_high = board.home_definition is None or board.home_definition.active_high
    return board.pins["home"].level is active_high


def moving(board: State) -> bytes:
    """Command 8Ch: FF while the motor is moving."""
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
    if move is None or (number and board.in_streaming_mode):
        return None
    return move.definition(number)


def crunched(board: State) -> bytes:
    """Command 93h: FF if all moves have been calculated in advance."""
    return YES if board.library.crunched else NO


def triggers(board: State) -> bytes:
    """Command 94h: levels of triggers 2 to 5 in bits 2 to 5; 1 is high."""
    return bytes([sum(board.pins[f"trigger{number}"].level << number for number in LEVEL_TRIGGERS)])


def channel_z(board: State) -> bytes:
    """Command 96h: FF while channel Z of the encoder, as inverted by JU16, is high."""
    return YES if board.pins["channel_z"].level is not board.options.invert_z else NO


def free_bytes(board: State) -> bytes:
    """Command E2h: free bytes for sequences, or in a streaming mode free bytes of the streaming buffer."""
    free = board.stream.free if board.in_streaming_mode else board.sequences.free
    return free.to_bytes(4, "big")


def part_number(board: State) -> bytes:
    """Command FDh: part number and revision of the software, in ASCII."""
    return board.options.part_number.encode()
