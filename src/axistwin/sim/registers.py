"""A register port: two addresses on a bus, as a host accesses them.

    offset   read                          write
    0        output data buffer (FIFO)     input data buffer (FIFO)
    1        status byte                   control byte

The port is only the hardware; the device defines the meaning of the bits.  The device also reports complete commands
and ready messages to subscribers.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from axistwin.core.errors import UsageError
from axistwin.sim.clock import Clock
from axistwin.sim.pins import Pin
from axistwin.sim.signal import Signal

DEPTH = 16

DATA, CONTROL = 0, 1
NOBODY_DRIVES = 0xFF  # The value that a host reads from a bus while no board drives it.


class Fifo:
    """A FIFO buffer for 16 bytes; when full, a written byte is lost; when empty, a read returns 0."""

    def __init__(self) -> None:
        self._bytes: deque[int] = deque()

    def __len__(self) -> int:
        return len(self._bytes)

    @property
    def contents(self) -> bytes:
        return bytes(self._bytes)

    def push(self, value: int) -> None:
        if len(self._bytes) < DEPTH:
            self._bytes.append(value)

    def pop(self) -> int:
        return self._bytes.popleft() if self._bytes else 0

    def load(self, data: bytes) -> None:
        self._bytes = deque(data[:DEPTH])

    def drain(self) -> bytes:
        data = bytes(self._bytes)
        self._bytes.clear()
        return data


class RegisterPort:
    """The registers; the host uses `read`, `write`, `interrupt` and `init`, the device all others."""

    def __init__(self, clock: Clock) -> None:
        self.clock, self.powered = clock, False
        self.input, self.output = Fifo(), Fifo()
        self._status = 0
        self.status_changes: Signal[[]] = Signal()  # Event: the status byte has changed.
        self.commands: Signal[bytes] = Signal()  # Event: the host has transferred a whole command.
        self.messages: Signal[bytes] = Signal()  # Event: the device has a message ready for the host.
        self.interrupt_line = Pin(clock, "interrupt", output=True)  # To the host; high: active.
        self.on_control: Callable[[int], None] = lambda value: None
        self.on_init: Callable[[], None] = lambda: None

    @property
    def interrupt(self) -> bool:
        """True while the interrupt line from the board to the host is active."""
        return self.interrupt_line.level

    def read(self, offset: int) -> int:
        """Read a register: 0 is the output data buffer, 1 is the status byte.  Virtual time does not advance."""
        if not (type(offset) is int and 0 <= offset <= CONTROL):
            check_byte("offset", offset, CONTROL)
        if not self.powered:
            return NOBODY_DRIVES
        return self._status if offset == CONTROL else self.output.pop()

    def write(self, offset: int, value: int) -> None:
        """Write a register: 0 is the input data buffer, 1 is the control byte.  Virtual time does not advance."""
        if not (type(offset) is type(value) is int and 0 <= offset <= CONTROL and 0 <= value <= 0xFF):
            check_byte("offset", offset, CONTROL)
            check_byte("value", value)
        if not self.powered:
            return
        if offset == DATA:
            self.input.push(value)
        else:
            self.on_control(value)

    def init(self) -> None:
        """Activate the reset line of the bus."""
        if self.powered:
            self.on_init()

    @property
    def status(self) -> int:
        """Content of the device's status register, which the host reads."""
        return self._status

    @status.setter
    def status(self, value: int) -> None:
        if value != self._status:
            self._status = value
            self.status_changes.emit()

    def subscribe_sent(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        return self.commands.subscribe(callback)

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback(message)` for each message to the host; return a function that ends these calls."""
        return self.messages.subscribe(callback)


def check_byte(parameter: str, value: object, highest: int = 0xFF) -> None:
    """Raise UsageError unless `value` is an integer from 0 to `highest`."""
    if type(value) is int and 0 <= value <= highest:
        return
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= highest:
        raise UsageError(f"invalid {parameter} {value!r}: expected an integer from 0 to {highest}")


@dataclass(frozen=True, slots=True)
class ReadData:
    """Action of a host: read the output data buffer."""


class WriteRegister(NamedTuple):
    """Action of a host: write a byte to a register."""

    offset: int
    value: int


@dataclass(frozen=True, slots=True)
class Init:
    """Action of a host: activate the reset line of the bus."""


BusAct = ReadData | WriteRegister | Init
