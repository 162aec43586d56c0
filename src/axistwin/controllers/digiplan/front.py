"""Front panel of an IF1 or IF2: its only lamp, its terminals, and the values of its status commands.

Chapters Configuring the interface, Installation, The RS232C control lines, Report-back functions, Clearing fault
conditions.
"""

from axistwin.controllers.digiplan.chapters.motion import DIRECTIONS
from axistwin.controllers.digiplan.chapters.terminals import TERMINALS
from axistwin.controllers.digiplan.state import Stage
from axistwin.controllers.front import Group, Lamp, Reading, Tone, Word

OFF = "off"
STATES = {stage.value: stage.value for stage in Stage} | {OFF: "no power"}
BUSY = {"[": "locked", "F": "fault", "E": "busy", "C": "clear for new commands", "": "no answer yet", OFF: "off"}
CONFIGURING, INSTALLATION, LINES = "Configuring the interface", "Installation", "The RS232C control lines"
CLOSED = "Normally closed: it must be held at +24 V."
STOP = f"{CLOSED}  K or Q clears the fault when current flows again; while locked, only switching the power off does."
LIMIT = f"{CLOSED}  K or Q clears the fault, even while the switch is open; the lamp goes out when current flows again."
DRIVE = "The axis stops without deceleration."
SUPPLY = "All outputs are off without this supply, from the drives through links 1 and 2 or from outside."


def _lamp(label: str, name: str, pin: str, doc: str = "", *, lit: bool = True, tone: Tone = Tone.PLAIN) -> Lamp:
    return Lamp(label, name, pin, lit=lit, tone=tone, doc=f"{doc}  {TERMINALS[pin]}.".strip())


FRONT = (
    Group("Interface", CONFIGURING, (
        Lamp("LED", "fault lamp", "led", tone=Tone.FAULT, doc=(
            "On for about a second after power-up, then flashes twice per second until the data format is received.  "
            "After that, on from a fault, limit or emergency stop until K or Q has been read and the cause is gone.")),
        Word("", "state", "state", STATES, unpowered="no power"),
        Word("E", "busy status", "E", BUSY, {"F": Tone.FAULT, "[": Tone.WARNING}, doc="Answer to the command E."),
        Reading("O", "step of the sequence", "O", doc="Answer to the command O: 1 to 63; 0 before the first step."),
        Reading("N", "steps since the last index or run began", "N", "steps", doc="Answer to the command N."),
    )),
    Group("Outputs", f"{INSTALLATION}: Using the optically-isolated outputs", (
        *(_lamp(f"{n}", f"output {n}", f"output{n}") for n in range(1, 5)),
        _lamp("5", "output 5", "output5", "Follows the LED if link 3 of the card is in position b."),
        _lamp("24 V", "supply of the outputs", "supply", SUPPLY),
    ), row=True),
    Group("Lines", LINES, (
        _lamp("DTR", "data terminal ready", "dtr", "Output: the interface accepts characters."),
        _lamp("RTS", "request to send", "rts", "Output: the interface is about to transmit."),
        _lamp("DSR", "data set ready", "dsr", "Input: nothing is transmitted unless DSR and CTS are on."),
        _lamp("CTS", "clear to send", "cts", "Input: nothing is transmitted unless DSR and CTS are on."),
    ), row=True),
    Group("Stops and limits", f"{INSTALLATION}: Emergency stop and limit inputs", (
        _lamp("STOP", "emergency stop", "estop", STOP, lit=False, tone=Tone.FAULT),
        _lamp("+", "plus limit", "limit_plus", f"{LIMIT}  Then minus moves are allowed.", lit=False, tone=Tone.FAULT),
        _lamp("−", "minus limit", "limit_minus", f"{LIMIT}  Then plus moves are allowed.", lit=False, tone=Tone.FAULT),
        _lamp("X", "drive fault of X", "x_fault", DRIVE, lit=False, tone=Tone.FAULT),
        _lamp("Y", "drive fault of Y", "y_fault", DRIVE, lit=False, tone=Tone.FAULT),
    ), row=True),
    Group("Inputs", f"{INSTALLATION}: Using the optically-isolated inputs", tuple(
        _lamp(f"{n}", f"input {n}", f"input{n}", "Lit while current flows: high.") for n in range(1, 4)
    ), row=True),
    Group("Directions", f"{INSTALLATION}: Motherboard connector identification", tuple(
        _lamp(axis, f"direction of {axis}", pin, "Lit while high: positive.") for axis, pin in DIRECTIONS.items()
    ), row=True),
    Group("Motion status K", "Report-back functions: Motion status", (
        Lamp("1", "in motion", "Q", 0),
        Lamp("2", "at programmed speed", "Q", 1),
        Lamp("4", "accelerating", "Q", 2),
        Lamp("8", "decelerating", "Q", 3),
        Lamp("16", "drive fault", "Q", 4, tone=Tone.FAULT, doc="K or Q clears it when the cause is gone."),
        Lamp("32", "emergency stop", "Q", 5, tone=Tone.FAULT, doc="K or Q clears it when the cause is gone."),
        Lamp("64", "limit", "Q", 6, tone=Tone.FAULT, doc="K or Q clears it; then the axis can leave the limit."),
        Lamp("128", "communication fault", "Q", 7, tone=Tone.WARNING, doc="F reports the fault and clears it."),
    ), row=True),
    Group("Communication status F", "Report-back functions: Motion status", (
        Lamp("1", "parity fault", "F", 0, tone=Tone.WARNING),
        Lamp("2", "overrun", "F", 1, tone=Tone.WARNING, doc="A character arrived before the previous one was read."),
        Lamp("4", "framing fault", "F", 2, tone=Tone.WARNING),
        Lamp("8", "data fault", "F", 3, tone=Tone.WARNING, doc="A wrong message, or the buffer overflowed."),
        Lamp("16", "out of range", "F", 4, tone=Tone.WARNING),
        Lamp("32", "locked", "F", 5, doc="From [ until ]; not a fault."),
    ), row=True),
)  # fmt: skip
