"""Chapter 8 and 6.1, and 6 of the base language: every value that can be used in an expression.  One line, one name.

A value is a slot of the processor's state, a variable, or computed by the interpreter.  Other values are fetched
first (`fetch`): from a communication channel or over the AniLink bus.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from string import ascii_lowercase

from axistwin.controllers.smartmotor.chapters import io
from axistwin.controllers.smartmotor.kernel import state
from axistwin.controllers.smartmotor.kernel.interpreter import (
    BYTE,
    CLOCK,
    COMPUTED,
    INDEX_POSITION,
    LONG,
    PIN,
    PIN_WORD,
    POSITION,
    POSITION_ERROR,
    SLOT,
    STACK,
    STATUS_BYTE,
    STATUS_WORD,
    VARIABLE,
    WORD,
    store,
)
from axistwin.controllers.smartmotor.processor import Processor

NOTHING = -1


@dataclass(frozen=True)
class Variable:
    """A name, and the way to read its value: an operation of the interpreter and a place."""

    name: str
    operation: int
    place: int
    unit: str = ""
    chapter: str = ""
    fetch: Callable[[Processor], int] | None = None
    """Fetches the value from outside; then it is read in the statement's own place."""


# Chapters of the manual, and of the guide for the base language
IO, ARRAYS, CAM, FUNCTIONS, SOFT = "6.0 Inputs/outputs", "8.2 Arrays", "9.1 Cam", "7.0 F=", "3.2 Software limits"
STATUS, FAULTS, MOTION, TUNING = "Status word", "4.0 Fault handling", "Motion parameters", "PID filter"
MODES, SERIAL, EEPROM, NAMED, ANILINK = "Modes", "Communications", "EEPROM", "Variables", "AniLink"
SPEED, GAIN = "1/65536 count/sample", "1/65536 count/sample²"

V = Variable

# fmt: off
TABLE = (
    V("@P",      COMPUTED, POSITION,           "counts",  MOTION),
    V("@PE",     COMPUTED, POSITION_ERROR,     "counts",  MOTION),
    V("@V",      SLOT,     state.VELOCITY,     SPEED,     MOTION),
    V("A",       SLOT,     state.A,            GAIN,      MOTION),
    V("V",       SLOT,     state.V,            SPEED,     MOTION),
    V("P",       SLOT,     state.P,            "counts",  MOTION),
    V("D",       SLOT,     state.D,            "counts",  MOTION),
    V("T",       SLOT,     state.T,            "1/1023",  MOTION),
    V("E",       SLOT,     state.E,            "counts",  MOTION),
    V("AMPS",    SLOT,     state.AMPS,         "1/1023",  MOTION),
    V("TH",      SLOT,     state.TH,           "°C",      MOTION),
    V("THD",     SLOT,     state.THD,          "samples", MOTION),
    V("CLK",     COMPUTED, CLOCK,              "samples", MOTION),
    V("MFMUL",   SLOT,     state.MFMUL,        "",        MODES),
    V("MFDIV",   SLOT,     state.MFDIV,        "",        MODES),
    V("BASE",    SLOT,     state.BASE,         "counts",  CAM),
    V("SIZE",    SLOT,     state.SIZE,         "",        CAM),
    V("CX",      SLOT,     state.CX,           "",        CAM),
    V("CTR",     SLOT,     state.CTR,          "counts",  MODES),
    V("I",       COMPUTED, INDEX_POSITION,     "counts",  MODES),
    V("SLN",     SLOT,     state.SLN,          "counts",  SOFT),
    V("SLP",     SLOT,     state.SLP,          "counts",  SOFT),
    V("F",       SLOT,     state.F,            "",        FUNCTIONS),
    V("KP",      SLOT,     state.KP,           "",        TUNING),
    V("KI",      SLOT,     state.KI,           "",        TUNING),
    V("KD",      SLOT,     state.KD,           "",        TUNING),
    V("KL",      SLOT,     state.KL,           "",        TUNING),
    V("KS",      SLOT,     state.KS,           "samples", TUNING),
    V("KV",      SLOT,     state.KV,           "",        TUNING),
    V("KA",      SLOT,     state.KA,           "",        TUNING),
    V("KG",      SLOT,     state.KG,           "",        TUNING),
    V("W",       COMPUTED, STATUS_WORD,        "",        STATUS),
    V("S",       COMPUTED, STATUS_BYTE,        "",        STATUS),
    V("Bt",      SLOT,     state.BT,           "",        STATUS),
    V("Br",      SLOT,     state.BR,           "",        FAULTS),
    V("Bl",      SLOT,     state.BL,           "",        FAULTS),
    V("Bi",      SLOT,     state.BI,           "",        STATUS),
    V("Bw",      SLOT,     state.BW,           "",        STATUS),
    V("Be",      SLOT,     state.BE,           "",        FAULTS),
    V("Bh",      SLOT,     state.BH,           "",        FAULTS),
    V("Bo",      SLOT,     state.BO,           "",        STATUS),
    V("Bx",      SLOT,     state.BX,           "",        STATUS),
    V("Bp",      SLOT,     state.BP,           "",        FUNCTIONS),
    V("Bm",      SLOT,     state.BM,           "",        FUNCTIONS),
    V("Bd",      SLOT,     state.BD,           "",        STATUS),
    V("Bu",      SLOT,     state.BU,           "",        STATUS),
    V("Bs",      SLOT,     state.BS,           "",        STATUS),
    V("Ba",      SLOT,     state.BA,           "",        STATUS),
    V("Bk",      SLOT,     state.BK,           "",        STATUS),
    V("Bb",      SLOT,     state.BB,           "",        STATUS),
    V("Bc",      SLOT,     state.BC,           "",        STATUS),
    V("Bf",      SLOT,     state.BF,           "",        STATUS),
    V("U",       COMPUTED, PIN_WORD,           "",        IO),
    *(V(f"U{pin}",  PIN,  number,                "",       IO) for number, pin in enumerate(state.USER_PINS)),
    *(V(f"U{pin}I", PIN,  number,                "",       IO) for number, pin in enumerate(state.USER_PINS)),
    *(V(f"U{pin}A", SLOT, state.ANALOG + number, "5/1023 V", IO) for number, pin in enumerate(state.USER_PINS)),
    V("UIA",     SLOT,     state.CURRENT,      "0.01 A",  IO),
    V("UJA",     SLOT,     state.BUS_VOLTAGE,  "0.1 V",   IO),
    V("TEMP",    SLOT,     state.TEMP,         "°C",      IO),
    V("ADDR",    SLOT,     state.ADDR,         "",        SERIAL),
    V("LEN",     SLOT,     state.LENGTHS,      "bytes",   SERIAL),
    V("LEN1",    SLOT,     state.LENGTHS + 1,  "bytes",   SERIAL),
    V("GETCHR",  VARIABLE, NOTHING,            "",        SERIAL, lambda motor: motor.channels[0].get_character()),
    V("GETCHR1", VARIABLE, NOTHING,            "",        SERIAL, lambda motor: motor.channels[1].get_character()),
    V("EPTR",    SLOT,     state.EPTR,         "bytes",   EEPROM),
    *(V(letter,     VARIABLE, state.LETTERS + number, "", NAMED) for number, letter in enumerate(ascii_lowercase)),
    *(V(letter * 2, VARIABLE, state.DOUBLES + number, "", NAMED) for number, letter in enumerate(ascii_lowercase)),
    *(V(letter * 3, VARIABLE, state.TRIPLES + number, "", NAMED) for number, letter in enumerate(ascii_lowercase)),
)
# fmt: on

