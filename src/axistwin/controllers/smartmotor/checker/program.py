"""Diagnostics of a program or a conversation for firmware 4.76, without running it.

The motor's own parser and compiler find the statements that set Bs.  Further rules concern values out of range, program
flow (`flow`), mode cam (`cam`), and changes since older firmware (`migration`).
"""

from collections.abc import Iterator, Sequence

from axistwin.controllers.diagnostics import Diagnostic, Rule, Sent, Session, diagnose
from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.chapters.variables import ARRAY_SIZES
from axistwin.controllers.smartmotor.checker import cam, fixes, flow, migration
from axistwin.controllers.smartmotor.checker.findings import Findings, constant_value, located
from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.language import image
from axistwin.controllers.smartmotor.language.expressions import CHAPTER, Problem
from axistwin.controllers.smartmotor.language.forms import Form
from axistwin.controllers.smartmotor.language.language import Statement, command
from axistwin.controllers.smartmotor.language.vocabulary import Words
from axistwin.controllers.smartmotor.options import Options
from axistwin.controllers.smartmotor.serial.channel import RECORDS

WITH_ARGUMENT = flow.WITH_ARGUMENT
BINARY, END = 0x80, 0xFF  # From 80h, addresses and records of a host; FFh, the end of a program.
ENDING = b"\r\n\0"  # Characters that end any command; a space ends most.


def check(sessions: Sequence[Session]) -> list[Diagnostic]:
    """Return the diagnostics of stored programs and of host commands, sorted by their place in the text."""
    found: list[Diagnostic] = []
    for session in sessions:
        if session.stored:
            found += _program(session.characters)
        else:
            host = _Host(session.characters)
            host.follow()
            found += host.found
    return sorted(set(found))


def _program(characters: Sequence[Sent]) -> list[Diagnostic]:
    findings = Findings(characters)
    for number, statement in enumerate(findings.statements):
        for problem in _problems(statement):
            findings.problem(number, problem, fixes.in_program(findings, number, problem))
    _length(findings)
    if findings.statements:
        flow.check(findings)
        cam.check(findings)
        migration.check(findings)
    return findings.found


def _length(findings: Findings) -> None:
    size, room = len(image.strip(findings.program.text)), Options().program_bytes
    if size > room:
        number = len(findings.statements) - 1
        findings.report(rules.TOO_LONG, number, f"this program has {size} bytes: the motor stores {room}")


def _problems(statement: Statement) -> Iterator[Problem]:
    if statement.problem is not None:
        yield statement.problem
        return
    yield from _range(statement)
    for part in statement.computed:
        for index in part.indices:
            size = ARRAY_SIZES[index.array][1]
            if not 0 <= index.value < size:
                message = f"there is no {index.array}[{index.value}]: {index.array}[0] to {index.array}[{size - 1}]"
                yield Problem(index.position, message, rules.ARRAYS, rules.INDEX)
        yield from _arithmetic(part.code)


def _range(statement: Statement) -> Iterator[Problem]:
    value, found = constant_value(statement), statement.command
    if found is None or found.form is not Form.LET or value is None or found.parameters[0].allows(value):
        return
    yield Problem(
        len(str(found.code)), f"{value} is out of range: expected {found.parameters[0]}", found.chapter, rules.RANGE
    )


def _arithmetic(code: Sequence[int]) -> Iterator[Problem]:
    """Yield a problem for each number that does not fit 32 bits, and for each division by a constant zero."""
    at, before = 0, (ops.RESULT, 0)
    while at < len(code):
        operation = code[at]
        if operation == ops.OVERFLOW:
            yield Problem(
                0,
                f"a number does not fit 32 bits ({ops.LOWEST} to {ops.HIGHEST}): "
                "Bd is set and the statement has no effect",
                CHAPTER,
                rules.OVERFLOW,
            )
        elif operation in (ops.DIVIDE, ops.REMAINDER) and before == (ops.CONSTANT, 0):
            yield Problem(0, "this divides by 0: Bd is set and the statement has no effect", CHAPTER, rules.ZERO)
        argument = operation in WITH_ARGUMENT
        before = (operation, code[at + 1] if argument else 0)
        at += 1 + argument


class _Host:
    """Checks the commands that a host sends, and the program that a host sends between LOAD and the bytes FF FF."""

    def __init__(self, characters: Sequence[Sent]) -> None:
        self.found: list[Diagnostic] = []
        self._characters = characters
        self._at = self._begin = 0
        self._words = Words(self._command, self._overflow)
        self._loading = False

    def follow(self) -> None:
        while self._at < len(self._characters):
            sent = self._characters[self._at]
            self._at += 1
            self._at += RECORDS.get(sent.byte, 1) - 1
            if sent.byte < BINARY:
                self._words.take(sent.byte)
            else:
                self._words.forget()
            if sent.byte >= BINARY or sent.byte in ENDING:
                self._begin = self._at
            if self._loading:
                self._load()
        if bytes(sent.byte for sent in self._characters[self._begin :] if sent.byte < BINARY).strip(b" \r\n\0"):
            self._report(rules.UNENDED, self._begin, "this command has no end: a space or <CR> is missing")

    def _command(self, text: str) -> None:
        sent = bytes(sent.byte for sent in self._characters[self._begin : self._at])
        begin = self._begin + max(sent.find(text.encode("ascii", "replace")), len(sent) - len(sent.lstrip(b" \r\n\0")))
        for problem in _problems(command(text)):
            end = min(begin + len(text), self._at - 1)
            fix = fixes.of(self._characters[begin:end], text, problem)
            self.found.append(located(self._characters, begin, end, problem, fix))
        self._begin = self._at
        self._loading = text == "LOAD"

    def _overflow(self) -> None:
        self._report(rules.LONG_COMMAND, self._begin, "this command is longer than 64 characters: Bc is set")

    def _load(self) -> None:
        self._loading = False
        end = next((at for at in range(self._at, len(self._characters)) if self._characters[at].byte == END), None)
        source = self._characters[self._at : end]
        if end is None:
            self._report(rules.DOWNLOAD, self._at - 1, "this download has no end: FFh FFh is missing")
        if source and source[0].byte != ord("$"):
            self.found += _program(source)
        self._at = self._begin = len(self._characters) if end is None else end + 1

    def _report(self, rule: Rule, offset: int, message: str) -> None:
        self.found.append(diagnose(rule, self._characters[offset : max(self._at, offset + 1)], message))
