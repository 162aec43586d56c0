"""Chapter Initialisation: self-test, automatic baud rate, data format."""

from fractions import Fraction

from axistwin.controllers.digiplan.chapters.data_format import BAUD_RATES, CR, LF, Frame, read_format, uart_format
from axistwin.controllers.digiplan.state import Stage, State
from axistwin.controllers.digiplan.step import Step
from axistwin.core.units import MS, S
from axistwin.sim.clock import Procedure
from axistwin.sim.frames import LineError, UartFormat

LOW_BITS = 4  # Number of low bits that a UART sends first for the character `(`: the start bit and three zeros.
TOLERANCE = 10  # The interface accepts a baud rate of the host within ±10 % of a standard baud rate.
BAUD_DETECT, ERASE = ord("("), ord("*")
NO_BAUD_RATE = "characters from the host are dropped, no baud rate yet: send ( first, at 110 to 9600 baud"
NO_FORMAT = "characters from the host are dropped, no data format yet: send it first, e.g. U61 <CR>"
ECHOED = "U"  # The reply of the interface to `(`, which sample program 4 of the manual sends back to the interface.
FALSE_CHARACTER = 0x7F  # Received without parity if the host's parity bit 0 is taken for a start bit.
FLASH_NS = 250 * MS  # The lamp flashes twice per second: on for 250 ms, off for 250 ms.
REINITIALISE_NS = 5 * MS  # After the format message, all characters are ignored (option `strict_format`).


def baud_rate(low_ns: Fraction) -> int | None:
    """Return the baud rate at which `(` holds the line low for this time."""
    low, per = low_ns.numerator, low_ns.denominator  # Calculate with integers, because Python's `Fraction` is slow.
    expected = LOW_BITS * S * per
    rates = (rate for rate in BAUD_RATES if TOLERANCE * abs(low * rate - expected) < expected)
    return next(rates, None)


def detect_baud_rate(state: State) -> Procedure:
    """Wait for `(`, and set the UART to its baud rate; other characters are dropped."""
    uart, detected = state.uart, state.clock.event()
    measured: UartFormat | None = None

    def measure(low_ns: Fraction) -> UartFormat | None:
        nonlocal measured
        rate = baud_rate(low_ns)
        measured = None if rate is None else uart_format(rate, Frame())
        if measured is None:
            state.drop(NO_BAUD_RATE)
        return measured

    def receive(byte: int, _: LineError) -> None:
        if byte & 0x7F == BAUD_DETECT:
            uart.format = measured
            # Accept characters with receive errors: the host's data format may differ from the UART's data format.
            state.buffer.set_tolerant(True)
            state.buffer.open()
            detected.succeed()
        else:
            state.drop(NO_BAUD_RATE)

    uart.format, uart.on_measure, uart.on_receive = None, measure, receive
    yield detected


def set_data_format(state: State) -> Procedure:
    """Reply to the character `(`, receive the data format message, and set the UART to the format in the message."""
    uart, buffer = state.uart, state.buffer
    assert uart.format is not None
    state.baudrate = uart.format.baudrate
    state.stage, state.hint = Stage.FORMAT, ""
    buffer.set_tolerant(True)
    state.pins["led"].flash(FLASH_NS)
    yield from state.transmit(b"U\r")
    state.frame = yield from _data_format(state)
    if uart.sending:
        yield uart.when_idle()
    uart.format = uart_format(state.baudrate, state.frame)
    buffer.set_tolerant(False)
    state.ignored = (LF, FALSE_CHARACTER) if state.frame.terminator == "U" else (FALSE_CHARACTER,)
    if state.options.strict_format:
        buffer.close()
        yield state.clock.timeout(REINITIALISE_NS)
        buffer.open()
    if not state.locked:
        state.calculate_ramp()
    elif state.options.unlock != "lock format":
        state.lock = None  # the new format is now the lock's


def _data_format(state: State) -> Procedure:
    """Wait for a valid `U x1 x2 <CR>` or `V x1 x2 [<CR>] <LF>`, and return its Frame.

    Characters with framing errors are accepted, so that a host can use its own format from the beginning.  Each `(`
    is answered `U <CR>`; `*` erases the memory and gets the same answer.  A wrong message is dropped without an
    answer; the host must repeat the whole message.
    """
    reader = FormatReader()
    while True:
        while (taken := state.buffer.take()) is None:
            yield state.buffer.arrival()
        character = taken & 0x7F
        if character in (BAUD_DETECT, ERASE):
            reader.text = ""
            if character == ERASE:
                state.erase()
            yield from state.transmit(b"U\r")
        elif frame := reader.take(character):
            return frame
        elif reader.dropped:
            state.drop(NO_FORMAT)


class FormatReader:
    """Reads a message that sets the data format, e.g. `U61`, character by character."""

    def __init__(self) -> None:
        self.text = ""  # Characters of the message in progress.
        self.dropped = False  # True if the last character ended a wrong message.

    def take(self, character: int) -> Frame | None:
        """Return the data format if this character ends a valid message."""
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


def only_at_initialisation(_: Step) -> str:
    """Commands ( * U V: baud rate detection, erasing, data format.  Obeyed during initialisation.

    After initialisation they are a data fault.  While the interface is locked, `(` begins the initialisation again if
    DSR is active and nothing moves.  Chapters Initialisation, Breaking into a locked state.
    """
    return "for initialisation only"
