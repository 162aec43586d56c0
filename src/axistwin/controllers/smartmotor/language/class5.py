"""Words of the later generation, Class 5, and their equivalents in firmware 4.76.

The words of a program show the generation for which it was written.  A Class 5 motor has 8000 samples per second, so
speeds and accelerations have another unit; positions have the same unit.
"""

import re
from typing import NamedTuple

from axistwin.numbers import clipped

PINS = "ABCDEFG"
"""Pins by their Class 5 numbers, from 0."""
RATES = "its number is for 8000 samples/s, here there are 4069"
RAMPS = f"one acceleration for both ramps; {RATES}"


class Later(NamedTuple):
    """A form of Class 5.  `here`: the form in 4.76, in terms of the groups; `sure`: the values have the same unit."""

    form: re.Pattern[str]
    here: str
    note: str = ""
    sure: bool = False


class Found(NamedTuple):
    """A Class 5 word that has been recognised, and what 4.76 has for it."""

    word: str
    here: str
    note: str
    sure: bool


def _later(form: str, here: str, note: str = "", *, sure: bool = False) -> Later:
    return Later(re.compile(form, re.ASCII), here, note, sure)


COMMANDS = (
    _later(r"PT=(?P<v>.+)", r"P=\g<v>", sure=True),
    _later(r"PRT=(?P<v>.+)", r"D=\g<v>", sure=True),
    _later(r"EL=(?P<v>.+)", r"E=\g<v>", sure=True),
    _later(r"VT=(?P<v>.+)", r"V=\g<v>", RATES),
    _later(r"(?:ADT|AT|DT)=(?P<v>.+)", r"A=\g<v>", RAMPS),
    _later(r"EIGN\(2\)", "UCI", sure=True),
    _later(r"EIGN\(3\)", "UDI", sure=True),
    _later(r"EIGN\(W,0(?:,12)?\)", "UCI UDI", sure=True),
    _later(r"EIGN\((?P<pin>[0-6])\)", "U{pin}I", sure=True),
    _later(r"EILP", "UCP", sure=True),
    _later(r"EILN", "UDM", sure=True),
    _later(r"EISM\(6\)", "UG", sure=True),
    _later(r"EOBK\(-1\)", "BRKI", sure=True),
    _later(r"EOBK\(2\)", "BRKC", sure=True),
    _later(r"EOBK\(6\)", "BRKG", sure=True),
    _later(r"EOBK\(.*\)", "BRKI, BRKC or BRKG"),
    _later(r"OUT\((?P<pin>[0-6])\)=(?P<v>.+)", r"U{pin}=\g<v>", "U{pin}O makes the pin an output"),
    _later(r"OS\((?P<pin>[0-6])\)", "U{pin}=1", "U{pin}O makes the pin an output"),
    _later(r"OR\((?P<pin>[0-6])\)", "U{pin}=0", "U{pin}O makes the pin an output"),
    _later(r"RIN\((?P<pin>[0-6])\)", "RU{pin}", sure=True),
    _later(r"RPA", "RP", sure=True),
    _later(r"REA", "RPE", sure=True),
    _later(r"RVA", "RV", RATES),
    _later(r"RCTR\([01]\)", "RCTR", sure=True),
    _later(r"RW\(\d+\)", "RW", "the bits are others"),
    _later(r"RB\(\d+,\d+\)", "RBx with the flag's letter"),
    _later(r"(MV|MP|MT|MC|G|X|S|TWAIT)\((?:\d+)?\)", r"\1"),
    _later(r"(MFR|MSR)\(\d+\)", r"\1"),
    _later(r"(?:MFA|MFD|MFSLEW|MFH|MFL|MFCTP|MFSDC)\(.*\)", "MFMUL=, MFDIV= and MFR"),
    _later(r"(?:CTE|CTA|CTW)\(.*\)", "aw[], SIZE= and BASE="),
    _later(r"PRINT0(?P<v>\(.*\))", r"PRINT\g<v>", sure=True),
    _later(r"(?:EITR|DITR|ITR|ITRE|ITRD)(?:\(.*\))?", "F=32 with label C1 and F=64 with C2"),
    _later(r"FSA\(.*\)", "F="),
    _later(r"Z\(.*\)", "ZS, or Z with the flag's letter"),
    _later(r"BAUD\([01]\)=(?P<v>.+)", r"BAUD\g<v>"),
    _later(r"ADDR=(?P<v>.+)", r"SADDR\g<v>"),
)
"""In the order in which they are tried."""
VALUES = (
    _later(r"PA", "@P", sure=True),
    _later(r"EA", "@PE", sure=True),
    _later(r"VA", "@V", RATES),
    _later(r"PT", "P", sure=True),
    _later(r"PRT", "D", sure=True),
    _later(r"VT", "V", RATES),
    _later(r"(?:AT|DT)", "A", RAMPS),
    _later(r"EL", "E", sure=True),
    _later(r"INA", "UAA to UGA"),
    _later(r"IN", "UA to UG"),
)
"""Values of expressions, by name."""


def command(text: str) -> Found | None:
    """Return the Class 5 command that a statement is; None: it is none."""
    return _find(text, COMMANDS)


def value(name: str) -> Found | None:
    """Return the Class 5 value of this name; None: there is none."""
    return _find(name, VALUES)


def message(found: Found) -> str:
    """Return the message of the checker."""
    note = f" ({found.note})" if found.note else ""
    return f"{found.word} is a word of Class 5, which sets Bs here: 4.76 uses {found.here}{note}"


def _find(text: str, table: tuple[Later, ...]) -> Found | None:
    for later in table:
        if match := later.form.fullmatch(text):
            pin = PINS[int(match["pin"])] if "pin" in later.form.groupindex else ""
            here = match.expand(later.here.replace("{pin}", pin))
            word = text[: match.start("v")] if "v" in later.form.groupindex else text
            return Found(clipped(word), here, later.note.replace("{pin}", pin), later.sure)
    return None
