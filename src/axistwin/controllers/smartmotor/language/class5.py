"""Words of the later generation, Class 5, and their equivalents in firmware 4.76.

The words of a program show the generation for which it was written.  A Class 5 motor has 8000 samples per second, so
its units of speed and acceleration differ from those of 4.76; the unit of position is the same.
"""

import re
from typing import NamedTuple

from axistwin.core.numbers import clipped

PINS = "ABCDEFG"  # Letters of the pins in the order of their Class 5 numbers, from 0.
FLAGS = {1: "Bo", 2: "Bt", 4: "Ba", 5: "Bh", 6: "Be", 12: "Br", 13: "Bl", 14: "Bp", 15: "Bm"}
"""Flags of 4.76 that Class 5 calls B(0,n)."""
RATES = "its value is for 8000 samples/s, 4.76 has 4069"
RAMPS = f"one acceleration for both ramps; {RATES}"
OUTPUT = "U{pin}O makes the pin an output"
PATH = "each motor of the path has its own"
LETTERS = "the flags have letters"
TABLE = "a table of values, computed beforehand"
REMOTE = "for another motor of the chain, its address byte first"
EXAMPLE = "e.g. "
_PIN, _VALUE = r"\((?P<pin>[0-6])\)", r"(?P<v>.+)"
_ADDRESS = r"0*(?:\d{1,2}|1[01]\d|120)"
_NAME = r"[A-Za-z]\w*(?:\([^():]*\))?"
_ARGUMENT = r"\((?P<v>(?:[^()]|\([^()]*\))*)\)"
_word = re.compile(r'"[^"]*"|[A-Z][A-Z0-9]*(?:\([^()]*\))?', re.ASCII)


