"""The command language (3 of the base language): the text of one command or statement becomes a `Statement`.

Host commands, programs and the checker use the same parser.  Invalid text becomes a statement that sets Bs
when executed.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

from axistwin.controllers.diagnostics import Rule
from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.chapters.eeprom import Run
from axistwin.controllers.smartmotor.chapters.reports import READ_ONLY
from axistwin.controllers.smartmotor.chapters.variables import ARRAY_SIZES, NAMES, NO_VALUE, find, values
from axistwin.controllers.smartmotor.commands import COMMANDS
from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.kernel.interpreter import HIGHEST
from axistwin.controllers.smartmotor.language import class5
from axistwin.controllers.smartmotor.language.expressions import Computed, Expression, Index, Malformed, Problem, Reader
from axistwin.controllers.smartmotor.language.forms import Accept, Form, Instruction
from axistwin.controllers.smartmotor.language.vocabulary import GLOBAL, LAST_ADDRESS
from axistwin.controllers.smartmotor.processor import Processor

LEXICAL = "Lexical rules"
EQUAL_SIGN, FEATURES_ADDED = "8.1 Forced equal sign", "1.1 Features added"


@dataclass(frozen=True)
class Elements(Computed):
    """An assignment to an array as code of the interpreter: number of values, array, first index, values."""

    count: int = 1

    def value(self, motor: Processor) -> tuple[int, ...]:
        """Return the code, after fetching the external values."""
        self.fetch(motor)
        return self.code


@dataclass(frozen=True)
class First:
    """The variable or element with which a VST or VLD begins."""

    name: str

    def __call__(self, motor: Processor) -> Run | None:
        """Return the range of variables or elements that begins with this one; None if it does not exist."""
        if "[" not in self.name:
            group = values(self.name)
            return None if group is None else Run(ops.VARIABLE, group.start, len(group))
        kind, length = ARRAY_SIZES.get(self.name[:2], (0, 0))
        reader = Reader(self.name, 2)
        try:
            index = reader.index()
        except Malformed:
            return None
        first = index.value(motor) if reader.at == len(self.name) else None
        return None if first is None or not 0 <= first < length else Run(kind, first, length - first)


WITHOUT_VALUE = Expression((ops.NO_VALUE, ops.RESULT))
"""Operand in place of an invalid expression of IF, WHILE or SWITCH: the condition is false, and Bs is set."""

Operand = int | str | bytes | Expression | Elements | First
"""Type of a handler's argument: number, text, byte (`#n` of a PRINT), or the value of an expression."""


@dataclass(frozen=True)
class Statement:
    """A parsed text, which is either a command with operands or an error."""

    text: str
    command: Instruction | None = None
    operands: tuple[Operand, ...] = ()
    problem: Problem | None = None

    @property
    def computed(self) -> tuple[Computed, ...]:
        """Computed operands of a SmartMotor statement, e.g. `a+1` in `b=a+1`."""
        return tuple(part for part in self.operands if isinstance(part, Computed))

    def fetch(self, motor: Processor) -> None:
        """Fetch the external values of an assignment or a condition; the interpreter then executes the statement."""
        for part in self.computed:
            part.fetch(motor)

    @cached_property
    def read_only(self) -> bool:
        handler = self.command.handler if self.command is not None else None
        asked = {name for part in self.computed for name in part.names}
        if isinstance(handler, partial):
            asked.add(handler.keywords.get("name", ""))
            handler = handler.func
        fetched = any(part.fetches for part in self.computed)
        return self.problem is None and handler in READ_ONLY and "I" not in asked and not fetched

    def perform(self, motor: Processor) -> str | None:
        """Execute the statement, and return a report without its CR, or None; an invalid statement only sets Bs."""
        if self.problem is not None or self.command is None or self.command.handler is None:
            motor.syntax_error()
            return None
        given: list[object] = []
        for part in self.operands:
            value = part.value(motor) if isinstance(part, Expression | Elements) else part
            if value is None:
                motor.refuse(NO_VALUE)
                return None
            given.append(value)
        named = self.command.form is Form.LET
        answer = self.command.handler(motor, value=given[0]) if named else self.command.handler(motor, *given)
        return answer if isinstance(answer, str) else None


@lru_cache(maxsize=4096)
def command(text: str) -> Statement:
    """Parse a command of a host, given without its terminator."""
    statement = read(text)
    found = statement.command
    if statement.problem is None and found is not None and Accept.HOST not in found.accepted:
        problem = Problem(0, f"{found.code} is valid only in a program", LEXICAL, rules.PROGRAM_ONLY)
        return Statement(text, found, (), problem)
    return statement


