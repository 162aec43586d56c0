"""The sequence buffers as lines, one for each command: in hex, and in words behind a semicolon.

What is in the streaming buffer is not listed: no command of the manual tells it, and it is gone as it is performed.
"""

from collections.abc import Mapping
from functools import lru_cache

from axistwin.controllers.commandset import CommandSet
from axistwin.controllers.compumotor.board import Board
from axistwin.controllers.compumotor.checker.texts import Words
from axistwin.controllers.product import Listing

SEQUENCES = tuple(f"sequence {number}" for number in range(1, 16))


def listings(commands: CommandSet, board: Board) -> Mapping[str, Listing]:
    """Each sequence that has a definition, 1 to 15; also the one that is being defined."""
    performed = board.sequencer.number if board.sequencer.running else 0
    found = {}
    for number in board.sequences:
        name, defined = name_of(number), number == board.sequences.defining
        lines = tuple(_line(commands, stored.string) for stored in board.sequences[number] or ())
        running = board.sequencer.at if number == performed else None
        found[name] = Listing(f"{name}, being defined" if defined else name, lines, running)
    return found


def name_of(number: int) -> str:
    """What a sequence is called, 1 to 15."""
    return SEQUENCES[number - 1]


@lru_cache(maxsize=1024)
def _line(commands: CommandSet, string: bytes) -> str:
    return f"{string.hex(' ').upper()} ; {Words(commands).explain(string)}"
