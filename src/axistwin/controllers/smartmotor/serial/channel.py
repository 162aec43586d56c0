"""A serial channel: reception, transmission, and the receiver of each character (chapters 6 and 10; section 2 of the
base language).

    byte ── line errors ── echo ──┬── command:  address, words up to a space, CR, LF or NUL; binary records
                                  ├── data:     a FIFO of 16 bytes for LEN and GETCHR
                                  └── transfer: a program being loaded, an upload waiting for its acknowledgement

Channel 0 is the main channel: RS-232, or RS-485 with pin G as direction line.  Channel 1 is RS-485 on pins E and F.
"""

from array import array
from collections import deque
from collections.abc import Callable
from enum import IntFlag
from typing import Protocol

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.language.vocabulary import GLOBAL, LAST_ADDRESS, LONGEST, TERMINATORS, Words
from axistwin.sim.clock import Clock
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.pins import UserPin
from axistwin.sim.serial import Uart

FIFO = 16
TRANSMITTER = 16  # Number of unsent characters above which a program waits at a PRINT.

STATUS_QUERY, POSITION, CLOCK, DIRECT_A, DIRECT_V, DIRECT_P = range(0xF9, 0xFF)
RECORDS = {STATUS_QUERY: 5, POSITION: 6, CLOCK: 6, DIRECT_A: 5, DIRECT_V: 5, DIRECT_P: 5}
"""Number of bytes of a binary record, by its first byte.

The bytes are the first byte, four bytes of the value, and in host mode CR (manual, section 10.1).  The answer to F9h
has the same form; a motor further down a chain passes it over.
"""


class ChannelError(IntFlag):
    """The errors of a serial channel, as bits of the report RCHN."""

    OVERFLOW = 1
    FRAMING = 2
    SCAN = 4
    PARITY = 8


FLAGS = {ChannelError.OVERFLOW: s.BC, ChannelError.FRAMING: s.BF, ChannelError.SCAN: s.BS, ChannelError.PARITY: s.BB}


class Transfer(Protocol):
    """A download or an upload, which receives the characters of a channel instead of the command parser."""

    def take(self, byte: int) -> None: ...

    def spoil(self) -> None:
        """Handle a character that was received with an error, e.g. a wrong parity."""


class Dispatcher(Protocol):
    """Interface through which a serial channel uses the motor's processor, e.g. to execute a command."""

    clock: Clock
    i: "array[int]"
    powered: bool
    channels: "tuple[Channel, Channel]"

    def catch_up(self, *, changing: bool = True) -> None:
        """Advance the motor's state to the present time, i.e. to the latest servo sample."""

    def update_outputs(self) -> None:
        """Update the output signals of the motor after a change of the motor's state."""

    def execute(self, channel: "Channel", text: str) -> None: ...

    def report_refused(self, channel: "Channel", text: str, why: str) -> None:
        """Report a command of the host that is not executed.  `why`: as in `Refusal`."""

    def execute_record(self, code: int, value: int) -> None:
        """Execute a binary record: a point of host mode, or A, V or P."""

    def report_host_mode(self, channel: "Channel") -> None: ...


