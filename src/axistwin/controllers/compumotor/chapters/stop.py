"""Chapter Stop, discontinue, suspend, kill: commands 70h to 7Fh and ACh, which act at once or on trigger 1 or 6.

STOP ramps down; KILL of motion ends the pulses at once.  When a SINGULAR command is discontinued, the motor keeps
its velocity.
"""

from collections.abc import Callable
from functools import partial

from axistwin.controllers.compumotor.parts.profiles import stopping
from axistwin.controllers.compumotor.parts.sequences import Order
from axistwin.controllers.compumotor.state import State

INTERRUPT_ON_TRIGGER = 0xAC


def stop_motion(board: State) -> None:
    """Commands 70h, 74h: ramp to zero velocity at the most recent acceleration; while streaming, the same as 78h.

    During a correction, or without a move since reset, the motor stops at once.  After a stream, the ramp is that of
    the last move, unless the option `stop_after_stream` is "ignored".
    """
    pulses, speed = board.pulses, board.motion.speed
    if board.motion.streamed and not board.stream.performing and board.options.stop_after_stream == "ignored":
        return
    board.motion.stopped = True
    if board.stream.performing or board.loop.correcting or speed is None:
        kill_motion(board)
    elif not pulses.ending:
        pulses.change(stopping(pulses.rate, speed))


def discontinue_sequence(board: State) -> None:
    """Commands 71h, 75h: end the sequence after its present command.  The contents of the sequence are kept."""
    board.sequencer.order = Order.LEAVE
    board.sequencer.wake()


def suspend_sequence(board: State) -> None:
    """Commands 72h, 76h: suspend the sequence after its present command.  CONTINUE (48h) ends the suspension.

    During a wait for CONTINUE (28h), one CONTINUE ends both the wait and the suspension.
    """
    if board.sequencer.order is Order.CONTINUE and board.sequencer.waiting is None:
        board.sequencer.order = Order.SUSPEND


def discontinue_singular(board: State) -> None:
    """Commands 73h, 77h: end the SINGULAR commands of host and sequence; a moving motor keeps its velocity."""
    board.host.end()
    board.sequence.end()


def kill_motion(board: State) -> None:
    """Commands 78h, 7Ch: end the motion at once, without a ramp."""
    board.motion.stopped = True
    board.stream.end()
    board.pulses.kill()


def kill_sequence(board: State) -> None:
    """Commands 79h, 7Dh: end the sequence and its SINGULAR command.  Ignored without a sequence."""
    if board.sequencer.running:
        board.sequencer.end()
        board.sequence.end()


def kill_and_suspend(board: State) -> None:
    """Commands 7Ah, 7Eh: end its SINGULAR command, and suspend the sequence until CONTINUE, if there is one."""
    if board.sequencer.running:
        if board.sequencer.order is not Order.LEAVE:
            board.sequencer.order = Order.KILL
        board.sequence.end()


def on_trigger(
    opcode: int, action: Callable[[State], None] | None, board: State, trigger: int, on: bool, message: bool
) -> str | None:
    """Commands 74h to 77h, 7Ch to 7Fh: perform `action` when trigger 1 or 6 becomes active, or no longer if `on` is
    False.

    If `message` is True, a message is sent, too.
    """
    busy = board.triggers.assign(trigger, opcode, partial(_respond, board, opcode, trigger, action, message), on)
    return None if busy is None else f"trigger {trigger} already has the function {busy:02X}: disable it first"


def _respond(board: State, opcode: int, trigger: int, action: Callable[[State], None] | None, message: bool) -> None:
    if message:
        board.send(opcode, bytes([trigger]))
    if action is not None:
        action(board)


def interrupt_on_trigger(board: State, trigger: int, on: bool) -> str | None:
    """Command ACh: send a message when trigger 1 or 6 becomes active.  Ignored if it has another function."""
    return on_trigger(INTERRUPT_ON_TRIGGER, None, board, trigger, on, message=True)
