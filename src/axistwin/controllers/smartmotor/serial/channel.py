"""A serial channel (chapters 6 and 10, section 2 of the base language): characters in and out, and who is meant.

    byte ── line errors ── echo ──┬── command:  address, words up to a space, CR, LF or NUL, binary records
                                  ├── data:     a FIFO of 16 bytes for LEN and GETCHR
                                  └── diverted: a program being loaded, an upload waiting for its acknowledgement

Channel 0 is the main one, RS-232 or with pin G as its direction line RS-485; channel 1 is RS-485 on pins E and F.
"""

from collections import deque
from collections.abc import Callable
from enum import IntFlag
from typing import TYPE_CHECKING, Protocol

from axistwin.controllers.smartmotor.chapters import io, modes
from axistwin.controllers.smartmotor.kernel import host_mode
from axistwin.controllers.smartmotor.kernel.state import (
    ADDR,
    BB,
    BC,
    BF,
    BS,
    HOST_CLOCK,
    LENGTHS,
    PAUSED,
    PROGRAM,
    RUNNING,
    STATUS,
)
from axistwin.controllers.smartmotor.language.vocabulary import TERMINATORS, Words
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.serial import Uart

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.motor import Motor

FIFO = 16
TRANSMITTER = 16
"""With more characters than this waiting to be sent a program stops at its PRINT."""

GLOBAL, LAST_ADDRESS = 0x80, 0x80 + 120
STATUS_QUERY, POSITION, CLOCK, DIRECT_A, DIRECT_V, DIRECT_P = range(0xF9, 0xFF)
RECORDS = {POSITION: 6, CLOCK: 6, DIRECT_A: 5, DIRECT_V: 5, DIRECT_P: 5}
"""Bytes of a binary record by its first one: that, four of the value, and in host mode CR (10.1)."""
TAKES: "dict[int, Callable[[Motor, int], None]]" = {
    POSITION: host_mode.position,
    CLOCK: host_mode.clock,
    DIRECT_A: modes.acceleration,
    DIRECT_V: modes.velocity,
    DIRECT_P: modes.position,
}
"""What the value of a binary record is for: points of host mode, or the buffered A, V and P."""


class ChannelError(IntFlag):
    """What RCHN reports."""

    OVERFLOW = 1
    FRAMING = 2
    SCAN = 4
    PARITY = 8


FLAGS = {ChannelError.OVERFLOW: BC, ChannelError.FRAMING: BF, ChannelError.SCAN: BS, ChannelError.PARITY: BB}


class Diversion(Protocol):
    """Who takes the characters that are no commands: a download or an upload."""

    def take(self, byte: int) -> None:
        """A character has come in."""

    def spoil(self) -> None:
        """A character has come in with a line error."""