class Later(NamedTuple):
    """A pattern `form` for a Class 5 word, and `here`: what 4.76 accepts instead, or "".

    `here` is statements or a value; behind `e.g. ` an example.  `sure`: both words take values in the same unit.
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
    Later(rf"(?P<remote>{_NAME}):(?P<address>{_ADDRESS})(?P<assigned>=.*)?", "", REMOTE),
    Later(rf"{_NAME}:\w+(?:=.*)?", f'{EXAMPLE}PRINT(#129,"G ")', REMOTE),
    Later(rf"PT={_VALUE}", r"P=\g<v>", sure=True),
    Later(rf"PRT={_VALUE}", r"D=\g<v>", sure=True),
    Later(rf"EL={_VALUE}", r"E=\g<v>", sure=True),
    Later(rf"VT={_VALUE}", r"V=\g<v>", RATES),
    Later(rf"(?:ADT|AT|DT)={_VALUE}", r"A=\g<v>", RAMPS),
    Later(rf"VTS={_VALUE}", r"V=\g<v>", f"{PATH} V=; {RATES}"),
    Later(rf"(?:ADTS|ATS|DTS)={_VALUE}", r"A=\g<v>", f"{PATH} A=; {RATES}"),
    Later(r"PTSS?\((?P<v>[^;:,()]+)[;:,].*\)", r"P=\g<v>", f"{PATH} P= and G"),
    Later(r"PRTSS?\((?P<v>[^;:,()]+)[;:,].*\)", r"D=\g<v>", f"{PATH} D= and G"),
    Later(r"PTSS?\(.*\)", f"{EXAMPLE}P=1000", f"{PATH} P= and G"),
    Later(r"PRTSS?\(.*\)", f"{EXAMPLE}D=1000", f"{PATH} D= and G"),
    Later(r"GS", "G", f"{PATH} G"),
    Later(r"TSWAIT", "TWAIT", f"{PATH} TWAIT"),
    Later(r"(GOSUB|GOTO)\((\d{1,3})\)", r"\1\2", sure=True),
    Later(r"(GOSUB|GOTO)\(.*\)", rf"{EXAMPLE}SWITCH a CASE 1 \g<1>1 BREAK ENDS", "a CASE for each label"),
    Later(r"EIGN\(2\)", "UCI", sure=True),
    Later(r"EIGN\(3\)", "UDI", sure=True),
    Later(r"EIGN\(W,0(?:,12)?\)", "UCI UDI", sure=True),
    Later(rf"EIGN{_PIN}", "U{pin}I", sure=True),
    Later(r"EIGN\(.*\)", f"{EXAMPLE}UCI"),
    Later(r"EILP", "UCP", sure=True),
    Later(r"EILN", "UDM", sure=True),
    Later(r"EISM\(6\)", "UG", sure=True),
    Later(r"EOBK\(-1\)", "BRKI", sure=True),
    Later(r"EOBK\(2\)", "BRKC", sure=True),
    Later(r"EOBK\(6\)", "BRKG", sure=True),
    Later(r"EOBK\(.*\)", f"{EXAMPLE}BRKI", "or BRKC or BRKG, for a brake on pin C or G"),
    Later(rf"OUT{_PIN}={_VALUE}", r"U{pin}=\g<v>", OUTPUT),
    Later(rf"OS{_PIN}", "U{pin}=1", OUTPUT),
    Later(rf"OR{_PIN}", "U{pin}=0", OUTPUT),
    Later(r"(?:OUT\(.*\)=.*|(?:OS|OR)\(.*\))", f"{EXAMPLE}UG=1", OUTPUT.replace("{pin}", "G")),
    Later(rf"RIN{_PIN}", "RU{pin}", sure=True),
    Later(r"RIN\(.*\)", "RU"),
    Later(r"RINA\([AV]1?,(?P<pin>[0-6])\)", "RU{pin}A", "the units differ"),
    Later(r"RINA\(.*\)", f"{EXAMPLE}RUAA", "the units differ"),
    Later(r"RPA", "RP", sure=True),
    Later(r"RPC(?:\(\d\))?", "RP", "the measured position"),
    Later(r"RPT", "PRINT(P,#13)", sure=True),
    Later(r"RPRT", "RD", sure=True),
    Later(r"RVT", "PRINT(V,#13)", RATES),
    Later(r"R(?:ADT|AT|DT)", "RA", RAMPS),
    Later(r"REA", "RPE", sure=True),
    Later(r"REL", "RE", sure=True),
    Later(r"RTRQ", "RT", sure=True),
    Later(r"RV[AC]", "RV", RATES),
    Later(r"RCTR\([01]\)", "RCTR", sure=True),
    Later(r"R(?:TMR\(.*\)|RAND(?:OM)?)", "RCLK"),
    Later(r"RW\(\d+\)", "RW", "the bits differ"),
    Later(r"RB\(0,(?P<flag>\d+)\)", "R{flag}"),
    Later(r"RB\(.*\)", f"{EXAMPLE}RBt", LETTERS),
    Later(r"(MV|MP|MT|MC|G|X|S|OFF|TWAIT)\((?:\d+)?\)", r"\1"),
    Later(r"(MFR|MSR)\(\d+\)", r"\1"),
    Later(r"(?:MFA|MFD|MFSLEW|MFH|MFL|MFCTP|MFSDC|MFHTP|MFLTP)\(.*\)", f"{EXAMPLE}MFMUL=1 MFDIV=1 MFR"),
    Later(r"(?:CTE|CTA|CTW)\(.*\)", f"{EXAMPLE}SIZE=4 BASE=4000 aw[0] 0 1 2 1 0.", "the table is in aw[]"),
    Later(rf"OSH(?:\(\d*\))?={_VALUE}", r"O=@P+(\g<v>)", sure=True),
    Later(rf"O\(\d+\)={_VALUE}", r"O=\g<v>", sure=True),
    Later(r"MINV\(0\)", "F=0", "F= sets all functions at once"),
    Later(r"MINV\(1\)", "F=2", "F= sets all functions at once"),
    Later(r"PRINT[08](?P<v>\(.*\))", r"PRINT\g<v>", sure=True),
    Later(r"(ECHO|ECHO_OFF|SLEEP|WAKE|SILENT|TALK)0", r"\1", sure=True),
    Later(r"(?:EITR|DITR|ITR|ITRE|ITRD)(?:\(.*\))?", f"{EXAMPLE}F=96", "F=32 calls C1 at a fault, F=64 C2 by pin G"),
    Later(r"FSA\(.*\)", f"{EXAMPLE}F=0"),
    Later(r"Z\(.*\)", f"{EXAMPLE}ZS", "or Z with the flag's letter"),
    Later(r"BAUD\([01]\)=(2400|4800|9600|19200|38400)", r"BAUD\1"),
    Later(r"BAUD\(.*\)=.*", f"{EXAMPLE}BAUD38400", "the highest rate"),
    Later(rf"ADDR=({_ADDRESS})", r"SADDR\1"),
    Later(r"ADDR=.*", f"{EXAMPLE}SADDR1", "the address is a number, 0 to 120"),
    Later(r"TMR\(.*\)", f"{EXAMPLE}CLK=0", "CLK counts samples"),
    Later(r"S?RAND(?:OM)?(?:=.*|\(.*\))", f"{EXAMPLE}a=CLK"),
    Later(rf"af(?P<i>\[[^\]]*\])={_VALUE}", r"al\g<i>=\g<v>", "whole numbers only"),
    Later(
        r"(?:MDE|MDT|MDS|MDC|MDB|MDH|MDHV|EIRE|EIRI|GROUP|LFS|CCHN8?|RESUME|PAUSE|USB"
        r"|(?:SLM|DEL|DELM|VL|KII|KPI|CADDR|CBAUD|MCMUL|MCDIV|SRC|CANCTL|COMCTL|ETHCTL|IPCTL|ENCCTL|ENCD|NMT|SDORD|SDOWR"
        r"|PMA|PML|SNAME|STDOUT|IDENT|TS|ERRC|MODE|UID)\b.*)",
        "",
    ),
)
"""Class 5 commands, in the order in which the patterns are tried."""
VALUES = (
    Later(r".*:\w+", f'{EXAMPLE}PRINT(#129,"RP ")', f"{REMOTE}; GETCHR reads the answer"),
    Later(r"PA", "@P", sure=True),
    Later(r"PC(?:\(\d\))?", "@P", "the measured position"),
    Later(r"EA", "@PE", sure=True),
    Later(r"V[AC]", "@V", RATES),
    Later(r"PT", "P", sure=True),
    Later(r"PRT", "D", sure=True),
    Later(r"VT", "V", RATES),
    Later(r"(?:ADT|AT|DT|AC)", "A", RAMPS),
    Later(r"EL", "E", sure=True),
    Later(r"TRQ", "T"),
    Later(r"CTR\(1\)", "CTR", sure=True),
    Later(r"CTR\(0\)", "@P"),
    Later(r"INA\([AV]1?,(?P<pin>[0-6])\)", "U{pin}A", "the units differ"),
    Later(r"INA(?:\(.*\))?", f"{EXAMPLE}UAA", "the units differ"),
    Later(rf"IN{_PIN}", "U{pin}", sure=True),
    Later(r"IN(?:\(.*\))?", f"{EXAMPLE}UA"),
    Later(r"B\(0,(?P<flag>\d+)\)", "{flag}"),
    Later(r"[BW]\(.*\)", f"{EXAMPLE}Bt", LETTERS),
    Later(r"(?:RAND(?:OM)?|TMR\(.*\))", "CLK", "the sample counter"),
    Later(rf"ABS{_ARGUMENT}", r"(\g<v>)*(((\g<v>)>0)-((\g<v>)<0))", sure=True),
    Later(r"(?:SQRT|SIN|COS|TAN|ASIN|ACOS|ATAN|PI|F?ABS|FSQRT)(?:\(.*\))?", f"{EXAMPLE}al[0]", TABLE),
    Later(r"af", f"{EXAMPLE}al[0]", "whole numbers only"),
    Later(r"CADDR", "ADDR"),
)


def message(found: Found) -> str:
    """Return an error message about a command or variable of Class 5 (later SmartMotors)."""
    note = f" ({found.note})" if found.note else ""
    here = f"4.76 uses {found.here}" if found.here else "4.76 has nothing like it, so remove it"
    return f"{found.word} is a word of Class 5, which sets Bs here: {here}{note}"


def find(text: str, table: tuple[Later, ...]) -> Found | None:
    """Return the Class 5 word in `text`, e.g. `PT=100`, with its 4.76 equivalent; None if none matches."""
    for later in table:
        if (match := re.fullmatch(later.form, text, re.ASCII)) and (found := _made(later, match)):
            return found
    return None


def _made(later: Later, match: re.Match[str]) -> Found | None:
    """Return the equivalent of a matched word, or None for a flag that 4.76 does not have."""
    given = match.groupdict()
    if "remote" in given:
        return _remote(given["remote"] + (given["assigned"] or ""), int(given["address"]), match.string)
    flag, pin = FLAGS.get(int(given.get("flag", 2)), ""), PINS[int(given.get("pin", 0))]
    if not flag:
        return None
    here = match.expand(later.here.replace("{pin}", pin).replace("{flag}", flag).replace(r"\g<v>", "\0"))
    here = here.replace("\0", _word.sub(lambda word: _value(word[0]), given.get("v", "")))
    word = match.string[: match.start("v")] if later.form.endswith(_VALUE) else match.string
    return Found(clipped(word), here, later.note.replace("{pin}", pin), later.sure)


def _value(word: str) -> str:
    found = find(word, VALUES)
    return word if found is None or found.here.startswith(EXAMPLE) else found.here


def _remote(command: str, address: int, word: str) -> Found:
    known = find(command, COMMANDS)
    here = command if known is None or known.here.startswith(EXAMPLE) else known.here
    return Found(clipped(word), f'PRINT(#{0x80 + address},"{here} ")', REMOTE, sure=False)
