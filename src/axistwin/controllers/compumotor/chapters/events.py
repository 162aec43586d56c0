"""Interrupts on events: commands A0h to AFh.  Each event has a "next" and an "every" form, two opcodes in a row."""

from axistwin.controllers.compumotor.state import State


def arm(opcode: int, board: State, on: bool) -> None:
    """Commands A0h to ABh: a message at the next or every occasion: start of a move, constant non-zero velocity of a
    move, end of motion, stall, hit of the + limit, hit of the - limit.  Off after reset.
    """
    if on:
        board.events.armed[opcode] = board.motion.begun
    else:
        board.events.armed.pop(opcode, None)


def inhibit(board: State) -> None:
    """Command AFh: cancel the messages of A0h to AEh."""
    board.events.armed.clear()
    board.triggers.drop(0xAC)
