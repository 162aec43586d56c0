"""Interrupts on events: commands A0h to AFh.  Each event has two opcodes: for its next, and for every occurrence."""

from axistwin.controllers.compumotor.state import State


def arm(opcode: int, board: State, on: bool) -> None:
    """Commands A0h to ABh: enable or disable the message for one kind of event.

    The events are: start of a move, constant non-zero velocity of a move, end of motion, stall, hit of the + limit,
    hit of the - limit.  All messages are disabled after reset.
    """
    if on:
        board.events.armed[opcode] = board.motion.begun
    else:
        board.events.armed.pop(opcode, None)


def inhibit(board: State) -> None:
    """Command AFh: disable the messages on events (A0h to ABh) and on trigger inputs (ACh)."""
    board.events.armed.clear()
    board.triggers.drop(0xAC)
