"""The five output bits: user status bits, programmable outputs, and the states that the bits can show (0Fh)."""

from collections.abc import Callable, Mapping

from axistwin.controllers.compumotor.registers import Handshake
from axistwin.sim.pins import Pin

USER_BITS = 3
NOTHING = 0x00


class Outputs:
    """The five output bits: the user status bits (0 to 2) and the programmable outputs (bits 3 and 4)."""

    def __init__(self, pins: Mapping[str, Pin], handshake: Handshake, states: Mapping[int, Callable[[], bool]]) -> None:
        """`states`: for each state code of 0Fh, a function that returns True if the state is active."""
        self._pins, self._handshake, self._states = pins, handshake, states
        self.programmed = 0  # Programmable outputs as set by commands: output 1 in bit 1, output 2 in bit 2.
        self._tracked: dict[int, tuple[int, bool]] = {}
        """States of the board (e.g. motor moving) that the host has assigned to output bits with command 0Fh.

        Key: number of the output bit.  Value: code of the state, and True if the output bit is active high.
        """
        for number in (1, 2):
            self.write(number + 2, True)

    def write(self, bit: int, level: bool) -> None:
        if bit >= USER_BITS:
            number = bit - 2
            self.programmed = self.programmed & ~(1 << number) | level << number
            self._pins[f"output{number}"].set(level)
        else:
            self._handshake.user_bits = self._handshake.user_bits & ~(1 << bit) | level << bit

    def track(self, bit: int, state: int, active_high: bool) -> None:
        """Let a bit show the state with this code; after code 00, the bit shows no state."""
        if state == NOTHING:
            self._tracked.pop(bit, None)
        elif state in self._states:
            self._tracked[bit] = state, active_high
            self.refresh()

    @property
    def in_use(self) -> bool:
        """True if at least one output bit shows a state of the board (command 0Fh)."""
        return bool(self._tracked)

    def shows(self, state: int) -> bool:
        """True if any output bit shows this state of the board (command 0Fh)."""
        return bool(self._tracked) and any(shown == state for shown, _ in self._tracked.values())

    def refresh(self) -> None:
        for bit, (state, active_high) in self._tracked.items():
            self.write(bit, self._states[state]() is active_high)