@lru_cache(maxsize=4096)
def read(text: str) -> Statement:
    found: Instruction | None = None
    try:
        found, begin = _find(text)
        if found is None:
            rule, message = _unknown(text)
            raise Malformed(message=message, position=0, chapter=rule.chapter, rule=rule)
        if Accept.REMOVED in found.accepted:
            removed_command, replacement = found.code, found.instead
            raise Malformed(
                f"{removed_command} has been removed in firmware 4.76: {replacement}", 0, found.chapter, rules.REMOVED
            )
        return Statement(text, found, _READERS[found.form](text, begin, found))
    except Malformed as malformed:
        condition = found is not None and found.form is Form.AFTER
        return Statement(text, found, (WITHOUT_VALUE,) if condition else (), malformed.problem)


_HEADS: tuple[tuple[re.Pattern[str], str], ...] = (
    (re.compile(r"([A-Z]+)(?:[ \t]+|\Z)", re.ASCII), "{}"),
    (re.compile(r"([A-Z]+)=", re.ASCII), "{}="),
    (re.compile(r"([A-Z]+1?)\(", re.ASCII), "{}()"),
    (re.compile(r"([A-Z]+)(?=\d+\Z)", re.ASCII), "{}n"),
    (re.compile(r"(ab|aw|al)(?=\[)"), "{}[]="),
    (re.compile(r"R(ab|aw|al)(?=\[)"), "R{}[]"),
    (re.compile(r"R([AD]IN)(?=[A-H]\d)", re.ASCII), "R{}pc"),
    (re.compile(r"([AD]OUT)(?=[A-H])"), "{}p"),
)
LETTERS = "a…zzz="
REPORT_LETTERS = "Ra…Rzzz"


def _get(code: str) -> Instruction | None:
    found = COMMANDS.get(code)
    return found if isinstance(found, Instruction) else None


def _find(text: str) -> tuple[Instruction | None, int]:
    whole = _get(text)
    if whole is not None and whole.form is Form.BARE:
        return whole, len(text)
    for pattern, code in _HEADS:
        match = pattern.match(text)
        found = _get(code.format(match[1])) if match else None
        if match and found is not None and (found.form is Form.AFTER) == (code == "{}"):
            return found, match.end()
    name, equals, _ = text.partition("=")
    if equals and values(name) is not None:
        return _get(LETTERS), len(name) + 1
    if text.startswith("R") and values(text[1:]) is not None:
        return _get(REPORT_LETTERS), 1
    return next((removed for removed in REMOVED if text.startswith(str(removed.code))), None), 0


REMOVED = tuple(entry for entry in COMMANDS if isinstance(entry, Instruction) and Accept.REMOVED in entry.accepted)

_address = re.compile(r"(\d{1,3})([A-Za-z].*)", re.ASCII)
_with_number = re.compile(r"([A-Z]+|[a-z]+)-?\d+", re.ASCII)


def _unknown(text: str) -> tuple[Rule, str]:
    match = _with_number.fullmatch(text)
    if match and (_get(f"{match[1]}=") is not None or values(match[1]) is not None):
        better = f"{match[1]}={text[match.end(1) :]}"
        return rules.EQUAL_SIGN, f"{text}: an assignment needs its equal sign, {better}"
    if later := class5.find(text, class5.COMMANDS):
        return rules.LATER, class5.message(later)
    if len(text) > 1 and not text.strip(text[0]) and not text[0].isalnum():
        return rules.NO_COMMENT, f"{text[:20]} is neither a command nor a comment: a comment begins with '"
    if address := digits_as_address(text):
        byte, rest = address
        motors = f"motor {byte - GLOBAL}" if byte > GLOBAL else "all motors"
        return rules.ADDRESS, (
            f"{text}: the address of {motors} is one byte before the command: in a conversation write "
            rf'\x{byte:X}{rest}, in a program PRINT(#{byte},"{rest} ")'
        )
    if text.startswith("="):
        return rules.BLANKS, f"{text}: blanks around = are not allowed"
    if find(text) is not None:
        return rules.VALUE, f"{text} is a value, not a command: {_reporting(text)} reports it"
    if _find(text.upper())[0] is not None:
        return rules.CASE, f"unknown command {text[:40]}: commands are upper case"
    return rules.UNKNOWN, f"unknown command {text[:40]}"


