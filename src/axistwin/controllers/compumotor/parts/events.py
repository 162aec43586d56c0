"""Events of the motion, and the messages that a host requests for them (A0h to ABh)."""

from collections.abc import Callable
from enum import IntEnum


class Happening(IntEnum):
    """Kinds of events, e.g. the start of a move.  The host can request a message for each kind of event.

    The value of a member is the opcode that requests a message for the next event of this kind.  The value + 1 requests
    a message for every event of this kind.
    """

    START = 0xA0
    CONSTANT = 0xA2
    END = 0xA4
    STALL = 0xA6
    PLUS_LIMIT = 0xA8
    MINUS_LIMIT = 0xAA


ALARMS = {Happening.STALL: "stall", Happening.PLUS_LIMIT: "plus_limit", Happening.MINUS_LIMIT: "minus_limit"}
OF_A_MOVE = (Happening.START, Happening.CONSTANT)


class Events:
    """Sends a message to the host when an event occurs, if the host has requested messages for this event."""

    def __init__(self, send: Callable[[int, bytes], None]) -> None:
        self._send = send
        self.on_fault: Callable[[str], None] = lambda name: None
        """Function that is called at every stall and limit hit, even if no message is requested."""
        self.armed: dict[int, int] = {}
        """Messages about events (e.g. a stall) that the host has requested.

        Key: opcode of the message.  Value: number of moves that had begun when the host requested the message.
        """

    def happened(self, what: Happening, begun: int) -> None:
        """Report the event `what` to the host, if the host has requested messages for this event.

        `begun`: number of the move in which the event occurs.  The start and the constant velocity of a move that began
        before the request cause no message.
        """
        if what in ALARMS:
            self.on_fault(ALARMS[what])
        for opcode in (what, what + 1):
            if opcode in self.armed and (what not in OF_A_MOVE or begun > self.armed[opcode]):
                self._send(opcode, b"")
                if opcode == what:
                    del self.armed[what]
