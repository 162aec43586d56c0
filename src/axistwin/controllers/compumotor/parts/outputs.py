"""The five output bits: user status bits, programmable outputs, and the states that the bits can show (0Fh)."""

from collections.abc import Callable, Mapping

from axistwin.controllers.compumotor.registers import Handshake
from axistwin.sim.pins import Pin

USER_BITS = 3
NOTHING = 0x00


class Outputs:
    """The five bits that commands may set: bits 0 to 2 are the user bits, 3 and 4 the programmable outputs."""

    def __init__(self, pins: Mapping[str, Pin], handshake: Handshake, states: Mapping[int, Callable[[], bool]]) -> None:
        """`states`: for each state code of 0Fh, a function that returns True if the state is active."""
        self._pins, self._handshake, self._states = pins, handshake, states
        self.programmed = 0
        """Programmable outputs as set by commands: output 1 in bit 1, output 2 in bit 2."""
        self._tracked: dict[int, tuple[int, bool]] = {}  # state and active level, by bit
        for number in (1, 2):
            self.write(number + 2, True)

    def write(self, bit: int, level: bool) -> None:
        """Set or clear a bit."""
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
        """True if a bit shows any state."""
        return bool(self._tracked)

    def shows(self, state: int) -> bool:
        """True if a bit shows this state."""
        return bool(self._tracked) and any(shown == state for shown, _ in self._tracked.values())

    def refresh(self) -> None:
        """Update the bits that show a state."""
        for bit, (state, active_high) in self._tracked.items():
            self.write(bit, self._states[state]() is active_high)
