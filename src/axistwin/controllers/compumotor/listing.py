"""The sequence buffers as lines, one for each command: in hex, with an explanation after a semicolon.

The streaming buffer is not listed: no command reports the buffer's contents, and a performance empties the buffer.
"""

from collections.abc import Mapping
from functools import lru_cache

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor.board import Board
from axistwin.controllers.compumotor.checker.texts import Words
from axistwin.controllers.product import Listing

SEQUENCES = tuple(f"sequence {number}" for number in range(1, 16))


def listings(commands: CommandSet, board: Board) -> Mapping[str, Listing]:
    """Return each defined sequence, 1 to 15, and the sequence being defined."""
    performed = board.sequencer.number if board.sequencer.running else 0
    found = {}
    for number in board.sequences:
        name, defined = SEQUENCES[number - 1], number == board.sequences.defining
        lines = tuple(_line(commands, stored.string) for stored in board.sequences[number] or ())
        running = board.sequencer.at if number == performed else None
        found[name] = Listing(f"{name}, being defined" if defined else name, lines, running)
    return found


@lru_cache(maxsize=1024)
def _line(commands: CommandSet, string: bytes) -> str:
    return f"{string.hex(' ').upper()} ; {Words(commands).explain(string)}"
