"""Every value that can be used in an expression, one name per line (8 and 6.1; 6 of the base language).

A value is a slot of the processor's state, a variable, or a number that the interpreter computes.  Values from a
communication channel or from the AniLink bus are fetched (`fetch`) before the statement is executed.
"""

import re
from collections.abc import Callable, Sequence
from string import ascii_lowercase
from typing import NamedTuple

from axistwin.controllers.smartmotor.chapters import io
from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.kernel import state
from axistwin.controllers.smartmotor.kernel.interpreter import store
from axistwin.controllers.smartmotor.processor import Processor

NOTHING = -1


class Variable(NamedTuple):
    """A variable such as `aa`; the interpreter reads it by `operation` at the index `place`."""

    name: str
    operation: int
    place: int
    unit: str = ""
    chapter: str = ""
    fetch: Callable[[Processor], int] | None = None
    """Function that fetches an external value; the statement reads it from a hidden variable."""


# Chapters of the SmartMotor manuals, e.g. "9.1 Cam"
IO, ARRAYS, CAM, FUNCTIONS, SOFT = "6.0 Inputs/outputs", "8.2 Arrays", "9.1 Cam", "7.0 F=", "3.2 Software limits"
STATUS, FAULTS, MOTION, TUNING = "Status word", "4.0 Fault handling", "Motion parameters", "PID filter"
MODES, SERIAL, EEPROM, NAMED, ANILINK = "Modes", "Communications", "EEPROM", "Variables", "AniLink"
SPEED, GAIN = "1/65536 count/sample", "1/65536 count/sample²"

V = Variable

# fmt: off
TABLE = (
    V("@P",      ops.COMPUTED, ops.POSITION,        "counts",  MOTION),
    V("@PE",     ops.COMPUTED, ops.POSITION_ERROR,  "counts",  MOTION),
    V("@V",      ops.SLOT,     state.VELOCITY,     SPEED,     MOTION),
    V("A",       ops.SLOT,     state.A,            GAIN,      MOTION),
    V("V",       ops.SLOT,     state.V,            SPEED,     MOTION),
    V("P",       ops.SLOT,     state.P,             "counts",  MOTION),
    V("D",       ops.SLOT,     state.D,             "counts",  MOTION),
    V("T",       ops.SLOT,     state.T,             "1/1023",  MOTION),
    V("E",       ops.SLOT,     state.E,             "counts",  MOTION),
    V("AMPS",    ops.SLOT,     state.AMPS,          "1/1023",  MOTION),
    V("TH",      ops.SLOT,     state.TH,            "°C",      MOTION),
    V("THD",     ops.SLOT,     state.THD,           "samples", MOTION),
    V("CLK",     ops.COMPUTED, ops.CLOCK,           "samples", MOTION),
    V("MFMUL",   ops.SLOT,     state.MFMUL,         "",        MODES),
    V("MFDIV",   ops.SLOT,     state.MFDIV,         "",        MODES),
    V("BASE",    ops.SLOT,     state.BASE,          "counts",  CAM),
    V("SIZE",    ops.SLOT,     state.SIZE,          "",        CAM),
    V("CX",      ops.SLOT,     state.CX,            "",        CAM),
    V("CTR",     ops.SLOT,     state.CTR,           "counts",  MODES),
    V("I",       ops.COMPUTED, ops.INDEX_POSITION,  "counts",  MODES),
    V("SLN",     ops.SLOT,     state.SLN,           "counts",  SOFT),
    V("SLP",     ops.SLOT,     state.SLP,           "counts",  SOFT),
    V("F",       ops.SLOT,     state.F,             "",        FUNCTIONS),
    V("KP",      ops.SLOT,     state.KP,            "",        TUNING),
    V("KI",      ops.SLOT,     state.KI,            "",        TUNING),
    V("KD",      ops.SLOT,     state.KD,            "",        TUNING),
    V("KL",      ops.SLOT,     state.KL,            "",        TUNING),
    V("KS",      ops.SLOT,     state.KS,            "samples", TUNING),
    V("KV",      ops.SLOT,     state.KV,            "",        TUNING),
    V("KA",      ops.SLOT,     state.KA,            "",        TUNING),
    V("KG",      ops.SLOT,     state.KG,            "",        TUNING),
    V("W",       ops.COMPUTED, ops.STATUS_WORD,     "",        STATUS),
    V("S",       ops.COMPUTED, ops.STATUS_BYTE,     "",        STATUS),
    V("Bt",      ops.SLOT,     state.BT,            "",        STATUS),
    V("Br",      ops.SLOT,     state.BR,            "",        FAULTS),
    V("Bl",      ops.SLOT,     state.BL,            "",        FAULTS),
    V("Bi",      ops.SLOT,     state.BI,            "",        STATUS),
    V("Bw",      ops.SLOT,     state.BW,            "",        STATUS),
    V("Be",      ops.SLOT,     state.BE,            "",        FAULTS),
    V("Bh",      ops.SLOT,     state.BH,            "",        FAULTS),
    V("Bo",      ops.SLOT,     state.BO,            "",        STATUS),
    V("Bx",      ops.SLOT,     state.BX,            "",        STATUS),
    V("Bp",      ops.SLOT,     state.BP,            "",        FUNCTIONS),
    V("Bm",      ops.SLOT,     state.BM,            "",        FUNCTIONS),
    V("Bd",      ops.SLOT,     state.BD,            "",        STATUS),
    V("Bu",      ops.SLOT,     state.BU,            "",        STATUS),
    V("Bs",      ops.SLOT,     state.BS,            "",        STATUS),
    V("Ba",      ops.SLOT,     state.BA,            "",        STATUS),
    V("Bk",      ops.SLOT,     state.BK,            "",        STATUS),
    V("Bb",      ops.SLOT,     state.BB,            "",        STATUS),
    V("Bc",      ops.SLOT,     state.BC,            "",        STATUS),
    V("Bf",      ops.SLOT,     state.BF,            "",        STATUS),
    V("U",       ops.COMPUTED, ops.PIN_WORD,        "",        IO),
    *(V(f"U{pin}",  ops.PIN,  number,                "",       IO) for number, pin in enumerate(state.USER_PINS)),
    *(V(f"U{pin}I", ops.PIN,  number,                "",       IO) for number, pin in enumerate(state.USER_PINS)),
    *(V(f"U{pin}A", ops.SLOT, state.ANALOG + number, "5/1023 V", IO) for number, pin in enumerate(state.USER_PINS)),
    V("UIA",     ops.SLOT,     state.CURRENT,       "0.01 A",  IO),
    V("UJA",     ops.SLOT,     state.BUS_VOLTAGE,   "0.1 V",   IO),
    V("TEMP",    ops.SLOT,     state.TEMP,          "°C",      IO),
    V("ADDR",    ops.SLOT,     state.ADDR,          "",        SERIAL),
    V("LEN",     ops.SLOT,     state.LENGTHS,       "bytes",   SERIAL),
    V("LEN1",    ops.SLOT,     state.LENGTHS + 1,   "bytes",   SERIAL),
    V("GETCHR",  ops.VARIABLE, NOTHING,             "",        SERIAL, lambda motor: motor.channels[0].get_character()),
    V("GETCHR1", ops.VARIABLE, NOTHING,             "",        SERIAL, lambda motor: motor.channels[1].get_character()),
    V("EPTR",    ops.SLOT,     state.EPTR,          "bytes",   EEPROM),
    *(V(letter,     ops.VARIABLE, state.LETTERS + number, "", NAMED) for number, letter in enumerate(ascii_lowercase)),
    *(V(letter * 2, ops.VARIABLE, state.DOUBLES + number, "", NAMED) for number, letter in enumerate(ascii_lowercase)),
    *(V(letter * 3, ops.VARIABLE, state.TRIPLES + number, "", NAMED) for number, letter in enumerate(ascii_lowercase)),
)
# fmt: on

