"""Chapter Breaking into a locked interface: a `(` at any baud rate begins the initialisation again."""

from fractions import Fraction

from axistwin.controllers.digiplan.chapters.data_format import Frame, uart_format
from axistwin.controllers.digiplan.chapters.initialise import BAUD_DETECT, baud_rate
from axistwin.controllers.digiplan.state import Stage, State
from axistwin.sim.frames import UartFormat
from axistwin.sim.serial import LevelAt


class BreakIn:
    """Detects the character `(` while the interface is locked.  The host sends `(` to start a new initialisation.

    The character is in the interface's own format, or in the default format at any baud rate.
    """

    def __init__(self, state: State) -> None:
        self._state = state
        self._offered: UartFormat | None = None
        """The default format, if the present character can be `(` in the default format; otherwise None."""
        self._detected: UartFormat | None = None
        """Format of the last character `(`: baud rate, data bits, parity and stop bits."""
        state.buffer.intercept = self._intercept

    def enable(self, on: bool) -> None:
        """Enable or disable the detection of the character `(`, which starts a new initialisation.

        During the detection, the character is also recognised in the default data format `U61`, and receive errors set
        no fault bits.
        """
        self._state.buffer.checking = not on
        self._state.uart.second_look = self._offer if on else None

    @property
    def _possible(self) -> bool:
        """True if the interface accepts the character `(` as the start of a new initialisation.

        Conditions: the interface is locked, DSR is active, and no axis moves.
        """
        state = self._state
        held = state.lines.dsr.level and not state.uart.sending
        return state.locked and held and state.stage is Stage.READY and not state.motion.running

    def _offer(self, low_ns: Fraction, level_at: LevelAt) -> UartFormat | None:
        """Check if a received character is `(`, which starts a new initialisation.

        The character is decoded in the interface's default data format.  Return the default format if the character is
        `(`.  Return None for any other character, or if the default format equals the present format.  `low_ns`:
        duration of the low level at the beginning of the character.  This duration gives the baud rate.
        """
        self._offered = None
        rate = baud_rate(low_ns) if self._possible else None
        if rate is not None:
            other, own = uart_format(rate, Frame()), uart_format(self._state.baudrate, self._state.frame)
            seen = other.decode(level_at) if other.shape != own.shape else None
            if seen is not None and seen[0] & 0x7F == BAUD_DETECT:
                self._offered = other
        return self._offered

    def _intercept(self, byte: int) -> bool:
        """Return True if the receive buffer must ignore the latest character from the host.

        The buffer must ignore a character that the UART has decoded with the default data format.  If the character is
        `(`, the UART keeps the default format, and the buffer begins with `(`.
        """
        other, self._offered = self._offered, None
        if other is not None and byte & 0x7F == BAUD_DETECT:
            self._state.uart.format = self._detected = other
            self._state.buffer.begin_with(BAUD_DETECT)
        return other is not None

    def begins_with(self, character: int) -> bool:
        """True if the received character begins a new initialisation.

        In this case, the UART is set to the format of the character.
        """
        if character & 0x7F != BAUD_DETECT or not (self._detected or self._possible):
            return False
        self._state.uart.format = self._detected or uart_format(self._state.baudrate, Frame())
        self._detected = None
        return True