def _reporting(value: str) -> str:
    """Return the statement that reports a value: PRINT if the value has no report, as P and V (RP reports @P)."""
    report = read(f"R{value.lstrip('@')}")
    handler = report.command.handler if report.command is not None and report.problem is None else None
    named = handler.keywords.get("name", value) if isinstance(handler, partial) else value
    return report.text if handler is not None and named == value else f"PRINT({value},#13)"


def digits_as_address(text: str) -> tuple[int, str] | None:
    """Return the address byte and the command of a text such as `1RP`, in which digits stand for the byte."""
    match = _address.fullmatch(text)
    if match is None or GLOBAL + int(match[1]) > LAST_ADDRESS or read(match[2]).problem is not None:
        return None
    return GLOBAL + int(match[1]), match[2]


_Read = Callable[[str, int, Instruction], tuple[Operand, ...]]


def _number(text: str, at: int, found: Instruction) -> tuple[Operand, ...]:
    digits, allowed_range = text[at:].lstrip("0") or "0", found.parameters[0]
    if len(digits) > 9 or not allowed_range.allows(int(digits)):
        raise Malformed(f"{text[at:][:20]} is out of range: expected {allowed_range}", at, found.chapter, rules.NUMBER)
    return (int(digits),)


def _whole(text: str, at: int, found: Instruction, end: int | None = None, *, assigned: bool = False) -> Expression:
    reader = Reader(text[:end], at, assigned=assigned)
    expression = reader.expression()
    _expect_end(reader, found)
    return expression


def _expect_end(reader: Reader, found: Instruction) -> None:
    extra = reader.text[reader.at :]
    if extra.startswith(":") and (later := class5.find(extra, class5.VALUES)):
        raise Malformed(class5.message(later), reader.at, found.chapter, rules.LATER)
    if extra:
        raise Malformed(
            f"{extra[:20]} is not valid after an expression: expected a space or the end of the line",
            reader.at,
            found.chapter,
        )


def _after(text: str, at: int, found: Instruction) -> tuple[Operand, ...]:
    expression = _whole(text, at, found)
    if found.code != "CASE":
        return (expression,)
    if expression.constant is None:
        raise Malformed("the value of CASE must be a constant, e.g. CASE 1", at, found.chapter)
    return (expression.constant,)


_value = re.compile(r"[ \t]+(-?\d+)", re.ASCII)


def _array(text: str, at: int, found: Instruction) -> tuple[Operand, ...]:
    kind, _ = ARRAY_SIZES[text[:at]]
    index = Reader(text, at)
    first = index.index()
    if not text.startswith("=", index.at):
        return (_list(text, index.at, kind, first),)
    reader = Reader(text, index.at + 1, fetches=len(first.fetches), assigned=True)
    value = reader.expression()
    _expect_end(reader, found)
    code = (1, kind, *first.code, *value.code)
    known = _known(text[:at], at + 1, first), *first.indices, *value.indices
    names = first.names + value.names
    return (Elements(code, first.fetches + value.fetches, tuple(k for k in known if k), names, value.taken),)


def _known(array: str, position: int, first: Expression) -> Index | None:
    return None if first.constant is None else Index(position, array, first.constant)


def _list(text: str, at: int, kind: int, first: Expression) -> Elements:
    listed: list[int] = []
    array = text[:2]
    while match := _value.match(text, at):
        digits = match[1].lstrip("-0") or "0"
        listed.append(int(digits) if len(digits) <= 10 else HIGHEST + 2)
        listed[-1] = -listed[-1] if match[1].startswith("-") else listed[-1]
        at = match.end()
    if not listed:
        raise Malformed(
            f"the value of {array}[…] is missing: expected e.g. {array}[0]=5", at, EQUAL_SIGN, rules.ELEMENTS
        )
    if at == len(text):
        raise Malformed(
            "the list of values does not end with a period: expected e.g. 'aw[0] 1 2 3.'", at, FEATURES_ADDED,
            rules.ELEMENTS,
        )  # fmt: skip
    word = text[at:].strip()
    if word != ".":
        raise Malformed(
            f"{word[:20]} is not a number: expected numbers and a final period, e.g. 'aw[0] 1 2 3.'", at,
            FEATURES_ADDED, rules.ELEMENTS,
        )  # fmt: skip
    known = _known(array, 3, first)
    ends = (known, Index(3, array, known.value + len(listed) - 1)) if known else ()
    code = (len(listed), kind, *first.code, *(word for value in listed for word in _constant(value)))
    return Elements(code, first.fetches, (*ends, *first.indices), first.names, count=len(listed))


