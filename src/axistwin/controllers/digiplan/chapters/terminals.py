"""Chapter Installation, appendix 2: the place of each line on the motherboard and on the edge of the card."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Terminal:
    """One line.  Connectors PL1 to PL6 are on the motherboard, rows A and C on the edge of the card."""

    place: str
    edge: str
    high: str
    """Meaning of a high level."""
    circuit: str = ""
    """The manual's type of circuit: A input, D output."""

    def __str__(self) -> str:
        return self.place


FLOWS, ON = "current flows: +24 V", "the transistor is on"
CLOSED = f"{FLOWS}, the switch is closed"
WELL = "the drive is well, or its fault disable link is fitted"

TERMINALS = {
    "input1": Terminal("PL1 terminal 12", "A12", FLOWS, "A"),
    "input2": Terminal("PL1 terminal 14", "C16", FLOWS, "A"),
    "input3": Terminal("PL1 terminal 13", "A16", FLOWS, "A"),
    "output1": Terminal("PL1 terminal 3", "C5", ON, "D"),
    "output2": Terminal("PL1 terminal 5", "A6", ON, "D"),
    "output3": Terminal("PL1 terminal 8", "C7", ON, "D"),
    "output4": Terminal("PL1 terminal 9", "A8", ON, "D"),
    "output5": Terminal("PL1 terminal 1", "C2", ON, "D"),
    "estop": Terminal("PL3 terminal 1", "C13", CLOSED, "A"),
    "limit_plus": Terminal("PL3 terminal 2", "C17", CLOSED, "A"),
    "limit_minus": Terminal("PL3 terminal 3", "A17", CLOSED, "A"),
    "supply": Terminal("links 1 and 2, or PL3 terminal 8", "A10", "the outputs have their +24 V"),
    "x_fault": Terminal("PL4, or link 3", "A13", WELL),
    "y_fault": Terminal("PL5, or link 4", "C12", WELL),
    "x_direction": Terminal("PL4", "A3", "positive"),
    "y_direction": Terminal("PL5", "C3", "positive"),
    "z_direction": Terminal("PL6", "A4", "positive"),
    "x_clock": Terminal("PL4", "C20", "for 5 µs from each pulse on"),
    "y_clock": Terminal("PL5", "C21", "for 5 µs from each pulse on"),
    "z_clock": Terminal("PL6", "C19", "for 5 µs from each pulse on"),
    "dtr": Terminal("PL2 pin 20", "A28", "set: +12 V"),
    "rts": Terminal("PL2 pin 4", "C28", "set: +12 V"),
    "dsr": Terminal("PL2 pin 6", "A27", "set: +12 V"),
    "cts": Terminal("PL2 pin 5", "C27", "set: +12 V"),
}
"""By the names of the pins."""


@dataclass(frozen=True)
class Link:
    """A link, and its counterpart in the emulation."""

    name: str
    purpose: str
    here: str


LINKS = (
    Link("links 1 and 2, motherboard", "the outputs take their +24 V from the drives", "pin `supply`"),
    Link("link 3, motherboard", "simulates a working X drive", "pin `x_fault`: high, as fitted; low for a fault"),
    Link("link 4, motherboard", "simulates a working Y drive", "pin `y_fault`: high, as fitted; low for a fault"),
    Link("link 3, interface card", "position b: output 5 follows the LED", "option `fault_output = true`"),
)


@dataclass(frozen=True)
class Cable:
    """The connection of the inputs DSR and CTS: `host`, the interface's own `dtr` or `rts`, or nothing (empty)."""

    dsr: str
    cts: str
    purpose: str


FIVE_WIRE = Cable("host", "host", "the host's DTR on DSR, its RTS on CTS")
THREE_WIRE = Cable("rts", "rts", "DSR and CTS linked to the interface's own RTS")

CABLES = {
    "5-wire": FIVE_WIRE,
    "3-wire": THREE_WIRE,
    "3-wire DSR-DTR": Cable("dtr", "rts", "DSR linked to the interface's own DTR, CTS to its RTS"),
    "3-wire unlinked": Cable("", "", "nothing on DSR and CTS: R14 and R15 hold them reset, nothing is transmitted"),
    "NEC PC-8201A": THREE_WIRE,
    "Epson HX20 3-wire": THREE_WIRE,
    "Epson HX20 5-wire": FIVE_WIRE,
    "IBM PC 3-wire": THREE_WIRE,
    "IBM PC 5-wire": FIVE_WIRE,
}
"""Chapters The RS232C control lines, Alternative connection methods, Running the stored sequence; appendix 3."""
