"""The eleven BASIC programs of the manual's appendix 3, read from the manual and changed to run on PC-BASIC.

The listings are read from the manual's text when a test needs them.  Two tables contain all changes, line by line:
`REPAIRS` corrects errors of scanning or typing, and `ADAPTATIONS` translates statements for other machines into
PC-BASIC.  Everything else runs as it is printed.
"""

import re
from pathlib import Path
from typing import NamedTuple

MANUAL = Path(__file__).parents[3] / "shared" / "seeds" / "002_6b8f45044460a1a6.txt"

Listing = dict[int, str]
"""Line numbers and what stands after them."""


class Change(NamedTuple):
    """In this line of this program, replace each `found` by `wanted`."""

    program: int
    line: int
    found: str
    wanted: str
    reason: str


DOLLAR = "a string's $ is printed as %"
EIGHT = "8 data bits, as the remark above says, are printed as B"
BLANK = "the space bar that the prompt asks for is lost between the quotes"
REMARK = "the ' that begins the remark is lost"
SEMICOLON = "ERR is an item of the PRINT: its ; is printed as :"

REPAIRS = (
    Change(1, 90, "8NB2", "8N82", EIGHT),
    Change(1, 100, "8NB2", "8N82", EIGHT),
    *(Change(1, line, "%", "$", DOLLAR) for line in (180, 190, 200, 210, 390, 430, 470, 490, 495, 500, 520)),
    Change(1, 620, '""', '" "', BLANK),
    Change(2, 150, ' "I"', ',"("', "the autobaud character ( is printed as I, and the comma before it is lost"),
    *(Change(2, line, ": ", ": ' ", REMARK) for line in (350, 370, 380, 390, 400)),
    Change(2, 5000, '" :', '" ;', SEMICOLON),
    Change(2, 5020, '" :', '" ;', SEMICOLON),
    *(Change(3, line, "%", "$", DOLLAR) for line in (180, 190, 200, 210, 335, 340)),
    Change(5, 620, '""', '" "', BLANK),
    Change(6, 450, ":+0,1", ":=0,1", "the repeat's = is printed as + (samples 3 and 9 have =)"),
    Change(9, 90, "N,B,2", "N,8,2", EIGHT),
    Change(10, 90, "OUTPUTAS", "OUTPUT AS", "the blank between two words is lost"),
    Change(10, 300, "U62", "V62", "V format is meant: the remark above says so, and the replies it reads end in CR LF"),
    Change(11, 130, "4000", "5000", "there is no line 4000 (sample 7, from which this one is made, has it)"),
)

ONE_FILE = "PC-BASIC opens COM1 once, for both directions: this second OPEN is left out"
NEC = "the NEC's OPEN in PC-BASIC's words, no line watched: 8, 6 and 5 are 9600, 2400 and 1200 baud"
EPSON = "the Epson's OPEN in PC-BASIC's words, no line watched (F): 5 and 6 are 2400 and 4800 baud"
EPSON_CTS = "the Epson's OPEN in PC-BASIC's words, CTS watched (3), as sample 9 does: 5 is 2400 baud"
TANDY = "the Tandy's OPEN in PC-BASIC's words, no line watched: 8 and 6 are 9600 and 2400 baud"
APART = "PC-BASIC takes words printed together for a variable's name: a blank between them"
LOOP = "a wait for the ramp calculation: PC-BASIC counts slowly, and virtual time is fast"

