"""User status bits, programmable outputs, and bits that show a state of the indexer: commands 08h to 0Fh, 97h."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from axistwin.controllers.compumotor.chapters.pulses import Phase

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board

USER_BITS = 3
NOTHING = 0x00

STATES: Mapping[int, Callable[["Board"], bool]] = {
    0x01: lambda board: board.moving,
    0x02: lambda board: board.performing_singular,
    0x03: lambda board: board.sequencer.running,
    0x04: lambda board: board.streaming,
    0x05: lambda board: board.pulses.phase is Phase.ACCELERATING,
    0x06: lambda board: board.pulses.phase is Phase.DECELERATING,
    0x07: lambda board: board.pulses.phase is Phase.CONSTANT,
    0x80: lambda board: board.in_deadband,
    0x81: lambda board: board.pins["remote_enable"].level,
}
"""What the codes of 0Fh mean."""


class Outputs:
    """The five bits that commands may set: 0 to 2 the user bits, 3 and 4 the programmable outputs."""

    def __init__(self, board: "Board") -> None:
        self._board = board
        self.programmed = 0
        """The programmable outputs as they have been set: output 1 in bit 1, output 2 in bit 2."""
        self._tracked: dict[int, tuple[Callable[[Board], bool], bool]] = {}
        for number in (1, 2):
            self.write(number + 2, True)

    def write(self, bit: int, level: bool) -> None:
        """Set or clear a bit."""
        if bit >= USER_BITS:
            number = bit - 2
            self.programmed = self.programmed & ~(1 << number) | level << number
            self._board.pins[f"output{number}"].set(level)
        else:
            others = self._board.handshake.user_bits & ~(1 << bit)
            self._board.handshake.user_bits = others | level << bit

    def track(self, bit: int, state: int, active_high: bool) -> None:
        """From now on the bit shows a state, or with 00 nothing more."""
        if state == NOTHING:
            self._tracked.pop(bit, None)
        elif state in STATES:
            self._tracked[bit] = STATES[state], active_high
            self.refresh()

    def shows(self, state: int) -> bool:
        """Whether a bit shows this state."""
        return any(shown is STATES[state] for shown, _ in self._tracked.values())

    def refresh(self) -> None:
        """Something may have changed: the bits that show a state show it."""
        for bit, (state, active_high) in self._tracked.items():
            self.write(bit, state(self._board) is active_high)


def nothing(board: "Board") -> None:
    """Command 00h does nothing; FEh is reserved, and never heard."""


def write_user_bits(board: "Board", bits: int) -> None:
    """Command 08h: all three user status bits, 00 to 07."""
    board.handshake.user_bits = bits


def write_bit(level: bool, offset: int, board: "Board", number: int) -> None:
    """Commands 09h to 0Ch: set or clear user status bit 0 to 2, or programmable output 1 or 2."""
    board.outputs.write(number + offset, level)


def write_outputs(board: "Board", bits: int) -> None:
    """Command 0Dh: both programmable outputs, output 1 from bit 1 and output 2 from bit 2."""
    for number in (1, 2):
        board.outputs.write(number + 2, bool(bits >> number & 1))


def show_state(board: "Board", bit: int, state: int, active_high: bool) -> None:
    """Command 0Fh: bit 0 to 4 shows a state from now on; a code that is not defined is ignored."""
    board.outputs.track(bit, state, active_high)


def request_outputs(board: "Board") -> bytes:
    """Command 97h: the programmed state of the outputs, output 1 in bit 1 and output 2 in bit 2.

    It is not the level of a terminal that something outside overpowers.
    """
    return bytes([board.outputs.programmed])
