"""Options of an installed IF1 or IF2, and values for which the manual gives only a limit."""

from dataclasses import dataclass
from typing import Literal

from axistwin.controllers.options import check

Wiring = Literal[
    "5-wire", "3-wire", "3-wire DSR-DTR", "3-wire unlinked",
    "NEC PC-8201A", "Epson HX20 3-wire", "Epson HX20 5-wire", "IBM PC 3-wire", "IBM PC 5-wire",
]  # fmt: skip
Busy = Literal["hold", "ignore"]
Limits = Literal["any motion", "motion ahead"]
Unlock = Literal["last format", "lock format", "any format"]
LEAST_MS = 0.001  # Shortest interval of transfers from the UART.
RANGES = {"self_test_s": (0, 60), "recalculation_s": (0, 60), "strobe_ms": (LEAST_MS, 60)}


@dataclass(frozen=True)
class Options:
    """Keywords of `bench.add("if1", ...)`."""

    wiring: Wiring = "5-wire"
    """5-wire: the host's DTR on DSR, its RTS on CTS.  3-wire: DSR and CTS linked to the interface's own RTS.
    3-wire DSR-DTR: DSR linked to its own DTR, CTS to its RTS.  3-wire unlinked: not connected, so that nothing is
    transmitted.  The cables of appendix 3 are "5-wire" or "3-wire"."""
    fault_output: bool = False
    """Link 3 in position b: output 5 follows the LED and cannot be programmed."""
    busy: Busy = "hold"
    """A message with `$` during a move or sequence is held until the work has finished, or ignored."""
    limits: Limits = "any motion"
    """Motion that a limit switch stops: any motion except away from the switch, or only motion towards the switch."""
    unlock: Unlock = "last format"
    """Format of `]`: that of `[` or of a data format set since; only that of `[`; any format."""
    self_test_s: float = 1.0
    """Duration of the self-test: the LED comes on "for approximately 1 second"."""
    recalculation_s: float = 1.0
    """Time to calculate a new ramp, which "takes up to 1 second"."""
    strobe_ms: float = 1.0
    """Interval of transfers from the UART to the input buffer, "at approximately 1mS intervals"."""
    strict_format: bool = False
    """True if characters within 5 ms after the data format message are lost."""

    def __post_init__(self) -> None:
        check(self, RANGES)