NAMES = {variable.name: variable for variable in TABLE}

ARRAY_SIZES = {"ab": (BYTE, state.BYTES), "aw": (WORD, state.WORDS), "al": (LONG, state.LONGS)}
"""The arrays: operation, and number of elements (8.2)."""

_device = re.compile(r"([AD])IN([A-H])(\d{1,2})", re.ASCII)
ANALOG_CHANNELS, DIGITAL_CHANNELS = range(1, 5), range(64)


def find(name: str) -> Variable | None:
    """Return the variable of this name.  AINpc and DINpc: device p = A…H, channel c = 1…4 analog, 0…63 digital."""
    return NAMES.get(name) or _input(name)


def _input(name: str) -> Variable | None:
    match = _device.fullmatch(name)
    if match is None:
        return None
    kind, port, channel = match[1], match[2], int(match[3])
    if channel not in (ANALOG_CHANNELS if kind == "A" else DIGITAL_CHANNELS):
        return None
    fetch = partial(io.fetch_ain if kind == "A" else io.fetch_din, port=port, channel=channel)
    return Variable(name, VARIABLE, NOTHING, "", ANILINK, fetch)


def assign(motor: Processor, place: int, value: int) -> None:
    """a…z, aa…zz, aaa…zzz =exp: set a variable of 32 bits, signed.  A value that does not fit sets Bd and changes
    nothing.
    """
    motor.v[place] = value


def assign_elements(motor: Processor, code: Sequence[int]) -> None:
    """ab[], aw[], al[] =exp: 8, 16 or 32 bits of the value; ab[0…203], aw[0…101], al[0…50], other indices set Bu (8.2).

    `aw[0] 0 100 500.` sets consecutive elements; elements before an invalid index are set (1.1).
    """
    store(motor.i, motor.v, [0] * STACK, code, 0)


def values(letters: str) -> range | None:
    """Return the places in `v` of a named variable and its successors in the group; None if the variable does not
    exist.
    """
    variable = NAMES.get(letters)
    if variable is None or variable.chapter != NAMED:
        return None
    return range(variable.place, variable.place + 26 - (ord(letters[0]) - ord("a")))
