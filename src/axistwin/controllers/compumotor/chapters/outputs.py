"""User status bits, programmable outputs, and bits that show a state of the indexer: commands 08h to 0Fh, 97h."""

from axistwin.controllers.compumotor.state import State


def nothing(board: State) -> None:
    """Commands 00h and FEh: do nothing.  FEh is reserved."""


def write_user_bits(board: State, bits: int) -> None:
    """Command 08h: write the three user status bits, as a number from 00 to 07."""
    board.handshake.user_bits = bits


def write_bit(level: bool, offset: int, board: State, number: int) -> None:
    """Commands 09h to 0Ch: set or clear user status bit 0 to 2, or programmable output 1 or 2."""
    board.outputs.write(number + offset, level)


def write_outputs(board: State, bits: int) -> None:
    """Command 0Dh: set both programmable outputs.  Bit 1 of the parameter is output 1, and bit 2 is output 2."""
    for number in (1, 2):
        board.outputs.write(number + 2, bool(bits >> number & 1))


def show_state(board: State, bit: int, state: int, active_high: bool) -> None:
    """Command 0Fh: let output bit 0 to 4 show a state of the board.  Undefined state codes are ignored."""
    board.outputs.track(bit, state, active_high)
    board.refresh()


def request_outputs(board: State) -> bytes:
    """Command 97h: report the programmed states of output 1 (in bit 1) and output 2 (in bit 2).

    The level at the terminal differs while an external source overrides the output.
    """
    return bytes([board.outputs.programmed])
