"""Chapter Installation: the place of each line on the motherboard (appendix 2), and cables (appendix 3)."""

from typing import NamedTuple

TERMINALS = {
    "input1": "PL1 terminal 12", "input2": "PL1 terminal 14", "input3": "PL1 terminal 13", "output1": "PL1 terminal 3",
    "output2": "PL1 terminal 5", "output3": "PL1 terminal 8", "output4": "PL1 terminal 9", "output5": "PL1 terminal 1",
    "estop": "PL3 terminal 1", "limit_plus": "PL3 terminal 2", "limit_minus": "PL3 terminal 3",
    "supply": "links 1 and 2, or PL3 terminal 8", "x_fault": "PL4, or link 3", "y_fault": "PL5, or link 4",
    "x_direction": "PL4", "y_direction": "PL5", "z_direction": "PL6", "x_clock": "PL4", "y_clock": "PL5",
    "z_clock": "PL6", "dtr": "PL2 pin 20", "rts": "PL2 pin 4", "dsr": "PL2 pin 6", "cts": "PL2 pin 5",
}  # fmt: skip
"""Connectors by the names of the pins: PL1 to PL6 are on the motherboard."""


class Cable(NamedTuple):
    """A cable: the lines that drive DSR and CTS: `host`, the interface's own `dtr` or `rts`, or "" for none."""

    dsr: str
    cts: str
    purpose: str


FIVE_WIRE = Cable("host", "host", "the host's DTR on DSR, its RTS on CTS")
THREE_WIRE = Cable("rts", "rts", "DSR and CTS linked to the interface's own RTS")

CABLES = {
    "5-wire": FIVE_WIRE,
    "3-wire": THREE_WIRE,
    "3-wire DSR-DTR": Cable("dtr", "rts", "DSR linked to the interface's own DTR, CTS to its RTS"),
    "3-wire unlinked": Cable("", "", "DSR and CTS open: R14 and R15 hold them reset, nothing is transmitted"),
    "NEC PC-8201A": THREE_WIRE,
    "Epson HX20 3-wire": THREE_WIRE,
    "Epson HX20 5-wire": FIVE_WIRE,
    "IBM PC 3-wire": THREE_WIRE,
    "IBM PC 5-wire": FIVE_WIRE,
}
"""Chapters The RS232C control lines, Alternative connection methods, Running the stored sequence; appendix 3."""
