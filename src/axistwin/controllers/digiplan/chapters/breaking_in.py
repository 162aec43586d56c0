"""Chapter Breaking into a locked interface: a `(` at any baud rate begins the initialisation again."""

from fractions import Fraction

from axistwin.controllers.digiplan.chapters.data_format import Frame, uart_format
from axistwin.controllers.digiplan.chapters.initialise import BAUD_DETECT, baud_rate
from axistwin.controllers.digiplan.state import Stage, State
from axistwin.sim.frames import UartFormat
from axistwin.sim.serial import LevelAt


class BreakIn:
    """Detects a `(` in the interface's own format and, while locked, in the default format at any baud rate."""

    def __init__(self, state: State) -> None:
        self._state = state
        self._offered: UartFormat | None = None  # The default format, if the character can be `(` in it.
        self._detected: UartFormat | None = None  # Format of the last `(`.
        state.buffer.intercept = self._intercept

    def enable(self, on: bool) -> None:
        """Start or stop to detect `(` in the format U61, too; receive errors then set no fault bits."""
        self._state.buffer.checking = not on
        self._state.uart.second_look = self._offer if on else None

    @property
    def _possible(self) -> bool:
        state = self._state
        held = state.lines.dsr.level and not state.uart.sending
        return state.locked and held and state.stage is Stage.READY and not state.motion.running

    def _offer(self, low_ns: Fraction, level_at: LevelAt) -> UartFormat | None:
        """Return the default format at the measured baud rate, if a `(` in this format could have this shape."""
        self._offered = None
        rate = baud_rate(low_ns) if self._possible else None
        if rate is not None:
            other, own = uart_format(rate, Frame()), uart_format(self._state.baudrate, self._state.frame)
            seen = other.decode(level_at) if other.shape != own.shape else None
            if seen is not None and seen[0] & 0x7F == BAUD_DETECT:
                self._offered = other
        return self._offered

    def _intercept(self, byte: int) -> bool:
        """True if a character was read in another format; a `(` sets the UART to that format."""
        other, self._offered = self._offered, None
        if other is not None and byte & 0x7F == BAUD_DETECT:
            self._state.uart.format = self._detected = other
            self._state.buffer.begin_with(BAUD_DETECT)
        return other is not None

    def begins_with(self, character: int) -> bool:
        """True if a character begins a new initialisation; the UART then has the character's format."""
        if character & 0x7F != BAUD_DETECT or not (self._detected or self._possible):
            return False
        self._state.uart.format = self._detected or uart_format(self._state.baudrate, Frame())
        self._detected = None
        return True
