"""The command table against an independent list; unknown words."""

import re
import string
from itertools import product as combinations
from pathlib import Path

from axistwin.controllers.smartmotor.commands import COMMANDS
from axistwin.controllers.smartmotor.language.forms import Accept, Form
from axistwin.controllers.smartmotor.language.language import command, read

LIST = Path(__file__).parents[1] / "manual" / "smartmotor.txt"


def listed() -> dict[str, str]:
    """Return the syntax of each command and its section."""
    columns = re.compile(r"(\S+(?: exp)?)\s+(\S+)\s")
    rows = (columns.match(line) for line in LIST.read_text().splitlines() if line and not line.startswith("#"))
    return {row[1]: row[2] for row in rows}


def test_the_table_has_the_commands_of_the_manuals():
    assert {entry.syntax for entry in COMMANDS} == set(listed())


def test_what_has_been_removed_is_not_accepted_and_says_what_replaces_it():
    """1.3: a removed command is refused, and the message names its replacement."""
    removed = {entry.syntax for entry in COMMANDS if Accept.REMOVED in entry.accepted}
    assert removed == {syntax for syntax, section in listed().items() if section == "removed"}
    assert all(entry.instead for entry in COMMANDS if Accept.REMOVED in entry.accepted)


def test_everything_else_is_implemented_and_names_its_chapter():
    assert all(entry.chapter for entry in COMMANDS)
    assert [entry.code for entry in COMMANDS if not entry.implemented and Accept.REMOVED not in entry.accepted] == []


EXAMPLES = {
    Form.NUMBER: lambda code: code[:-1] + str({"PIDn": 2, "BAUDn": 9600}.get(code, 1)),
    Form.LET: lambda code: code + "1", Form.AFTER: lambda code: code + " 1",
    Form.ITEMS: lambda code: code[:-1] + '"a",1,#13)', Form.CALL: lambda code: code[:-1] + "a,1)",
    Form.VARIABLE: lambda _: "a=1", Form.ARRAY: lambda code: code[:2] + "[1]=1",
    Form.REPORT_VARIABLE: lambda code: {"RAINpc": "RAINA1", "RDINpc": "RDINA1"}.get(code, "Ra"),
    Form.REPORT_ARRAY: lambda code: code[:3] + "[1]",
    Form.OUTPUT: lambda code: code[:-1] + ("A1,1" if code == "DOUTp" else "A,1"), Form.BARE: lambda code: code,
}  # fmt: skip


def test_a_command_is_read_as_itself():
    texts = {entry: EXAMPLES[entry.form](str(entry.code)) for entry in COMMANDS}
    assert [text for entry, text in texts.items() if read(text).command is not entry] == []
    removed = {text for entry, text in texts.items() if Accept.REMOVED in entry.accepted}
    assert {text for text in texts.values() if read(text).problem} == removed
    for_hosts = {text for entry, text in texts.items() if Accept.HOST in entry.accepted}
    assert {text for text in texts.values() if not command(text).problem} == for_hosts


def test_every_other_word_of_up_to_two_characters_is_unknown():
    """An unknown command is ignored and sets Bs (3 of the base language)."""
    bare = {str(entry.code) for entry in COMMANDS if entry.form is Form.BARE} | {"S", "C0"}
    variables = {f"R{letter}" for letter in string.ascii_lowercase}
    labels = {f"C{digit}" for digit in string.digits}
    words = {first + second for first, second in combinations(string.printable, ["", *string.printable])}
    known = {word for word in words if read(word).problem is None}
    assert known == {word for word in bare | variables | labels if len(word) <= 2}