ADAPTATIONS = (
    Change(1, 90, '"COM:8N82NN" FOR OUTPUT AS #1', '"COM1:9600,N,8,2,RS,CS,DS,CD" AS #1', NEC),
    Change(1, 100, 'OPEN"COM:8N82NN" FOR INPUT AS #2', "'", ONE_FILE),
    Change(1, 200, "PRINTB", "PRINT B", APART),
    Change(1, 620, "IFA", "IF A", APART),
    Change(2, 90, '"COM:6N82NN" FOR OUTPUT AS #1', '"COM1:2400,N,8,2,RS,CS,DS,CD" AS #1', NEC),
    Change(2, 100, 'OPEN"COM:6N82NN" FOR INPUT AS #2', "'", ONE_FILE),
    Change(3, 90, '"COM:5N82NN" FOR OUTPUT AS #1', '"COM1:1200,N,8,2,RS,CS,DS,CD" AS #1', NEC),
    Change(3, 100, 'OPEN"COM:5N82NN" FOR INPUT AS #2', "'", ONE_FILE),
    Change(3, 200, "PRINTB", "PRINT B", APART),
    Change(4, 80, '"O",#1,"COM0:(58N2F)"', '"COM1:2400,N,8,2,RS,CS,DS,CD" AS #1', EPSON),
    Change(4, 90, 'OPEN"I",#2,"COM0:(58N2F)"', "'", ONE_FILE),
    Change(5, 100, '"O",#1,"COM0:(68N2F)"', '"COM1:4800,N,8,2,RS,CS,DS,CD" AS #1', EPSON),
    Change(5, 110, 'OPEN"I",#2,"COM0:(68N2F)"', "'", ONE_FILE),
    Change(6, 70, '"O",#1,"COM0:(58N23)"', '"COM1:2400,N,8,2,CS350,DS,CD" AS #1', EPSON_CTS),
    Change(6, 80, 'OPEN"I",#2,"COM0:(58N23)"', "'", ONE_FILE),
    Change(6, 200, "PRINTA", "PRINT A", APART),
    Change(6, 210, "IFA", "IF A", APART),
    Change(7, 270, "10000", "1000", LOOP),
    Change(10, 90, '"COM:88N2D" FOR OUTPUT AS #1', '"COM1:9600,N,8,2,RS,CS,DS,CD" AS #1', TANDY),
    Change(10, 100, 'OPEN"COM:88N2D" FOR INPUT AS #2', "'", ONE_FILE),
    Change(10, 5015, "GOTO90", "GOTO 90", APART),
    Change(11, 80, "COM ON", "COM(1) ON", "PC-BASIC wants to know which port"),
    Change(11, 90, '"COM:68N2D" FOR OUTPUT AS #1', '"COM1:2400,N,8,2,RS,CS,DS,CD" AS #1', TANDY),
    Change(11, 100, 'OPEN"COM:68N2D" FOR INPUT AS #2', "'", ONE_FILE),
    Change(11, 270, "10000", "1000", LOOP),
    Change(11, 386, "GOSUB1000", "GOSUB 1000", APART),
    Change(11, 388, "GOSUB1000", "GOSUB 1000", APART),
)

SENDS_LF = (1, 2, 3, 4, 5, 6, 10, 11)
"""The NEC, the Epson and the Tandy end a printed line with CR LF, PC-BASIC and the IBM PC with CR."""
END_OF_PRINT = re.compile(r"""(PRINT ?\#1,(?:"[^"]*"|[A-Z]\$))(?=\s*(?::|$))""")
"""A PRINT# that ends its line: no semicolon follows."""


def printed(program: int) -> Listing:
    """Return a program as the manual prints it.  The second one with the heading "6" is the eighth."""
    chapters = re.split(r"^SAMPLE PROGRAM \d+ FOR .*$", MANUAL.read_text("utf-8"), flags=re.MULTILINE)
    fenced = "".join(re.findall(r"^```\n(.*?)^```$", chapters[program], re.DOTALL | re.MULTILINE))
    numbered = re.findall(r"^(\d+) (.*(?:\n(?!\d).*)*)", fenced, re.MULTILINE)
    return {int(number): " ".join(text.split("\n")).rstrip() for number, text in numbered}


def runnable(program: int) -> Listing:
    listing = printed(program)
    for change in (*REPAIRS, *ADAPTATIONS):
        if change.program == program:
            assert change.found in listing[change.line], f"sample {program}, line {change.line} is not as expected"
            listing[change.line] = listing[change.line].replace(change.found, change.wanted)
    if program in SENDS_LF:
        listing = {line: END_OF_PRINT.sub(r"\1;CHR$(13);CHR$(10);", text) for line, text in listing.items()}
    return {line: text.replace("#2", "#1") for line, text in listing.items()}


def source(listing: Listing) -> str:
    return "".join(f"{line} {text}\r\n" for line, text in listing.items())
