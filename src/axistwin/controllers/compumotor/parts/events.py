"""Events of the motion, and the messages that a host requests for them (A0h to ABh)."""

from collections.abc import Callable
from enum import IntEnum


class Happening(IntEnum):
    """Events for which a host can request messages; value: opcode for the next event, value + 1: for every one."""

    START = 0xA0
    CONSTANT = 0xA2
    END = 0xA4
    STALL = 0xA6
    PLUS_LIMIT = 0xA8
    MINUS_LIMIT = 0xAA


ALARMS = {Happening.STALL: "stall", Happening.PLUS_LIMIT: "plus_limit", Happening.MINUS_LIMIT: "minus_limit"}
OF_A_MOVE = (Happening.START, Happening.CONSTANT)


class Events:
    """Sends the messages that the host has requested for events."""

    def __init__(self, send: Callable[[int, bytes], None]) -> None:
        self._send = send
        self.on_fault: Callable[[str], None] = lambda name: None
        """Function that is called at every stall and limit hit, even if no message is requested."""
        self.armed: dict[int, int] = {}
        """Messages about events (e.g. a stall) that the host has requested.

        Key: opcode of the message.  Value: number of moves that had begun when the host requested the message.
        """

    def happened(self, what: Happening, begun: int) -> None:
        """Send the requested messages for an event of move number `begun`.

        The start and the constant velocity of a move that began before the request cause no message.
        """
        if what in ALARMS:
            self.on_fault(ALARMS[what])
        for opcode in (what, what + 1):
            if opcode in self.armed and (what not in OF_A_MOVE or begun > self.armed[opcode]):
                self._send(opcode, b"")
                if opcode == what:
                    del self.armed[what]
