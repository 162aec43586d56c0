"""Chapters Control of data transfer, Serial data format and Inter-character delay: characters in and out.

Input: a character stays in the UART for about 1 ms and then enters the 64-character input buffer, whose filling level
sets DTR (or sends X-off and X-on).  Output: characters are sent one after the other, each after the programmed delay,
and only while DSR and CTS are set.
"""

from collections import deque
from collections.abc import Callable

from axistwin.controllers.digiplan.chapters.data_format import CR, LF
from axistwin.controllers.digiplan.chapters.faults import LineFault
from axistwin.controllers.product import ControlLines
from axistwin.core.units import MS
from axistwin.sim.clock import Clock, Event, Interrupt, Moment, Procedure, Process, kill
from axistwin.sim.frames import SOUND, LineError
from axistwin.sim.serial import Uart

NEARLY_FULL = 52  # The host must stop sending when the input buffer contains 52 characters (80 %).
NEARLY_EMPTY = 12  # The host may resume sending when the input buffer (64 characters) is filled to at most 20 %.
OVERFLOW = 61  # When the input buffer contains 61 characters (95 %), the interface deletes all these characters.
X_ON, X_OFF, CANCEL = 0x11, 0x13, ord("#")
BLANK = (CR, LF, ord(" "))
DELAY_UNIT_NS = 10 * MS


class InputBuffer:
    """The UART's receive register and the input buffer of 64 characters."""

    def __init__(self, clock: Clock, uart: Uart, strobe_ns: int) -> None:
        self.clock, self.uart, self.strobe_ns = clock, uart, strobe_ns
        self.characters: deque[int] = deque()
        self.on_fault: Callable[[LineFault], None] = lambda fault: None
        self.intercept: Callable[[int], bool] = lambda byte: False
        """Function that is called with each character; the character is not buffered if it returns True."""
        self.on_full: Callable[[bool], None] = lambda full: None
        self.on_terminator: Callable[[int], None] = lambda code: None  # Called when CR or LF is received.
        self.checking = False  # True if receive errors are faults: with a data format, while not locked.
        self.tolerant = False  # True if characters with errors are accepted, because the data format is not known yet.
        self.full = False
        self._register: tuple[int, LineError] | None = None
        self._began_ns = clock.now
        self.arrival = Moment(clock)  # The arrival of a character.

    def begin_with(self, byte: int) -> None:
        """Replace the contents of the buffer with one character."""
        self.characters.clear()
        self._register = None
        self._enter(byte, LineError.NONE)

    def set_tolerant(self, on: bool) -> None:
        """Start or stop accepting characters with errors, as needed before the data format is known."""
        self.tolerant = self.uart.resynchronises = on

    def open(self) -> None:
        """Start receiving characters."""
        self.uart.on_receive = self._receive
        self.uart.has_room = lambda: not self.full
        self.uart.pump_peer()

    def close(self) -> None:
        """Stop receiving characters from the host, and clear the input buffer."""
        self.uart.on_receive = lambda byte, errors: None
        self.uart.has_room = lambda: True
        self.characters.clear()
        self._register = None

    def take(self) -> int | None:
        """Remove and return the next character of the buffer; None if the buffer is empty."""
        if not self.characters:
            return None
        character = self.characters.popleft()
        self._has_less()
        return character

    def take_message(self, ends_message: int, wanted: Callable[[str], bool]) -> list[int]:
        """Remove and return the first message whose text fulfils `wanted`, with its terminator; "" if there is none."""
        begin = 0
        for end, character in enumerate(self.characters, 1):
            if character & 0x7F != ends_message:
                continue
            message = [self.characters[place] for place in range(begin, end)]
            codes = (byte & 0x7F for byte in message)
            if wanted("".join(chr(code) for code in codes if code not in (CR, LF))):
                for _ in message:
                    del self.characters[begin]
                self._has_less()
                return message
            begin = end
        return []

    def drop_before_cancel(self) -> None:
        """Drop the characters that precede the command `#` in the buffer."""
        while self.characters[0] & 0x7F != CANCEL:
            self.take()

    def drop_messages(self, ends_message: int, kept: Callable[[str], bool]) -> None:
        """Drop all whole messages except those for which the function `kept` returns True."""
        while self.take_message(ends_message, lambda text: not kept(text)):
            pass

    @property
    def last_typed(self) -> int:
        """Code of the last character that is no CR, LF or space; 0 if there is none."""
        codes = (character & 0x7F for character in reversed(self.characters))
        return next((code for code in codes if code not in BLANK), 0)

    @property
    def has_cancel(self) -> bool:
        """True if the buffer contains `#`."""
        return any(character & 0x7F == CANCEL for character in self.characters)

    def _receive(self, byte: int, errors: LineError) -> None:
        if self.intercept(byte):
            return
        if self.uart.instant:
            self._enter(byte, errors)
            return
        if self._register is None:
            since_ns = self.clock.now - self._began_ns
            self.clock.call_later(self.strobe_ns - since_ns % self.strobe_ns, self._strobe)
        else:
            self._flag(LineFault.OVERRUN)
        self._register = byte, errors

    def _strobe(self) -> None:
        if self._register is not None:
            character, self._register = self._register, None
            self._enter(*character)

    def _enter(self, byte: int, errors: LineError) -> None:
        if errors is not SOUND and not self.tolerant:  # The interface discards a character with receive errors.
            self._flag(LineFault.PARITY if LineError.PARITY in errors else LineFault.NONE)
            self._flag(LineFault.FRAMING if LineError.FRAMING in errors else LineFault.NONE)
            return
        self.characters.append(byte)
        if len(self.characters) >= OVERFLOW:
            self.characters.clear()
            self._flag(LineFault.DATA)
            self._set_full(False)
            return
        if not self.full and len(self.characters) >= NEARLY_FULL:
            self._set_full(True)
        if byte & 0x7F in (CR, LF):
            self.on_terminator(byte & 0x7F)
        self.arrival.happens()

    def _flag(self, fault: LineFault) -> None:
        if self.checking:
            self.on_fault(fault)

    def _has_less(self) -> None:
        if self.full and len(self.characters) <= NEARLY_EMPTY:
            self._set_full(False)

    def _set_full(self, full: bool) -> None:
        self.full = full
        self.on_full(full)
        if not full:
            self.uart.pump_peer()