NAMES = {variable.name: variable for variable in TABLE}

ARRAY_SIZES = {"ab": (ops.BYTE, state.BYTES), "aw": (ops.WORD, state.WORDS), "al": (ops.LONG, state.LONGS)}
"""The arrays: operation, and number of elements (manual, section 8.2)."""

_device = re.compile(r"([AD])IN([A-H])(\d{1,2})", re.ASCII)
ANALOG_CHANNELS, DIGITAL_CHANNELS = range(1, 5), range(64)


NO_VALUE = "it cannot be computed or stored: an overflow, a division by 0 (Bd), or no such array element (Bu)"


def find(name: str) -> Variable | None:
    """Return the variable of this name.  AINpc and DINpc: device p = A…H, channel c = 1…4 analog, 0…63 digital."""
    return NAMES.get(name) or _input(name)


def _input(name: str) -> Variable | None:
    match = _device.fullmatch(name)
    if match is None:
        return None
    if int(match[3]) not in (ANALOG_CHANNELS if match[1] == "A" else DIGITAL_CHANNELS):
        return None
    return Variable(name, ops.VARIABLE, NOTHING, "", ANILINK, io.fetch_input)


def assign(motor: Processor, place: int, value: int) -> None:
    """a=exp, aa=exp …: set a signed 32-bit variable; a value that does not fit only sets Bd."""
    motor.v[place] = value


def assign_elements(motor: Processor, code: Sequence[int]) -> None:
    """ab[]=, aw[]=, al[]=: set an array element to the low 8, 16 or 32 bits of the value.

    The elements are ab[0…203], aw[0…101], al[0…50]; other indices set Bu (manual, section 8.2).

    `aw[0] 0 100 500.` sets consecutive elements (manual, section 1.1).  An invalid index ends the list; the
    elements before it are set.
    """
    i = motor.i
    before = i[state.BU], i[state.BD]
    i[state.BU] = i[state.BD] = 0
    store(i, motor.v, [0] * ops.STACK, code, 0)
    if i[state.BU] or i[state.BD]:
        motor.refuse(NO_VALUE)
    i[state.BU] |= before[0]
    i[state.BD] |= before[1]


def values(letters: str) -> range | None:
    """Return the places in `v` of a variable and its successors in the group; None if there is none."""
    variable = NAMES.get(letters)
    if variable is None or variable.chapter != NAMED:
        return None
    return range(variable.place, variable.place + 26 - (ord(letters[0]) - ord("a")))