class Channel:
    """One serial channel of a motor that is switched on."""

    def __init__(self, motor: Dispatcher, number: int, uart: Uart) -> None:
        self.motor, self.number, self.uart = motor, number, uart
        self.open = number == 0
        self.echoing = self.asleep = self.silent = False
        self.addressed = True  # True if commands are for this motor; the latest address byte decides.
        self.received = False  # True if a character has been received since power-up.
        self.errors = ChannelError(0)
        self.fifo: deque[int] = deque()
        self.transfer: Transfer | None = None  # The download or upload that receives all characters.
        self.direction: UserPin | None = None  # The direction line of an RS-485 converter, pin G.
        self._data_mode = False
        self._when_empty: Callable[[], None] | None = None
        self._words = Words(self._execute, self._refuse_long)
        self._record = bytearray()  # The received bytes of an incomplete binary record.
        self._spoilt = False  # True if a byte of the present record had an error, e.g. a wrong parity.
        self._timeout_ns = 0  # Time in ns after its first character within which a command must end; 0 for no time-out.
        self._begun_ns: int | None = None  # Time at which the incomplete command began, while there is a time-out.
        uart.format = UartFormat()
        uart.on_receive, uart.on_idle = self.receive, self._idle

    def close(self) -> None:
        self.shut()
        self.transfer = None
        self.uart.on_receive, self.uart.on_idle = lambda byte, errors: None, lambda: None

    def receive(self, byte: int, errors: LineError) -> None:
        if not self.open:
            return
        self.received = True
        if self.motor.i[s.PAUSED]:
            self._resume_program()
        asked = byte == STATUS_QUERY and not errors and self._asked
        if self.echoing and not asked:  # the answer to F9h begins with F9h
            self.send(bytes((byte,)))
        if errors:
            self._spoil(byte, errors)
        else:
            self.take(byte)
        if self._timeout_ns:
            self._start_timeout()

    def _start_timeout(self) -> None:
        if not (self._words.begun or self._record):
            self._begun_ns = None
        elif self._begun_ns is None:
            began_ns = self._begun_ns = self.motor.clock.now
            self.motor.clock.call_later(self._timeout_ns, lambda: self._expire(began_ns))

    def _expire(self, began_ns: int) -> None:
        """Discard a command whose end has not been received within the time-out, and set the flag Bs."""
        if self._begun_ns == began_ns and self.motor.powered:
            self._begun_ns = None
            self._record.clear()
            text = self._words.forget()
            if not self.asleep:
                self.flag_new(ChannelError.SCAN)
                self.motor.report_refused(
                    self, text, "its end has not come within the time-out of OCHN: send it at once"
                )

    def _resume_program(self) -> None:
        self.motor.catch_up()
        self.motor.i[s.PAUSED], self.motor.i[s.PROGRAM] = 0, s.RUNNING
        self.motor.update_outputs()

    def end_transfer(self) -> None:
        self.transfer = None
        self._words.forget()

    def get_character(self) -> int:
        """GETCHR: return the next byte of the FIFO; 0 if the FIFO is empty."""
        byte = self.fifo.popleft() if self.fifo else 0
        self.motor.i[s.LENGTHS + self.number] = len(self.fifo)
        return byte

    def take(self, byte: int) -> None:
        """Process a received character, e.g. as part of a command or a download."""
        if self.transfer is not None:
            self.transfer.take(byte)
        elif self._data_mode:
            self._take_data(byte)
        elif self._record:
            self._take_record(byte)
        elif byte >= GLOBAL:
            self._take_binary(byte)
        elif self.addressed:
            self._words.take(byte)

    def _execute(self, text: str) -> None:
        if not self.asleep or text == ("WAKE1" if self.number else "WAKE"):
            self.motor.execute(self, text)

    def _take_binary(self, byte: int) -> None:
        """Receive an address, which is valid until the next, the first byte of a record, or the status request."""
        text = self._words.forget()
        if text and not self.asleep:  # A received byte above 7Fh discards an incomplete command.
            self.flag_new(ChannelError.SCAN)
            self.motor.report_refused(self, text, f"the byte {byte:02X}h came before its end: end it by a space or CR")
        if byte <= LAST_ADDRESS:
            # An address byte from the host selects the motors that obey the next commands.
            self.addressed = byte in (GLOBAL, GLOBAL + self.motor.i[s.ADDR])
        elif byte == STATUS_QUERY and self._active:
            self.motor.report_host_mode(self)
        elif byte in RECORDS:  # Collect all bytes of a binary command, even if the command is for another motor.
            self._record.append(byte)

    def _refuse_long(self) -> None:
        self.flag_new(ChannelError.OVERFLOW)
        self.motor.report_refused(self, self._words.text, f"it has more than {LONGEST} characters (Bc): divide it")

    def _take_record(self, byte: int) -> None:
        self._record.append(byte)
        if len(self._record) < RECORDS[self._record[0]]:
            return
        record, spoilt = bytes(self._record), self._spoilt
        self._record.clear()
        self._spoilt = False
        if len(record) == RECORDS[POSITION] and byte not in TERMINATORS:
            self._reject_record(byte)
        elif self._active and not spoilt and record[0] != STATUS_QUERY:
            self.motor.execute_record(record[0], int.from_bytes(record[1:5], "big", signed=True))

    def _reject_record(self, byte: int) -> None:
        if self._active:
            self.flag_new(ChannelError.SCAN)
        if byte < GLOBAL:
            self._words.drop()
        self.take(byte)

    def _take_data(self, byte: int) -> None:
        if len(self.fifo) == FIFO:
            self.flag_new(ChannelError.OVERFLOW)
            return
        self.fifo.append(byte)
        self.motor.catch_up()
        self.motor.i[s.LENGTHS + self.number] = len(self.fifo)
        self.motor.update_outputs()

    @property
    def obeys(self) -> bool:
        """True unless the channel is closed, receives a program, or passes its characters on as data."""
        return self.open and self.transfer is None and not self._data_mode

    @property
    def _asked(self) -> bool:
        """True if the byte F9h is a request to this motor now, not data."""
        return self._active and not (self.transfer or self._data_mode or self._record)

    @property
    def _active(self) -> bool:
        return self.addressed and not self.asleep

    def flag_new(self, error: ChannelError) -> None:
        """Set the flag of a receive error, unless the flag is already set."""
        self.motor.catch_up(changing=False)
        if self.motor.i[FLAGS[error]] and error & self.errors:
            return
        self.motor.catch_up()
        self.flag(error)
        self.motor.update_outputs()

    def flag(self, error: ChannelError) -> None:
        """Set the flag of an error on this channel, and store the error for the report RCHN."""
        slot = FLAGS[error]
        if not self.motor.i[slot]:
            # Delete earlier errors of the kind `error`, e.g. parity errors, from all serial channels of the motor.
            for channel in self.motor.channels:
                channel.errors &= ~error
        self.motor.i[slot] = 1
        self.errors |= error

    def status(self) -> ChannelError:
        """Return the errors that RCHN reports for this channel.  Only errors whose flags are still set are reported."""
        return ChannelError(sum(bit for bit, slot in FLAGS.items() if bit & self.errors and self.motor.i[slot]))

    def _spoil(self, byte: int, errors: LineError) -> None:
        if LineError.PARITY in errors:
            self.flag_new(ChannelError.PARITY)
        if LineError.FRAMING in errors:
            self.flag_new(ChannelError.FRAMING)
        if self.transfer is not None:
            self.transfer.spoil()
        elif self._record:
            self._spoilt = True
            self._take_record(byte)
        elif LineError.BREAK in errors:
            self._words.forget()
        elif self.addressed and not self._data_mode:
            self._words.drop()

    def send(self, data: bytes) -> None:
        """Append characters to the output queue of the channel.  Characters for a closed channel are lost."""
        if not self.open:
            return
        self._set_direction(transmitting=True)
        self.uart.send(data)
        if not self.uart.sending:
            self._idle()

    def _set_direction(self, *, transmitting: bool) -> None:
        """Set the RS-485 direction line: high while transmitting; nothing if the pin is no longer an output."""
        if self.direction is not None and self.direction.is_output:
            self.direction.output(transmitting)

    @property
    def full(self) -> bool:
        """True if the output queue is so long that a program must wait."""
        return len(self.uart.queue) > TRANSMITTER

    def when_empty(self, action: Callable[[], None]) -> None:
        self._when_empty = action

    def _idle(self) -> None:
        self._set_direction(transmitting=False)
        action, self._when_empty = self._when_empty, None
        if action is not None:
            action()

    def set_up(self, fmt: UartFormat, *, data_mode: bool, timeout_ns: int = 0) -> None:
        """OCHN: open the serial channel with new settings, e.g. with a new baud rate."""
        self.open, self._data_mode = True, data_mode
        self._timeout_ns, self._begun_ns = 0 if data_mode else timeout_ns, None
        self._record.clear()
        self.uart.format = fmt
        self.fifo.clear()
        self.motor.i[s.LENGTHS + self.number] = 0
        self._words.forget()

    def shut(self) -> None:
        """CCHN: stop receiving and sending on this channel.  Characters that wait to be sent are lost."""
        self.open = False
        self.uart.queue.clear()
