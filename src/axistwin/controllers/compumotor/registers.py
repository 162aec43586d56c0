"""Chapters Reading and writing, Control byte and status byte, Interrupts: the handshake with the host.

host                                  board
write command bytes into the IDB
set CB bit 4                          SB bit 4 clears; about 1 ms later the IDB has been read: SB bit 4 sets
                                      message into the ODB: SB bit 3 sets
read the ODB, set CB bit 7            SB bit 3 clears; the next message, if any
"""

from collections import deque
from collections.abc import Callable, Mapping

from axistwin.controllers.compumotor.language import LONGEST
from axistwin.controllers.compumotor.options import Options
from axistwin.core.units import MS
from axistwin.sim.clock import Clock, Event, Moment, Procedure
from axistwin.sim.pins import Pin
from axistwin.sim.registers import RegisterPort


class Control:
    """Bits of the control byte."""

    COMMAND_READY = 0x10
    RESET = 0x20
    INTERRUPT_ENABLE = 0x40
    MESSAGE_TAKEN = 0x80


class Status:
    """Bits of the status byte, of which bits 0 to 2 are the user status bits."""

    USER = 0x07
    MESSAGE_READY = 0x08
    INPUT_READY = 0x10
    FAILED = 0x20
    MASKED = 0x40
    INTERRUPT = 0x80


JUMPERS = {"ju18": Status.MESSAGE_READY, "ju20": Status.INPUT_READY, "ju19": Status.FAILED}
"""Pins at the right sides of the interrupt jumpers, which are separate interrupt lines without a mask."""


class Handshake:
    """The board's side of the bus registers, while the power is on."""

    def __init__(self, clock: Clock, port: RegisterPort, pins: Mapping[str, Pin], options: Options) -> None:
        self.clock, self.port = clock, port
        self._lines = {pins[name]: status for name, status in JUMPERS.items()}
        self._jumpers = 0
        for source in options.interrupts:
            self._jumpers |= getattr(Status, source.upper())
        self._next_message_ns, self._most = round(options.next_message_ms * MS), options.message_queue
        self._messages: deque[bytes] = deque()
        self._loading = False
        self.taken = Moment(clock)  # The board removes a message from the message queue.
        self._command_event: Event = clock.event()
        self._status = Status.MASKED
        self.on_reset: Callable[[], None] = lambda: None
        port.input.drain()
        port.output.drain()
        port.on_control = self._control
        self._show()

    def close(self) -> None:
        self._messages.clear()
        self.port.on_control = lambda value: None
        self.port.interrupt_line.set(False)
        for line in self._lines:
            line.set(False)

    @property
    def user_bits(self) -> int:
        """User status bits: bits 0 to 2 of the status byte."""
        return self._status & Status.USER

    @user_bits.setter
    def user_bits(self, bits: int) -> None:
        self._change(Status.USER, bits)

    @property
    def failed(self) -> bool:
        """True if the fail bit (status bit 5) is set."""
        return bool(self._status & Status.FAILED)

    def fail(self) -> None:
        """Set the fail bit of the status byte.  The fail bit stays set until the board is reset."""
        self._change(Status.FAILED, Status.FAILED)

    def ready(self) -> None:
        """Set status bit 4, which reports that the IDB is ready for a command."""
        self._change(Status.INPUT_READY, Status.INPUT_READY)

    def _change(self, mask: int, bits: int) -> None:
        status = (self._status & ~mask) | bits
        if status != self._status:
            self._status = status
            self._show()

    def _show(self) -> None:
        """Update the status byte and the interrupt lines: one is common, the others belong to jumpers."""
        status = self._status
        active = bool(status & self._jumpers) and not status & Status.MASKED
        self.port.status = status | Status.INTERRUPT if active else status
        self.port.interrupt_line.set(active)
        for line, bit in self._lines.items():
            line.set(bool(status & bit))

    def _control(self, value: int) -> None:
        if value & Control.RESET:
            self.on_reset()
            return
        self._change(Status.MASKED, 0 if value & Control.INTERRUPT_ENABLE else Status.MASKED)
        if value & Control.MESSAGE_TAKEN:
            self._message_taken()
        if value & Control.COMMAND_READY and self._status & Status.INPUT_READY:
            self.port.commands.emit(self.port.input.contents)
            self._change(Status.INPUT_READY, 0)
            reported, self._command_event = self._command_event, self.clock.event()
            reported.succeed()

    def next_command(self, drain_ns: int) -> Procedure:
        """Wait until the host sets CB bit 4 and the board has read the IDB.  Return the bytes."""
        yield self._command_event
        yield self.clock.timeout(drain_ns)
        return self.port.input.drain()

    @property
    def full(self) -> bool:
        return len(self._messages) >= self._most

    def send(self, message: bytes) -> None:
        """Queue a message, padded with zeros to sixteen bytes.  If the queue is full, the message is lost."""
        if self.full:
            return
        self._messages.append(message.ljust(LONGEST, b"\0"))
        if not (self._loading or self._status & Status.MESSAGE_READY):
            self._load()

    def forget_messages(self) -> None:
        """Discard messages that the host has not read."""
        self._messages.clear()
        self.port.output.drain()
        self._change(Status.MESSAGE_READY, 0)

    def _load(self) -> None:
        self._loading = False
        if self._messages:
            message = self._messages.popleft()
            self.taken.happens()
            self.port.output.load(message)
            self.port.messages.emit(message)
            self._change(Status.MESSAGE_READY, Status.MESSAGE_READY)

    def _message_taken(self) -> None:
        if not self._status & Status.MESSAGE_READY:
            return
        self.port.output.drain()
        self._change(Status.MESSAGE_READY, 0)
        self._loading = True
        self.clock.call_later(self._next_message_ns, self._load)