def _constant(value: int) -> tuple[int, ...]:
    return (ops.CONSTANT, value, ops.RESULT) if ops.LOWEST <= value <= HIGHEST else (ops.OVERFLOW, ops.RESULT)


def _items(text: str, at: int, found: Instruction) -> tuple[Operand, ...]:
    items: list[Operand] = []
    while True:
        item, at = _item(text, at, found)
        items.append(item)
        if text.startswith(",", at):
            at += 1
        elif text[at:] == ")":
            return tuple(items)
        elif not text[at:]:
            raise Malformed(f"the closing ) is missing: expected {found.syntax}", at, found.chapter, rules.PRINTED)
        else:
            extra = text[at:][:20]
            raise Malformed(
                f"{extra} is not valid after an item of PRINT: expected a comma or )", at, found.chapter, rules.PRINTED
            )


_byte = re.compile(r"#(\d+)", re.ASCII)


def _item(text: str, at: int, found: Instruction) -> tuple[Operand, int]:
    if text.startswith('"', at):
        end = text.find('"', at + 1)
        if end < 0:
            raise Malformed(
                'the closing quote of a text is missing: expected e.g. PRINT("ready")', at, found.chapter, rules.PRINTED
            )
        return text[at + 1 : end], end + 1
    if text.startswith("#", at):
        match = _byte.match(text, at)
        digits = (match[1].lstrip("0") or "0") if match else "999"
        if match is None or len(digits) > 3 or int(digits) > 255:
            raise Malformed(
                "the character code after # is missing or out of range: expected 0…255, e.g. #13",
                at,
                found.chapter,
                rules.PRINTED,
            )
        return bytes((int(digits),)), match.end()
    reader = Reader(text, at)
    return reader.expression(), reader.at


def _call(text: str, at: int, found: Instruction) -> tuple[Operand, ...]:
    if not text.endswith(")"):
        raise Malformed(f"the closing ) is missing: expected {found.syntax}", len(text), found.chapter, rules.ARGUMENTS)
    inner = text[at:-1]
    if len(found.parameters) != 2:
        return (inner,)
    name, comma, _ = inner.rpartition(",")
    if not comma:
        raise Malformed(f"the second argument is missing: expected {found.syntax}", at, found.chapter, rules.ARGUMENTS)
    return First(name), _whole(text, at + len(name) + 1, found, len(text) - 1)


def _report_variable(text: str, _at: int, found: Instruction) -> tuple[Operand, ...]:
    variable = text[1:]
    if find(variable) is None:  # Only the name of an AniLink input can be invalid, e.g. AINA5.
        raise Malformed(
            f"unknown AniLink input {variable[:20]} in the report command {text[:21]}: "
            "expected AINA1…AINH4 (analog) or DINA0…DINH63 (digital), e.g. `RAINA1`", 1, found.chapter, rules.ARGUMENTS,
        )  # fmt: skip
    return (_whole(text, 1, found),)


def _report_array(text: str, _at: int, found: Instruction) -> tuple[Operand, ...]:
    reader = Reader(text, 1)
    element = reader.element()
    _expect_end(reader, found)
    return (element,)


_port = re.compile(r"([A-H])(\d{0,2}),", re.ASCII)


def _output(text: str, at: int, found: Instruction) -> tuple[Operand, ...]:
    match = _port.match(text, at)
    digital = found.code == "DOUTp"
    if match is None or bool(match[2]) != digital or (digital and int(match[2]) > 63):
        example = "DOUTA63,1" if digital else "AOUTA,100"
        raise Malformed(
            f"invalid device or channel in {text[:20]}: expected {found.syntax}, e.g. {example}", at, found.chapter,
            rules.ARGUMENTS,
        )  # fmt: skip
    value = _whole(text, match.end(), found)
    return (match[1], int(match[2]), value) if digital else (match[1], value)


_READERS: dict[Form, _Read] = {
    Form.BARE: lambda text, at, found: (),
    Form.NUMBER: _number,
    Form.LET: lambda text, at, found: (_whole(text, at, found),),
    Form.AFTER: _after,
    Form.ITEMS: _items,
    Form.CALL: _call,
    Form.VARIABLE: lambda text, at, found: (NAMES[text[: at - 1]].place, _whole(text, at, found, assigned=True)),
    Form.ARRAY: _array,
    Form.REPORT_VARIABLE: _report_variable,
    Form.REPORT_ARRAY: _report_array,
    Form.OUTPUT: _output,
}
