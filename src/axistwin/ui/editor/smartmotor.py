"""Language support for SmartMotor source, and for commands that a host sends to a SmartMotor."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import chain, pairwise

from axistwin.controllers.smartmotor.chapters.variables import TABLE, Variable, find
from axistwin.controllers.smartmotor.commands import COMMANDS
from axistwin.controllers.smartmotor.language.forms import Accept, Form, Instruction
from axistwin.controllers.smartmotor.language.language import Statement, read
from axistwin.controllers.smartmotor.language.lexer import BEFORE_EXPRESSION, statements
from axistwin.controllers.smartmotor.language.program import OPENS, PARTS, digits, word
from axistwin.core.numbers import NumberError, clipped, whole
from axistwin.ui.editor.answers import Hover, Item, Symbol, explain, item

_COMMENT = re.compile(r"""(?:[^"']|"[^"]*"?)*'""")
_NAME = re.compile(r"@[A-Z]+|B[a-z]|[A-Za-z]+\d*|\d+")
_QUIET = re.compile(r"""'.*|"[^"]*"?""")  # A comment, or a string of a PRINT.
_LABEL = re.compile(r"(?<![^ \t])C[0-9]+(?![^ \t])")
_USED = re.compile(r"(?<![A-Za-z@])([a-z])\1{0,2}(?![A-Za-z])")  # A variable: a…z, aa…zz, aaa…zzz.
_PART = re.compile(rf"(?<![^ \t])(?:{'|'.join((*OPENS, *OPENS.values()))})(?![^ \t])")
LINES = 1 << 16  # Number of different lines that are kept as read, so that a completion reads only what has been typed.
CALLS = ("GOTO", "GOSUB")
LABELLED = ("Cn", "GOTOn", "GOSUBn")  # Codes of the commands that define or call a label.
Span = tuple[int, int, int]  # A place in a program: line and column from 1, and length.
ARRAYS = ("ab", "aw", "al")


@lru_cache(maxsize=LINES)
def parsed(line: str) -> tuple[tuple[Statement, int, int], ...]:
    """Return a line's statements with their start and end; none continues on the next line."""
    return tuple((read(line[begin:end]), begin, end) for begin, end in statements(line))


@dataclass(frozen=True)
class Outline:
    """Labels, variables and block keywords of a line: completion reads no statements of thousands of lines."""

    labels: tuple[tuple[int, int], ...]  # Each label that the line defines, with its column from 1.
    variables: frozenset[str]
    parts: tuple[str, ...]  # Keywords that begin or end a block.


@lru_cache(maxsize=LINES)
def outline(line: str) -> Outline:
    text = _QUIET.sub(_blanks, line) if "'" in line or '"' in line else line
    labels = tuple((digits(each), m.start() + 1) for m in _LABEL.finditer(text) if word(each := read(m[0])) == "Cn")
    return Outline(labels, frozenset(m[0] for m in _USED.finditer(text)), tuple(_PART.findall(text)))


def _blanks(found: re.Match[str]) -> str:
    """Return dots for a string and blanks for a comment, so that C10 is not found in `'go to C10`."""
    return ("." if found[0].startswith('"') else " ") * len(found[0])


@dataclass(frozen=True)
class Source:
    """A SmartMotor program as lines, with methods that find statements and labels."""

    lines: tuple[str, ...]

    @cached_property
    def labels(self) -> dict[int, tuple[int, int]]:
        found: dict[int, tuple[int, int]] = {}
        for number, line in enumerate(self.lines, start=1):
            for label, column in outline(line).labels:
                found.setdefault(label, (number, column))
        return found

    def statement(self, line: int, at: int) -> tuple[Statement, int] | None:
        listed = parsed(self.lines[line - 1])
        return next(((each, begin) for each, begin, end in listed if begin <= at <= end), None)

    def label_at(self, line: int, at: int) -> int | None:
        """Return the label that the statement under the cursor defines or calls; None without a label."""
        found = self.statement(line, at)
        return digits(found[0]) if found is not None and word(found[0]) in LABELLED else None

    def open_blocks(self, line: int, at: int) -> list[str]:
        """Return the IF, WHILE and SWITCH blocks that enclose the cursor.  The innermost block is last."""
        blocks: list[str] = []
        before = (keyword for text in self.lines[: line - 1] for keyword in outline(text).parts)
        here = (word(each) for each, _, end in parsed(self.lines[line - 1]) if end < at)
        for keyword in chain(before, here):
            if keyword in OPENS.values():
                blocks.append(keyword)
            elif keyword in OPENS and blocks[-1:] == [OPENS[keyword]]:
                blocks.pop()
        return blocks


class SourceEditing:
    """Language support for SmartMotor programs (`.sms` files)."""

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None:
        source = Source(tuple(lines))
        found = source.statement(line, at)
        if found is None:
            return None
        statement, begin = found
        return hover(statement.text, at - begin, begin, source)

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]:
        text = lines[line - 1][:at]
        source = Source(tuple(lines))
        return [] if _COMMENT.match(text) else following(text, source, source.open_blocks(line, at))

    def definition(self, lines: list[str], line: int, at: int) -> Span | None:
        source = Source(tuple(lines))
        label = source.label_at(line, at)
        place = None if label is None else source.labels.get(label)
        return None if place is None else (*place, len(f"C{label}"))

    def references(self, lines: list[str], line: int, at: int) -> list[Span]:
        source = Source(tuple(lines))
        label = source.label_at(line, at)
        return [
            (number, begin + 1, end - begin)
            for number, text in enumerate(lines, start=1)
            for statement, begin, end in parsed(text)
            if label is not None and word(statement) in LABELLED and digits(statement) == label
        ]

    def symbols(self, lines: list[str]) -> list[Symbol]:
        source = Source(tuple(lines))
        listed = sorted((place, label) for label, place in source.labels.items())
        last = (len(lines), len(lines[-1]) + 1), -1
        return [
            Symbol(f"C{label}", "label", place, end, self._detail(source, place))
            for (place, label), (end, _) in pairwise([*listed, last])
        ]

    def _detail(self, source: Source, place: tuple[int, int]) -> str:
        _, apostrophe, comment = source.lines[place[0] - 1][place[1] - 1 :].partition("'")
        return comment.strip() if apostrophe else ""


def hover(text: str, at: int, offset: int = 0, source: Source | None = None) -> Hover | None:
    """Return the meaning of the word at the index `at`; `offset`: the statement's column."""
    command = read(text).command
    name = next((m for m in _NAME.finditer(text) if m.start() <= at < m.end() or at == m.end() == len(text)), None)
    in_operands = command is None or (name is not None and name.start() >= len(_keyword(command)))
    if name is not None and in_operands and (variable := find(name[0])) is not None:
        return Hover(_description(variable), offset + name.start(), offset + name.end())
    if command is None:
        return None
    meaning = explain(command)
    if str(command.code) in ("GOTOn", "GOSUBn") and source is not None:
        meaning = f"{_where(text, source)}\n\n{meaning}"
    return Hover(meaning, offset, offset + len(text))


def _where(text: str, source: Source) -> str:
    digits = text.lstrip("GOTSUB")
    label = clipped(digits)
    try:
        place = source.labels.get(whole(digits))
    except NumberError:
        place = None
    return f"C{label} is on line {place[0]}" if place else f"There is no label C{label}"


def _keyword(command: Instruction) -> str:
    return "" if command.form is Form.VARIABLE else re.split(r"[\[(…]|(?<=.)n\Z|pc?\Z", str(command.code))[0]


def _description(variable: Variable) -> str:
    report = COMMANDS.get(f"R{variable.name.lstrip('@')}")
    name = report.name.removeprefix("report ") if report is not None else "variable" if variable.name.islower() else ""
    unit = f"in {variable.unit}" if variable.unit else ""
    return "\n\n".join(
        part for part in (f"**{variable.name}** {name}".strip(), unit, f"Manual: {variable.chapter}") if part
    )


def following(text: str, source: Source, blocks: list[str] | None) -> list[Item]:
    """Return the completions of an incomplete line; `blocks`: the enclosing blocks, None for a host's line."""
    last = re.split(r"[ \t]", text)[-1]
    before = text[: len(text) - len(last)].split()
    call = next((word for word in CALLS if last.startswith(word)), None)
    if call is not None:
        return [Item(f"{call}{label}", "label", f"line {place[0]}") for label, place in sorted(source.labels.items())]
    if re.search(r"[=(\[,]", last) or (before and before[-1] in BEFORE_EXPRESSION):
        return [*_values(), *_variables(source)]
    return [*_commands(blocks), *(Item(f"{name}=", "variable") for name in _names(source))]


def _values() -> Iterator[Item]:
    for variable in TABLE:
        if not variable.name.islower():
            yield Item(variable.name, "value", variable.unit, _description(variable))


def _variables(source: Source) -> Iterator[Item]:
    yield from (Item(name, "variable") for name in _names(source))
    yield from (Item(f"{array}[", "variable", str(COMMANDS.get(f"{array}[]=").name)) for array in ARRAYS)  # type: ignore[union-attr]


def _names(source: Source) -> list[str]:
    return sorted(set().union(*(outline(line).variables for line in source.lines)))


def _commands(blocks: list[str] | None) -> Iterator[Item]:
    for command in COMMANDS:
        if not isinstance(command, Instruction) or command.form in (Form.VARIABLE, Form.REPORT_VARIABLE):
            continue
        if _is_allowed(command, blocks):
            yield item(command, str(command.code), _written(command))


def _is_allowed(command: Instruction, blocks: list[str] | None) -> bool:
    if blocks is None:
        return Accept.HOST in command.accepted
    wanted = OPENS.get(str(command.code)) or PARTS.get(str(command.code))
    if wanted is not None:
        return blocks[-1:] == [wanted]
    if command.code == "BREAK":
        return any(block != "IF" for block in blocks)
    return bool(command.accepted & (Accept.PROGRAM | Accept.BLOCK))


def _written(command: Instruction) -> str:
    match command.form:
        case Form.CALL | Form.ITEMS:
            return str(command.code).removesuffix(")")
        case Form.ARRAY | Form.REPORT_ARRAY:
            return str(command.code).partition("]")[0]
        case Form.NUMBER:
            return str(command.code).removesuffix("n")
        case Form.AFTER:
            return f"{command.code} "
        case Form.OUTPUT:
            return str(command.code).removesuffix("p")
        case _:
            return str(command.code)
