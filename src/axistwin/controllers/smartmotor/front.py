"""The front view of a SmartMotor: its status word by letter, mode, brake, temperature and position.

From the 4.76 manual are Br Bl Be Bh (table 4.1), Bo, Bt and the brake (5.1, 5.2), Bp and Bm (table 7.1).  The other
bits and the letters of RMODE are those of the base language.
"""

from axistwin.controllers.front import Group, Item, Lamp, Reading, Tone, Word
from axistwin.controllers.smartmotor.chapters.reports import LETTERS
from axistwin.controllers.smartmotor.kernel import state

FAULT, WARNING, PLAIN = Tone.FAULT, Tone.WARNING, Tone.PLAIN

BITS = (
    ("Bt", "trajectory in progress", PLAIN, ""),
    ("Br", "plus limit, historical", FAULT, "Pin C or SLP.  Zr or ZS clears it (3.1, 4.2)."),
    ("Bl", "minus limit, historical", FAULT, "Pin D or SLN.  Zl or ZS clears it (3.1, 4.2)."),
    ("Bi", "index captured", PLAIN, "Reading I clears it, and the next mark is captured."),
    ("Bw", "position has wrapped", WARNING, "Zw or ZS clears it."),
    ("Be", "position error", FAULT, "The following error has exceeded E.  Ze or ZS clears it (4.1)."),
    (
        "Bh",
        "overheat",
        FAULT,
        "Temperature above TH, or RMS current too high.  Zh or ZS clears it 5 °C below TH (4.1).",
    ),
    ("Bo", "motor off", WARNING, "The servo is off (5.2)."),
    ("Bx", "index mark", PLAIN, "The shaft is at the encoder's index mark."),
    ("Bp", "plus limit", FAULT, "Real time: pin C is high, or the position is at or beyond SLP (3)."),
    ("Bm", "minus limit", FAULT, "Real time: pin D is high, or the position is at or beyond SLN (3)."),
    ("Bd", "arithmetic overflow", WARNING, "Overflow, or division by zero.  Zd or ZS clears it."),
    ("Bu", "array index out of range", WARNING, "Zu or ZS clears it."),
    ("Bs", "syntax error", WARNING, "Zs or ZS clears it."),
    ("Ba", "over-current", WARNING, "The amplifier has limited the current.  Za or ZS clears it."),
    ("Bk", "stored program corrupt", FAULT, "The checksum is wrong.  Cleared when a valid program is stored."),
)
"""The bits of the status word W in order: letter, name, meaning of the value 1, and how the bit is cleared."""
LINE = (
    ("Bb", "parity error", "Zb or ZS clears it."),
    ("Bf", "framing error", "Zf or ZS clears it."),
    ("Bc", "communications overflow", "Zc or ZS clears it."),
)
OTHER_MODES = {
    state.M_HOLD: "servo in place", state.M_STOP: "decelerates to a stop",
    state.M_OFF: "O  off", state.M_BRAKE: "B  mode torque brake", state.M_ERROR: "E  error", state.NO_POWER: "no power",
}  # fmt: skip
MODES = {
    state.M_POSITION: "absolute position", state.M_RELATIVE: "relative position", state.M_VELOCITY: "velocity",
    state.M_TORQUE: "torque", state.M_FOLLOW: "follows the encoder", state.M_RATIO: "follows with a ratio",
    state.M_STEP: "step and direction", state.M_STEP_RATIO: "steps with a ratio", state.M_CAM: "cam",
    state.M_HOST: "host mode",
}  # fmt: skip


MOTION: tuple[Item, ...] = (
    Word("MODE", "mode", "RMODE", {mode: f"{LETTERS[mode]}  {name}" for mode, name in MODES.items()} | OTHER_MODES,
         {state.M_ERROR: FAULT}, unpowered="no power", doc=(
             "The letter is the one that RMODE reports; a servo that holds or stops reports the mode of the next G.")),
    Lamp("BRK", "static brake engaged", "brake", tone=WARNING, doc="The brake's signal is high (5.1)."),
    Reading("@P", "position", "RP", "counts"),
    Reading("@PE", "position error", "RPE", "counts", doc="Commanded less actual."),
    Reading("@V", "trajectory velocity", "RV", "counts/sample", 1 / 65536, 3),
    Reading("TEMP", "temperature", "RTEMP", "°C"),
    Reading("UIA", "motor current", "RUIA", "A", 0.01, 2),
    Reading("UJA", "bus voltage", "RUJA", "V", 0.1, 1),
)  # fmt: skip

FRONT = (
    Group("Status word W", "4.1, 7.1; status word of the base language", tuple(
        Lamp(letter, name, "RW", n, tone=tone, doc=doc) for n, (letter, name, tone, doc) in enumerate(BITS)
    ), row=True),
    Group("Channels", "Base language: communications", tuple(
        Lamp(letter, name, f"R{letter}", tone=WARNING, doc=doc) for letter, name, doc in LINE
    ), row=True),
    Group("Motor", "5.0 Brake functions; base language: modes, reports", MOTION),
    Group("User pins", "6.0 Inputs/outputs", tuple(
        Lamp(pin, f"pin {pin}", pin, doc="High: 2.0 V or more.") for pin in state.USER_PINS
    ), row=True),
)  # fmt: skip
