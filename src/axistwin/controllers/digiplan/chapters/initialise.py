"""Chapter Initialisation: self-test, automatic baud rate, data format.

RESET --1 s--> WAIT --"("--> FORMAT --"U61<CR>"--> READY
"""

import re
from enum import Enum
from fractions import Fraction
from typing import TYPE_CHECKING

from axistwin.controllers.digiplan.chapters.serial_data import CR, LF, Frame, uart_format
from axistwin.controllers.digiplan.step import Step
from axistwin.sim.clock import Procedure
from axistwin.sim.frames import LineError, UartFormat
from axistwin.units import MS, S

if TYPE_CHECKING:
    from axistwin.controllers.digiplan.interface import Interface

BAUD_RATES = (110, 300, 600, 1200, 2400, 4800, 9600)
LOW_BITS = 4  # of "(": start bit and three zeros
TOLERANCE = 10  # a baud rate is recognised within a tenth of it
BAUD_DETECT, ERASE = ord("("), ord("*")
NO_BAUD_RATE = "characters from the host are dropped, no baud rate yet: send ( first, at 110 to 9600 baud"
NO_FORMAT = "characters from the host are dropped, no data format yet: send it first, e.g. U61 <CR>"
ECHOED = "U"  # sample 4 sends back what the interface has answered
FALSE_CHARACTER = 0x7F
"""What an 8-bit receiver without parity makes of a parity bit of 0 that follows a bit 8 of 1."""
FORMAT_MESSAGE = re.compile(r"([UV])([1-8])([1-9])")
FLASH_NS = 250 * MS  # "flashes twice per second"
REINITIALISE_NS = 5 * MS  # of the UART, after the data format


class State(Enum):
    """How far the interface has come since power was applied."""

    RESET = "self-test"
    WAIT = "waiting for ("
    FORMAT = "waiting for the data format"
    READY = "ready"


def baud_rate(low_ns: Fraction) -> int | None:
    """The baud rate at which `(` keeps the line low for so long."""
    low, per = low_ns.numerator, low_ns.denominator  # in integers: a host may be sending anything, very fast
    expected = LOW_BITS * S * per
    rates = (rate for rate in BAUD_RATES if TOLERANCE * abs(low * rate - expected) < expected)
    return next(rates, None)


def detect_baud_rate(interface: "Interface") -> Procedure:
    """Wait for the first `(` and take over its baud rate; anything else is not heard."""
    uart, detected = interface.uart, interface.clock.event()
    measured: UartFormat | None = None

    def measure(low_ns: Fraction) -> UartFormat | None:
        nonlocal measured
        rate = baud_rate(low_ns)
        measured = None if rate is None else uart_format(rate, Frame())
        if measured is None:
            interface.drop(NO_BAUD_RATE)
        return measured

    def receive(byte: int, _: LineError) -> None:
        if byte & 0x7F == BAUD_DETECT:
            uart.format = measured
            interface.buffer.open()
            detected.succeed()
        else:
            interface.drop(NO_BAUD_RATE)

    uart.format, uart.on_measure, uart.on_receive = None, measure, receive
    yield detected


def data_format(interface: "Interface") -> Procedure:
    """Wait for a good `U x1 x2 <CR>` or `V x1 x2 [<CR>] <LF>`; returns the Frame.

    Characters with framing errors are taken, so that a host may keep its own format from the beginning.
    `(` is answered `U <CR>` again, as often as wanted, and `*` too after it has erased the memory.  A wrong message is
    dropped without a word, and the whole of it is sent again.
    """
    reader = FormatReader()
    while True:
        character = (yield from interface.next_character()) & 0x7F
        if character in (BAUD_DETECT, ERASE):
            reader.text = ""
            if character == ERASE:
                interface.erase()
            yield from interface.transmit(b"U\r")
        elif frame := reader.take(character):
            return frame
        elif reader.dropped:
            interface.drop(NO_FORMAT)


class FormatReader:
    """Reads a data format message character by character."""

    def __init__(self) -> None:
        self.text = ""
        """What has come of it; a message that is none is dropped."""
        self.dropped = False
        """True: the last character ended a message that is no data format."""

    def take(self, character: int) -> Frame | None:
        """The data format, once the message has been ended as it should be."""
        self.dropped = False
        if character in (CR, LF):
            if frame := read_format(self.text, character):
                return frame
            if character == LF or not self.text.startswith("V"):
                self.dropped, self.text = self.text not in ("", ECHOED), ""
        elif character not in (ord(" "), FALSE_CHARACTER):
            begins = chr(character) in "UV"
            self.text = chr(character) if begins else (self.text + chr(character))[:4]
        return None


def read_format(text: str, terminator: int) -> Frame | None:
    """The data format that a message names, if it is a good one and ends as it should."""
    match = FORMAT_MESSAGE.fullmatch(text)
    if match is None:
        return None
    frame = Frame(match[1], int(match[2]), int(match[3]))
    return frame if frame.ends_message == terminator else None


def only_at_initialisation(_: Step) -> str:
    """Commands ( * U V: baud rate detection, erasing, data format.  Heard while the interface is being initialised.

    Once it is ready they are a data fault.  While it is locked, `(` begins the initialisation again if DSR is held and
    nothing moves.  Chapters Initialisation, Breaking into a locked interface.
    """
    return "for initialisation only"
