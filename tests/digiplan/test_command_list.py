"""Appendix 1, Full command list: compared with an independent list, and tested with every possible character."""

from pathlib import Path

import pytest

from axistwin import Bench
from axistwin.bench import product

from .talking import ask, initialise, ready

LIST = Path(__file__).parents[1] / "manual" / "if1.txt"
CONTROL = {"<LF>": "\n", "<CR>": "\r", "<SP>": " "}


def listed() -> list[tuple[str, int]]:
    rows = (line.split(maxsplit=2) for line in LIST.read_text().splitlines())
    return [(CONTROL.get(row[0], row[0]), int(row[1])) for row in rows if row[1].isdecimal()]


@pytest.mark.parametrize("model", ["if1", "if2"])
def test_the_table_has_the_manuals_commands_in_the_manuals_order(model):
    assert [(command.code, ord(str(command.code))) for command in product(model).commands] == listed()


def test_every_command_is_implemented_and_names_its_chapter():
    assert all(command.implemented and command.chapter for command in product("if1").commands)


ALLOWED = {
    "\n\r $+,-:": ["WRITTEN"], "(*UV": ["SETUP"], "<>D^": ["DIRECT"], "=A": ["STEP"],
    "%/@BGHLPRSXYZ": ["DIRECT", "STEP"], "#[": ["DIRECT", "ALONE"], "]": ["DIRECT", "ALONE", "LOCKED"],
    "EFIKNOQ": ["DIRECT", "ALONE", "LOCKED", "REQUEST"],
}  # fmt: skip
"""Kinds of messages in which the manual's chapters allow each command, or in which it is only part of another one."""


def test_where_each_command_is_allowed():
    assert {command.code: command.as_dict()["accepted"] for command in product("if1").commands} == {
        code: kinds for codes, kinds in ALLOWED.items() for code in codes
    }


@pytest.mark.parametrize("syntax", [
    "@ speed", "= times,first step", "X[+|-][distance]", "P output[,length]", "axis G", "K", "U frame parity"
])  # fmt: skip
def test_the_syntax_of_commands(syntax):
    """The manual's examples: "@ 1500", "=5,2", "X-3000", "P4, 20", "X @ 5000 G", "K <CR>", "U 6 1"."""
    assert syntax in {command.syntax for command in product("if1").commands}


@pytest.mark.parametrize(("model", "more"), [("if1", ""), ("if2", " with battery backup")])
def test_the_title_of_a_model(model, more):
    """Title page: "IF1 & IF2 stepper motor interfaces"."""
    assert product(model).title == f"Digiplan {model.upper()} stepper motor interface{more}"


UNDEFINED = sorted({*range(0x80)} - {code for _, code in listed()})


@pytest.mark.parametrize("message", ["{}", "X10{}$", ":X10{}:$"], ids=["alone", "in a message", "in a sequence"])
def test_a_character_that_is_no_command_is_a_data_fault(message):
    """Such a character is a data fault; bit 8 is ignored, so 81h is the same as 01h."""
    bench = Bench()
    if1 = ready(bench)
    for code in (*UNDEFINED, *(code + 0x80 for code in UNDEFINED)):
        text = message.format(chr(code))
        if code & 0x7F in map(ord, "0123456789") and message != "{}":
            continue  # after a number, a digit belongs to the distance
        assert ask(bench, if1, text) == b"", f"{code:02X}h"
        assert ask(bench, if1, "F") == b"8\r", f"{code:02X}h"
    assert all(axis.position == 0 for axis in if1.axes.values())


@pytest.mark.parametrize("message", ["{}", "X10{}$", "X10{}", "X10${}", ":X10{}:$"])
@pytest.mark.parametrize("code", [code for _, code in listed()], ids=lambda code: f"{code:02X}h")
def test_a_command_in_any_place_is_survived(message, code):
    """Whatever code a message contains, the interface answers again after `#` (and `]`)."""
    bench = Bench()
    if1 = ready(bench)
    ask(bench, if1, message.format(chr(code)), seconds=1.5)
    ask(bench, if1, message.format(chr(code + 0x80)), seconds=1.5)
    ask(bench, if1, "]", seconds=1.5)
    ask(bench, if1, "#", seconds=1.5)
    ask(bench, if1, "F")
    ask(bench, if1, "K")
    assert ask(bench, if1, "E") == b"C\r"


@pytest.mark.parametrize("code", range(0x100), ids=lambda code: f"{code:02X}h")
def test_no_character_before_the_initialisation_gets_in_its_way(code):
    bench = Bench()
    if1 = bench.add("if1")
    bench.run(1.2)
    if1.serial.write(bytes([code]))
    bench.run(0.1)
    if1.serial.read()
    initialise(bench, if1)
    assert ask(bench, if1, "E") == b"C\r"