class Transmitter:
    """Sends characters to the host while DSR and CTS are both active."""

    def __init__(self, clock: Clock, uart: Uart, lines: ControlLines) -> None:
        self.clock, self.uart, self.lines = clock, uart, lines
        self.delay = 0  # Inter-character delay in units of 10 ms.
        self._held_back = 0  # Number of transmissions that wait until the inputs DSR and CTS are active.
        self._message: Event | None = None
        self.rest: Process | None = None  # Procedure that completes a message whose sender has been cancelled.
        self._flow_control: int | None = None
        self.urgent: Process | None = None  # Procedure that sends X-on or X-off.
        uart.on_idle = lambda: lines.rts.set(False)

    @property
    def busy(self) -> bool:
        """True while a message waits for the lines, the delay or the UART."""
        return self._message is not None

    def send(self, data: bytes) -> Procedure | None:
        """Send characters; return a procedure if that must wait for lines, delay or UART, otherwise None."""
        if not self.busy and not self.delay and (self.uart.instant or len(data) == 1):
            self.lines.rts.set(True)
            if self._clear_to_send and not self.uart.queue:
                self._transmit(data)
                return None
        return self._send_one_by_one(data)

    def _send_one_by_one(self, data: bytes) -> Procedure:
        """Send a message after the one in progress; one that is cancelled after its first character is completed."""
        while self._message is not None:
            yield self._message
        self._message, left = self.clock.event(), list(data)
        try:
            yield from self._send_all(left)
        except Interrupt:
            if 0 < len(left) < len(data):
                self.rest = self.clock.process(self._complete(left))
            else:
                self._end_message()
            raise
        self._end_message()

    def _complete(self, left: list[int]) -> Procedure:
        yield from self._send_all(left)
        self.rest = None
        self._end_message()

    def _end_message(self) -> None:
        if self._message is not None:
            message, self._message = self._message, None
            message.succeed()

    def _send_all(self, left: list[int]) -> Procedure:
        while left:
            if self.delay:
                if self.uart.sending:
                    yield self.uart.when_idle()
                yield self.clock.timeout(self.delay * DELAY_UNIT_NS)
            elif self.uart.queue:
                yield self.uart.when_empty()
            self.lines.rts.set(True)
            yield from self._until_clear()
            self._transmit(bytes([left.pop(0)]))

    def _until_clear(self) -> Procedure:
        self._held_back += 1
        try:
            while not self._clear_to_send:
                yield self._line_change()
        except Interrupt:
            if self._held_back == 1 and self.urgent is None and not self.uart.sending:
                self.lines.rts.set(False)
            raise
        finally:
            self._held_back -= 1

    def send_flow_control(self, stop: bool) -> None:
        """Send X-off or X-on at once, before all other characters."""
        self._flow_control = X_OFF if stop else X_ON
        if self.urgent is None:
            self.urgent = self.clock.process(self._send_urgent())

    def _send_urgent(self) -> Procedure:
        self.lines.rts.set(True)
        while self._flow_control is not None:
            if not self._clear_to_send:
                yield self._line_change()
                continue
            byte, self._flow_control = self._flow_control, None
            self.uart.queue.appendleft(byte)
            self._transmit(b"")
        self.urgent = None

    def stop(self) -> None:
        """Stop sending, because the power is off."""
        for process in (self.urgent, self.rest):
            if process is not None:
                kill(process)
        self.uart.queue.clear()

    def _line_change(self) -> Event:
        return (self.lines.cts if self.lines.dsr.level else self.lines.dsr).changed()

    @property
    def _clear_to_send(self) -> bool:
        return self.lines.dsr.level and self.lines.cts.level

    def _transmit(self, data: bytes) -> None:
        self.uart.send(data)
        if not self.uart.sending:
            self.lines.rts.set(False)
