"""Interrupts on events: commands A0h to AFh.  Each event has a "next" and an "every" form, two opcodes in a row."""

from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board


class Happening(IntEnum):
    """What a message can be asked for; the value is the opcode of its "next" form."""

    START = 0xA0
    CONSTANT = 0xA2
    END = 0xA4
    STALL = 0xA6
    PLUS_LIMIT = 0xA8
    MINUS_LIMIT = 0xAA


ALARMS = {Happening.STALL: "stall", Happening.PLUS_LIMIT: "plus_limit", Happening.MINUS_LIMIT: "minus_limit"}
OF_A_MOVE = (Happening.START, Happening.CONSTANT)


class Events:
    """Which messages have been asked for."""

    def __init__(self, send: Callable[[int, bytes], None]) -> None:
        self._send = send
        self.on_fault: Callable[[str], None] = lambda name: None
        """Told of stalls and limits, whether a message has been asked for or not."""
        self._armed: dict[int, int] = {}  # by opcode: how many moves had begun

    def arm(self, opcode: int, on: bool, begun: int) -> None:
        """Ask for a message, or no longer."""
        if on:
            self._armed[opcode] = begun
        else:
            self._armed.pop(opcode, None)

    def inhibit(self) -> None:
        """No messages at all."""
        self._armed.clear()

    def happened(self, what: Happening, begun: int) -> None:
        """Send the messages.  A move during which they were asked for does not count; "next" is then over."""
        if what in ALARMS:
            self.on_fault(ALARMS[what])
        for opcode in (what, what + 1):
            if opcode in self._armed and (what not in OF_A_MOVE or begun > self._armed[opcode]):
                self._send(opcode, b"")
        if what in self._armed and (what not in OF_A_MOVE or begun > self._armed[what]):
            del self._armed[what]


def arm(opcode: int, board: "Board", on: bool) -> None:
    """Commands A0h to ABh: a message at the next or every occasion: start of a move, constant non-zero velocity of a
    move, end of motion, stall, hit of the + limit, hit of the - limit.  Off after reset.
    """
    board.events.arm(opcode, on, board.motion.begun)


def inhibit(board: "Board") -> None:
    """Command AFh: none of the messages of A0h to AEh any more."""
    board.events.inhibit()
    board.triggers.drop(0xAC)