class Channel:
    """One serial channel of a motor that has its power on."""

    def __init__(self, motor: "Motor", number: int, uart: Uart) -> None:
        self.motor, self.number, self.uart = motor, number, uart
        self.open = number == 0
        self.echoing = self.asleep = self.silent = False
        self.addressed = True
        """Whether commands are for this motor; it is until an address byte says something else."""
        self.heard = False
        """Whether anything has come in since power-up."""
        self.obeying = False
        """Whether a command from this channel is being carried out."""
        self.errors = ChannelError(0)
        self.fifo: deque[int] = deque()
        self.diversion: Diversion | None = None
        self._data_mode = False
        self._when_empty: Callable[[], None] | None = None
        self._words = Words(self._obey, lambda: self.complain(ChannelError.OVERFLOW))
        self._record, self._spoilt = bytearray(), False  # a binary record, and whether there was a line error in it
        self._timeout_ns = 0
        """Time within which a command must end, from its first character; 0: no time-out."""
        self._begun_ns: int | None = None
        """Time at which the command began that is coming in, while there is a time-out."""
        self.direction = False
        """Whether pin G is the direction line of an RS-485 converter."""
        uart.format = UartFormat()
        uart.on_receive, uart.on_idle = self.receive, self._idle

    def close(self) -> None:
        """The power is gone: nothing more is received or sent."""
        self.shut()
        self.diversion = None
        self.uart.on_receive, self.uart.on_idle = lambda byte, errors: None, lambda: None

    # In

    def receive(self, byte: int, errors: LineError) -> None:
        """A character has come in.  One with a line error is flagged, and spoils the command in which it stands."""
        if not self.open:
            return
        self.heard = True
        if self.motor.i[PAUSED]:
            self._go_on()
        if self.echoing:
            self.say(bytes((byte,)))
        if errors:
            self._spoil(byte, errors)
        else:
            self.take(byte)
        if self._timeout_ns:
            self._mind_time()

    def _mind_time(self) -> None:
        """Give the command that has begun its time to end."""
        if not (self._words.begun or self._record):
            self._begun_ns = None
        elif self._begun_ns is None:
            began_ns = self._begun_ns = self.motor.clock.now
            self.motor.clock.call_later(self._timeout_ns, lambda: self._expire(began_ns))

    def _expire(self, began_ns: int) -> None:
        """Drop the command that began at this time and has not ended; flag Bs."""
        if self._begun_ns == began_ns and self.motor.powered:
            self._begun_ns = None
            self._record.clear()
            self._words.forget()
            if not self.asleep:
                self.complain(ChannelError.SCAN)

    def _go_on(self) -> None:
        """`!` has held the program until a character comes in."""
        self.motor.catch_up()
        self.motor.i[PAUSED], self.motor.i[PROGRAM] = 0, RUNNING
        self.motor.replan()

    def divert(self, to: Diversion) -> None:
        """From now on characters are no commands."""
        self.diversion = to

    def resume(self) -> None:
        """They are commands again."""
        self.diversion = None
        self._words.forget()

    def get_character(self) -> int:
        """GETCHR: the next byte of the FIFO; 0 if there is none."""
        byte = self.fifo.popleft() if self.fifo else 0
        self.motor.i[LENGTHS + self.number] = len(self.fifo)
        return byte

    def take(self, byte: int) -> None:
        """A character goes to whom it concerns."""
        if self.diversion is not None:
            self.diversion.take(byte)
        elif self._data_mode:
            self._take_data(byte)
        elif self._record:
            self._take_record(byte)
        elif byte >= GLOBAL:
            self._take_binary(byte)
        elif self.addressed:
            self._words.take(byte)

    def _obey(self, text: str) -> None:
        if self.asleep and text != ("WAKE1" if self.number else "WAKE"):
            return
        self.obeying = True
        self.motor.obey(self, text)
        self.obeying = False

    def _take_binary(self, byte: int) -> None:
        """An address, which holds until the next one, or the first byte of a binary record."""
        if self._words.forget() and not self.asleep:  # it does not end as a command
            self.complain(ChannelError.SCAN)
        if byte <= LAST_ADDRESS:
            self.addressed = byte in (GLOBAL, GLOBAL + self.motor.i[ADDR])  # ADDR is changed by SADDRn only
        elif byte in RECORDS:  # whoever is meant: its bytes are no addresses and no commands
            self._record.append(byte)
        elif byte == STATUS_QUERY and self._listening:
            self.motor.catch_up()
            self.say(host_status(self.motor))

    def _take_record(self, byte: int) -> None:
        self._record.append(byte)
        if len(self._record) < RECORDS[self._record[0]]:
            return
        record, spoilt = bytes(self._record), self._spoilt
        self._record.clear()
        self._spoilt = False
        if len(record) == RECORDS[POSITION] and byte not in TERMINATORS:
            self._not_a_record(byte)
        elif self._listening and not spoilt:
            self._hand_over(record)

    def _not_a_record(self, byte: int) -> None:
        """Something else than CR stands behind the four bytes."""
        if self._listening:
            self.complain(ChannelError.SCAN)
        if byte < GLOBAL:
            self._words.drop()
        self.take(byte)

    def _hand_over(self, record: bytes) -> None:
        motor, value = self.motor, int.from_bytes(record[1:5], "big", signed=True)
        motor.catch_up()
        TAKES[record[0]](motor, value)
        motor.replan()

    def _take_data(self, byte: int) -> None:
        if len(self.fifo) == FIFO:
            self.complain(ChannelError.OVERFLOW)
            return
        self.fifo.append(byte)
        self.motor.catch_up()
        self.motor.i[LENGTHS + self.number] = len(self.fifo)
        self.motor.replan()

    @property
    def _listening(self) -> bool:
        return self.addressed and not self.asleep

    # Errors

    def complain(self, error: ChannelError) -> None:
        """Something is wrong with what comes in: set its flag.  A motor that rests rests on if it is set already."""
        self.motor.core.catch_up(changing=False)
        if self.motor.i[FLAGS[error]] and error & self.errors:
            return
        self.motor.catch_up()
        self.flag(error)
        self.motor.replan()

    def flag(self, error: ChannelError) -> None:
        """Set the flag of an error, and remember for RCHN that this channel had it."""
        slot = FLAGS[error]
        if not self.motor.i[slot]:
            for channel in self.motor.channels:  # it has been cleared since it was set last
                channel.errors &= ~error
        self.motor.i[slot] = 1
        self.errors |= error

    def status(self) -> ChannelError:
        """RCHN of this channel: the errors whose flags have not been cleared since."""
        return ChannelError(sum(bit for bit, slot in FLAGS.items() if bit & self.errors and self.motor.i[slot]))

    def _spoil(self, byte: int, errors: LineError) -> None:
        if LineError.PARITY in errors:
            self.complain(ChannelError.PARITY)
        if LineError.FRAMING in errors:
            self.complain(ChannelError.FRAMING)
        if self.diversion is not None:
            self.diversion.spoil()
        elif self._record:
            self._spoilt = True
            self._take_record(byte)
        elif LineError.BREAK in errors:
            self._words.forget()
        elif self.addressed and not self._data_mode:
            self._words.drop()

    # Out

    def say(self, data: bytes) -> None:
        """Send characters, after those that are waiting already.  On a channel that is not open they are lost."""
        if not self.open:
            return
        if self.direction:
            io.show_direction(self.motor, True)
        self.uart.send(data)
        if not self.uart.sending:
            self._idle()

    @property
    def full(self) -> bool:
        """Whether so much is waiting to be sent that a program has to wait."""
        return len(self.uart.queue) > TRANSMITTER

    def when_empty(self, action: Callable[[], None]) -> None:
        """Do this once, when everything has been sent."""
        self._when_empty = action

    def _idle(self) -> None:
        if self.direction:
            io.show_direction(self.motor, False)
        action, self._when_empty = self._when_empty, None
        if action is not None:
            action()

    # Opening

    def set_up(self, fmt: UartFormat, *, data_mode: bool, timeout_ns: int = 0) -> None:
        """OCHN: from the next character on."""
        self.open, self._data_mode = True, data_mode
        self._timeout_ns, self._begun_ns = 0 if data_mode else timeout_ns, None
        self._record.clear()
        self.uart.format = fmt
        self.fifo.clear()
        self.motor.i[LENGTHS + self.number] = 0
        self._words.forget()

    def shut(self) -> None:
        """CCHN: nothing is received and nothing sent any more; what is waiting to be sent is lost."""
        self.open = False
        self.uart.queue.clear()


def host_status(motor: "Motor") -> bytes:
    """Status byte S, free places in the host mode buffer, clock of the trajectory (4 bytes, most significant first).

    The answer to the byte 0xF9 and to Q; its layout is a guess (section 11 of the base language).
    """
    low = sum(motor.i[slot] << bit for bit, slot in enumerate(STATUS[:8]))
    free = min(host_mode.free(motor), 255)
    return bytes((low, free)) + (motor.i[HOST_CLOCK] & 0xFFFFFFFF).to_bytes(4, "big")
