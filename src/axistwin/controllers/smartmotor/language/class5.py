"""Words of the later generation, Class 5, and their equivalents in firmware 4.76.

The words of a program show the generation for which it was written.  A Class 5 motor has 8000 samples per second, so
its units of speed and acceleration differ from those of 4.76; the unit of position is the same.
"""

import re
from typing import NamedTuple

from axistwin.numbers import clipped

PINS = "ABCDEFG"
"""Letters of the pins in the order of their Class 5 numbers, from 0."""
RATES = "its value is for 8000 samples/s, 4.76 has 4069"
RAMPS = f"one acceleration for both ramps; {RATES}"


class Later(NamedTuple):
    """Table entry: a command or variable of newer SmartMotors (Class 5), and its equivalent in firmware 4.76.

    `form`: pattern that finds the word of Class 5.  `here`: the word of firmware 4.76.  `sure`: True if the values of
    both words are in the same unit.
    """

    form: str
    here: str
    note: str = ""
    sure: bool = False


class Found(NamedTuple):
    """A command or variable of newer SmartMotors (Class 5), and its equivalent in firmware 4.76."""

    word: str
    here: str
    note: str
    sure: bool


COMMANDS = (
    Later(r"PT=(?P<v>.+)", r"P=\g<v>", sure=True),
    Later(r"PRT=(?P<v>.+)", r"D=\g<v>", sure=True),
    Later(r"EL=(?P<v>.+)", r"E=\g<v>", sure=True),
    Later(r"VT=(?P<v>.+)", r"V=\g<v>", RATES),
    Later(r"(?:ADT|AT|DT)=(?P<v>.+)", r"A=\g<v>", RAMPS),
    Later(r"EIGN\(2\)", "UCI", sure=True),
    Later(r"EIGN\(3\)", "UDI", sure=True),
    Later(r"EIGN\(W,0(?:,12)?\)", "UCI UDI", sure=True),
    Later(r"EIGN\((?P<pin>[0-6])\)", "U{pin}I", sure=True),
    Later(r"EILP", "UCP", sure=True),
    Later(r"EILN", "UDM", sure=True),
    Later(r"EISM\(6\)", "UG", sure=True),
    Later(r"EOBK\(-1\)", "BRKI", sure=True),
    Later(r"EOBK\(2\)", "BRKC", sure=True),
    Later(r"EOBK\(6\)", "BRKG", sure=True),
    Later(r"EOBK\(.*\)", "BRKI, BRKC or BRKG"),
    Later(r"OUT\((?P<pin>[0-6])\)=(?P<v>.+)", r"U{pin}=\g<v>", "U{pin}O makes the pin an output"),
    Later(r"OS\((?P<pin>[0-6])\)", "U{pin}=1", "U{pin}O makes the pin an output"),
    Later(r"OR\((?P<pin>[0-6])\)", "U{pin}=0", "U{pin}O makes the pin an output"),
    Later(r"RIN\((?P<pin>[0-6])\)", "RU{pin}", sure=True),
    Later(r"RPA", "RP", sure=True),
    Later(r"REA", "RPE", sure=True),
    Later(r"RVA", "RV", RATES),
    Later(r"RCTR\([01]\)", "RCTR", sure=True),
    Later(r"RW\(\d+\)", "RW", "the bits differ"),
    Later(r"RB\(\d+,\d+\)", "RBx with the flag's letter"),
    Later(r"(MV|MP|MT|MC|G|X|S|TWAIT)\((?:\d+)?\)", r"\1"),
    Later(r"(MFR|MSR)\(\d+\)", r"\1"),
    Later(r"(?:MFA|MFD|MFSLEW|MFH|MFL|MFCTP|MFSDC)\(.*\)", "MFMUL=, MFDIV= and MFR"),
    Later(r"(?:CTE|CTA|CTW)\(.*\)", "aw[], SIZE= and BASE="),
    Later(r"PRINT0(?P<v>\(.*\))", r"PRINT\g<v>", sure=True),
    Later(r"(?:EITR|DITR|ITR|ITRE|ITRD)(?:\(.*\))?", "F=32 with label C1 and F=64 with C2"),
    Later(r"FSA\(.*\)", "F="),
    Later(r"Z\(.*\)", "ZS, or Z with the flag's letter"),
    Later(r"BAUD\([01]\)=(?P<v>.+)", r"BAUD\g<v>"),
    Later(r"ADDR=(?P<v>\d+)", r"SADDR\g<v>", sure=True),
    Later(r"ADDR=.+", "SADDR1", "with the number of the motor; a motor has no other address before"),
    Later(r"(GOSUB|GOTO)\((?P<n>\d+)\)", r"\1\g<n>", sure=True),
    Later(r"(GOSUB|GOTO)\(.+\)", r"\g<1>1", "the label is a number"),
    Later(
        r"(?P<word>[A-Z]+):\d+(?P<v>.*)",
        r"\g<word>\g<v>",
        "the address byte of the motor, 128 + its number, comes before it",
    ),
    Later(r"(?:PTS|PRTS|PTSS|PRTSS)\(.*\)", "P=0", "in each motor, with its own target"),
    Later(r"VTS=(?P<v>.+)", r"V=\g<v>", "in each motor, in proportion to its distance"),
    Later(r"(?:ADTS|ATS|DTS)=(?P<v>.+)", r"A=\g<v>", "in each motor, in proportion to its distance"),
    Later(r"GS", "G", "the global address 128 before it starts all motors"),
    Later(r"TSWAIT", "TWAIT", "in each motor"),
    Later(r"SRAND\(.*\)|SRAND=.*", "a=CLK", "4.76 has no random numbers"),
)
"""Class 5 commands, in the order in which the patterns are tried."""
VALUES = (
    Later(r"PA", "@P", sure=True),
    Later(r"EA", "@PE", sure=True),
    Later(r"VA", "@V", RATES),
    Later(r"PT", "P", sure=True),
    Later(r"PRT", "D", sure=True),
    Later(r"VT", "V", RATES),
    Later(r"(?:AT|DT)", "A", RAMPS),
    Later(r"EL", "E", sure=True),
    Later(r"INA", "UAA to UGA"),
    Later(r"IN", "UA to UG"),
    Later(r"RAND", "CLK", "4.76 has no random numbers"),
    Later(r"B", "Bt", "or another letter of the manual's status flags"),
)


def message(found: Found) -> str:
    """Return an error message about a command or variable of Class 5 (later SmartMotors)."""
    note = f" ({found.note})" if found.note else ""
    return f"{found.word} is a word of Class 5, which sets Bs here: 4.76 uses {found.here}{note}"


def find(text: str, table: tuple[Later, ...]) -> Found | None:
    """Recognise a command or variable of newer SmartMotors (Class 5), e.g. `PT=100`.

    Return the word and its equivalent in firmware 4.76, or None if no entry of `table` matches `text`.
    """
    for later in table:
        if match := re.fullmatch(later.form, text, re.ASCII):
            pin = PINS[int(match["pin"])] if "pin" in match.re.groupindex else ""
            here = match.expand(later.here.replace("{pin}", pin))
            word = text[: match.start("v")] if "v" in match.re.groupindex else text
            return Found(clipped(word), here, later.note.replace("{pin}", pin), later.sure)
    return None
