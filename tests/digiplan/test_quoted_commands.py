"""Every instruction that the manual quotes, from the RS232 chapters to the battery backup, is sent as it is printed.

The tests take the quotations from the manual's text.  `REPAIRS` corrects errors of scanning or typing; `WORDS` and
`REPLIES` list quotations that are no instructions.
"""

import re
from functools import cache
from pathlib import Path

import pytest

from axistwin.bench import Say, product
from axistwin.bench.talk.conversation import load
from axistwin.cli.authoring.check import diagnose
from axistwin.controllers.diagnostics import Severity
from axistwin.controllers.digiplan.chapters.data_format import read_format
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import parse

MANUAL = Path(__file__).parents[3] / "shared" / "seeds" / "002_6b8f45044460a1a6.txt"
CONVERSATIONS = Path(__file__).parents[1] / "conversations"
BEGIN, END = "SERIAL COMMUNICATION VIA RS232C\n\nThe IF1", "APPENDIX 1. FULL COMMAND LIST.\n\nAll"

REPAIRS = (  # as printed, as meant, reason
    (r"\$", "$", "the scan writes a $ in running text with a backslash"),
    ('"]" <CR>"', '"] <CR>"', "a quotation mark too many"),
    ('the "v" format', 'the "V" format', "all letters are upper case"),
    ('command "0" (letter', 'command "O" (letter', "letter O, as the text says itself"),
    ('Sending "0 <CR>"', 'Sending "O <CR>"', "letter O"),
    ('":% <CR>"', '":$ <CR>"', "$ printed as %: with % the host gives control back (R14)"),
    ("YZ 500 % 1000", "YZ 500 @ 1000", "@ printed as %: the speeds of the text fit (R23)"),
    ("Z 50 % 800", "Z 50 @ 800", "@ printed as % (R23)"),
    ('"H1 X1000:L1X / Y200 % 6000', '": H1 X1000:L1X / Y200 @ 6000', "@ as %, and the first colon is lost (R23, R24)"),
    ('"**"', '"*"', "the command list has one * (R28)"),
)

WORDS = {
    *("<CR>", "Clearing Fault Conditions", "Ext. 0v", "Ext.0v", "Installation", "K128", "X-off", "a", "asynchronous"),
    *("asynchronous serial", "b", "buffer full", "communication fault", "frame", "in motion", "motionless"),
    *("no current", "range error", "reset", "rollover", "set", "signal present"),
}
REPLIES = {"U <CR>", "U<CR>", "41<CR>", "8 <CR>", " 527 <CR>", "32 <CR>", "0 <CR>", "128 <CR>", "C <CR>"}
FORMATS = {"U X1 X2 <CR>": ("U61", "\r"), "V X1 X2 <CR> <LF>": ("V61", "\n")}
"""The form of the data format message, and an example of it with what ends it."""

WHOLE = {
    ": H2 = 10, 4 :": ":S1:S2:S3:S4{}$",
    ": H1": "{}:X1000:$",
    ":H1:": "{}X1000:$",
    ": H3 A = 2, 1 :": ":XG{}$",
    " : X 1000 P0, 50:": "{}$",
    "% <CR>": ":%:$\n{}",  # the host gives control back to a sequence that has asked for it
}
"""Parts of sequences, and something whole with them in it."""


def quoted() -> list[str]:
    """Return each text in double quotes once, in the order of the manual; without the manual, none."""
    if not MANUAL.exists():
        return []
    text = MANUAL.read_text("utf-8")
    text = text[text.index(BEGIN) : text.index(END)]
    for printed, meant, _ in REPAIRS:
        assert printed in text, f"{printed} is not in the manual"
        text = text.replace(printed, meant)
    return list(dict.fromkeys(found for line in text.splitlines() for found in re.findall(r'"([^"]*)"', line)))


def is_character(quotation: str) -> bool:
    return len(quotation) == 1 and quotation not in WORDS


QUOTED = quoted()
CHARACTERS = [quotation for quotation in QUOTED if is_character(quotation)]
INSTRUCTIONS = [
    quotation
    for quotation in QUOTED
    if not is_character(quotation) and quotation not in WORDS | REPLIES | FORMATS.keys()
]


def unended(quotation: str) -> str:
    """Return the quotation without its terminator."""
    return quotation.replace("<CR>", "").replace("<LF>", "")


def whole(quotation: str) -> list[str]:
    """Return the messages that a quotation needs to be meaningful."""
    return WHOLE.get(quotation, "{}").format(unended(quotation)).split("\n")


def squeezed(text: str) -> str:
    return re.sub(r"\s", "", text)


@cache
def golden() -> str:
    """Return all messages to an IF1 or IF2 in the golden conversations, without blanks and terminators."""
    files = [file for file in sorted(CONVERSATIONS.glob("*.talk")) if not file.name.startswith("smartmotor")]
    acts = [act for file in files for act in load(file).acts]
    return squeezed("\n".join(act.data.decode() for act in acts if isinstance(act, Say)))


@pytest.mark.skipif(not QUOTED, reason="the manual is not here")
def test_as_much_is_quoted_as_somebody_has_counted():
    assert (len(CHARACTERS), len(INSTRUCTIONS)) == (31, 56)
    assert set(QUOTED) >= WORDS | REPLIES | FORMATS.keys() | WHOLE.keys()


@pytest.mark.parametrize("quotation", CHARACTERS)
def test_a_quoted_character_is_a_command(quotation):
    assert COMMANDS.get(quotation) is not None


@pytest.mark.parametrize("quotation", [quotation for quotation in FORMATS if quotation in QUOTED])
def test_a_quoted_data_format_is_one(quotation):
    text, end = FORMATS[quotation]
    frame = read_format(text, ord(end))
    assert frame is not None and quotation.startswith(frame.terminator)


@pytest.mark.parametrize("quotation", INSTRUCTIONS)
def test_a_quoted_instruction_is_understood(quotation):
    for message in whole(quotation):
        assert parse(message, COMMANDS).problems == []


@pytest.mark.parametrize("quotation", INSTRUCTIONS)
def test_a_quoted_instruction_passes_the_check(quotation, tmp_path):
    program = tmp_path / "quoted.if1"
    program.write_text("\n".join(whole(quotation)))
    found = diagnose(program, product("if1").check)
    assert [diagnostic for diagnostic in found if diagnostic.severity is Severity.ERROR] == []


@pytest.mark.parametrize("quotation", INSTRUCTIONS)
def test_a_quoted_instruction_is_in_a_golden_conversation(quotation):
    assert squeezed(unended(quotation)) in golden()
