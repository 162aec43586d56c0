"""A register port: two addresses on a bus, as a host finds them.

    offset   read                          write
    0        output data buffer (FIFO)     input data buffer (FIFO)
    1        status byte                   control byte

The port is the hardware only; what the bits mean is the device's affair.
"""

from collections import deque
from collections.abc import Callable

from axistwin.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin

DEPTH = 16
"""Bytes in a FIFO."""

DATA, CONTROL = 0, 1
NOBODY_DRIVES = 0xFF
"""What a host reads from a bus that no board drives."""


class Fifo:
    """Bytes, first in first out.  Full: what is written is lost.  Empty: what is read is 0."""

    def __init__(self, depth: int = DEPTH) -> None:
        self.depth = depth
        self._bytes: deque[int] = deque()

    def __len__(self) -> int:
        return len(self._bytes)

    def push(self, value: int) -> None:
        """One byte in."""
        if len(self._bytes) < self.depth:
            self._bytes.append(value)

    def pop(self) -> int:
        """One byte out."""
        return self._bytes.popleft() if self._bytes else 0

    def load(self, data: bytes) -> None:
        """These bytes, and none from before."""
        self._bytes = deque(data[: self.depth])

    def drain(self) -> bytes:
        """All bytes; the FIFO is then empty."""
        data = bytes(self._bytes)
        self._bytes.clear()
        return data


class RegisterPort:
    """The host's side (`read`, `write`, `interrupt`, `init`) and the device's (everything else)."""

    def __init__(self, clock: Clock) -> None:
        self.powered = False
        self.input, self.output = Fifo(), Fifo()
        self.status = 0
        self.interrupt_line = Pin(clock, "interrupt")
        """The line to the host, for those who want to watch it; high: active."""
        self.on_control: Callable[[int], None] = lambda value: None
        self.on_init: Callable[[], None] = lambda: None

    @property
    def interrupt(self) -> bool:
        """Whether the board interrupts the host."""
        return self.interrupt_line.level

    def read(self, offset: int) -> int:
        """Read a register: 0 the output data buffer, 1 the status byte.  It takes no virtual time."""
        _check("offset", offset, CONTROL)
        if not self.powered:
            return NOBODY_DRIVES
        return self.status if offset == CONTROL else self.output.pop()

    def write(self, offset: int, value: int) -> None:
        """Write a register: 0 the input data buffer, 1 the control byte.  It takes no virtual time."""
        _check("offset", offset, CONTROL)
        _check("value", value, 0xFF)
        if not self.powered:
            return
        if offset == DATA:
            self.input.push(value)
        else:
            self.on_control(value)

    def init(self) -> None:
        """The bus's reset line is activated."""
        if self.powered:
            self.on_init()


def _check(what: str, value: object, highest: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= highest:
        raise UsageError(f"no {what} {value!r} on this bus: give an integer from 0 to {highest}")
