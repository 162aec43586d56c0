"""The stored program (8 of the base language), compiled: the interpreter's code, its statements and its labels.

    WHILE a<3   ──▶  0  S_IF    statement 0, exit 11, expression      A statement takes one sample.  Labels, ENDIF, ENDS
      a=a+1          11 S_LET …                                       and comments take none.  ELSE, ELSEIF, BREAK and
    LOOP             …  S_JUMP  statement 2, to 0                     LOOP are jumps, if reached at all.

An invalid statement, or a part of a block without the other parts, sets Bs when reached.  A condition that is not an
expression sets Bs and is false.
"""

from bisect import bisect_right
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.commands import FLOW
from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.language import lexer
from axistwin.controllers.smartmotor.language.expressions import Computed, Problem
from axistwin.controllers.smartmotor.language.forms import Form
from axistwin.controllers.smartmotor.language.language import WITHOUT_VALUE, Statement, read

__all__ = ["Compilation", "Place", "Program", "Statement"]

OPENS = {"ENDIF": "IF", "LOOP": "WHILE", "ENDS": "SWITCH"}  # The end of each kind of block, and its beginning.
PARTS = {"ELSEIF": "IF", "ELSE": "IF", "CASE": "SWITCH", "DEFAULT": "SWITCH"}
OTHERWISE = frozenset({"ELSE", "DEFAULT"})  # Parts that occur once in a block; ELSE is the last part of an IF.
SILENT = frozenset({"ENDIF", "ENDS", "CASE", "DEFAULT"})  # Keywords of statements that need no code.
PIECE = 64  # Number of statements that one step of a compilation processes.


class Place(NamedTuple):
    """The place of a statement in the text of a program; line and column are counted from 1."""

    line: int
    column: int
    begin: int
    end: int


@dataclass
class _Block:
    begin: int
    parts: list[int] = field(default_factory=list)
    breaks: list[int] = field(default_factory=list)
    otherwise: str = ""
    end: int = -1

    def after(self, number: int) -> int:
        at = bisect_right(self.parts, number)
        return self.parts[at] if at < len(self.parts) else self.end


@dataclass(frozen=True)
class Program:
    """A compiled program.  `code` is for the interpreter; an empty text is a program without statements."""

    text: str
    code: Sequence[int]
    statements: tuple[Statement, ...]
    labels: Mapping[int, int]  # The index in `code` of each label; of a repeated label, the first index.
    places: tuple[Place, ...]
    begins: tuple[int, ...]  # The index in `code` of each statement.
    heads: tuple[int, ...] = ()
    """Indices in `code` of the operations that take a sample, in ascending order.

    If the code reports the beginning of a statement, the index is that of the report.
    """
    announces: frozenset[int] = frozenset()
    """Numbers of the statements whose beginning the code reports.  The report is a FETCH operation without values."""

    @classmethod
    def compile(cls, text: str | bytes, *, announces: frozenset[int] = frozenset()) -> "Program":
        """Compile the source text of a program.  An invalid statement sets Bs when executed."""
        return Compilation(text if isinstance(text, str) else text.decode("latin-1"), announces).result()

    def announcing(self, numbers: frozenset[int]) -> "Program":
        """Return the same program, in which these statements are announced before their execution."""
        return self if numbers == self.announces else self.compile(self.text, announces=numbers)

    def number_at(self, head: int) -> int:
        """Return the number of the statement at this place of `heads`; at the end, the number of statements."""
        number = self.code[head + 1]
        return ~number if number < 0 else number

    def announcement(self, head: int) -> int:
        """Return the number of code words that announce the statement at this place; 0 if it is not announced."""
        return ops.HEAD if self.code[head + 1] < 0 else 0


class Compilation:
    """A compilation in short steps, so that a long program does not block the simulation."""

    def __init__(self, text: str, announces: frozenset[int] = frozenset()) -> None:
        self._pieces = _pieces(text, announces)
        self._program: Program | None = None

    def step(self) -> bool:
        """Compile the next statements of a program.  Return True if the whole program is compiled."""
        if self._program is None:
            try:
                next(self._pieces)
            except StopIteration as end:
                self._program = end.value
        return self._program is not None

    def result(self) -> Program:
        while not self.step():
            pass
        assert self._program is not None
        return self._program


def _pieces(source: str, announces: frozenset[int]) -> Generator[None, None, Program]:
    lines = lexer.line_begins(source)
    places: list[Place] = []
    statements: list[Statement] = []
    for begin, end in lexer.statements(source):
        places.append(_place(lines, begin, end))
        statements.append(read(source[begin:end]))
        if len(statements) % PIECE == 0:
            yield
    matcher = _Matcher(statements)
    yield from matcher.match()
    writer = _Writer(statements, matcher.blocks, announces)
    yield from writer.write()
    begins, heads = tuple(writer.begins), tuple(writer.heads)
    return Program(source, writer.code, tuple(statements), writer.labels, tuple(places), begins, heads, announces)


def _place(lines: Sequence[int], begin: int, end: int) -> Place:
    line = bisect_right(lines, begin)
    return Place(line, begin - lines[line - 1] + 1, begin, end)


def word(statement: Statement) -> str:
    """Return a statement's keyword, "" if it is invalid; a block's keyword needs no expression here."""
    sound = statement.problem is None or WITHOUT_VALUE in statement.operands
    return str(statement.command.code) if statement.command is not None and sound else ""


class _Matcher:
    """Finds the parts of each block: IF and ENDIF, WHILE and LOOP, SWITCH and ENDS."""

    def __init__(self, statements: list[Statement]) -> None:
        self.statements = statements
        self.blocks: dict[int, _Block] = {}  # The block to which a statement belongs, by its number.
        self._open: list[_Block] = []
        self._left: list[_Block] = []  # Stack of the open blocks that a BREAK can leave.
        self._broken = 0

    def match(self) -> Iterator[None]:
        """Find all blocks; a generator, so that a long program can be matched in pieces."""
        for number, statement in enumerate(self.statements):
            keyword = word(statement)
            if keyword in OPENS.values():
                self._begin(_Block(number), keyword)
            elif keyword in OPENS:
                self._close(number, OPENS[keyword])
            elif keyword in PARTS:
                self._part(number, PARTS[keyword])
            elif keyword == "BREAK":
                self._break(number)
            if number % PIECE == PIECE - 1:
                yield
        for block in self._open:
            yield from self._abandon(block)

    def _begin(self, block: _Block, keyword: str) -> None:
        self._open.append(block)
        if keyword != "IF":
            self._left.append(block)

    def _keyword(self, block: _Block) -> str:
        return word(self.statements[block.begin])

    def _inner(self, keyword: str) -> _Block | None:
        return self._open[-1] if self._open and self._keyword(self._open[-1]) == keyword else None

    def _close(self, number: int, keyword: str) -> None:
        block = self._inner(keyword)
        if block is None:
            self._break_off(number, self._left_over(keyword))
            return
        self._open.pop()
        if keyword != "IF":
            self._left.pop()
        block.end = number
        for member in (block.begin, *block.parts, *block.breaks, number):
            self.blocks[member] = block

    def _left_over(self, keyword: str) -> str:
        if not self._open:
            return f"no {keyword} before this statement"
        return f"no open {keyword} before this statement; {self.statements[self._open[-1].begin].text} has not ended"

    def _part(self, number: int, keyword: str) -> None:
        block = self._inner(keyword)
        if block is None:
            self._break_off(number, self._left_over(keyword))
        elif block.otherwise and (keyword == "IF" or word(self.statements[number]) == block.otherwise):
            self._break_off(number, f"it stands behind {block.otherwise}")
        else:
            block.parts.append(number)
            if word(self.statements[number]) in OTHERWISE:
                block.otherwise = word(self.statements[number])

    def _break(self, number: int) -> None:
        if self._left:
            self._left[-1].breaks.append(number)
        else:
            self._break_off(number, "it leaves a SWITCH or a WHILE, and stands in none")

    def _abandon(self, block: _Block) -> Iterator[None]:
        ending = next(end for end, begin in OPENS.items() if begin == self._keyword(block))
        for member in (block.begin, *block.parts, *block.breaks):
            self._break_off(member, f"{ending} is missing")
            self._broken += 1
            if self._broken % PIECE == 0:
                yield

    def _break_off(self, number: int, why: str) -> None:
        statement = self.statements[number]
        assert statement.command is not None
        problem = Problem(0, f"{statement.command.code}: {why}", FLOW, rules.BLOCK)
        self.statements[number] = replace(statement, operands=(), problem=problem)


class _Writer:
    """Writes the code of a compiled program.  The targets of jumps are inserted after all other code."""

    def __init__(
        self, statements: Sequence[Statement], blocks: Mapping[int, _Block], announces: frozenset[int]
    ) -> None:
        self.statements, self.blocks, self._announces = statements, blocks, announces
        self.labels: dict[int, int] = {}
        self.begins: list[int] = []  # Place in the code at which the preceding statement continues, for each statement.
        self.heads: list[int] = []
        self._entries: list[int] = []  # Place in the code to which jumps within its block lead, for each statement.
        self.code: list[int] = []
        self._last = -1, -1
        self._jumps: list[tuple[int, int]] = []  # Index of a word, and the statement whose place it gets.
        self._calls: list[tuple[int, int, int, int]] = []
        """Jumps to labels: index of a word in the code, label, and begin and end of the statement."""

    def write(self) -> Iterator[None]:
        """Generate the code of all statements; a generator, so that a long program can be written in pieces."""
        for number, statement in enumerate(self.statements):
            self.begins.append(len(self.code))
            self._entries.append(len(self.code))
            yield from self._statement(number, statement) or ()
            if number % PIECE == PIECE - 1:
                yield
        self._head(ops.S_END, len(self.statements))
        for at, number in self._jumps:
            self.code[at] = self._entries[number]
        for call in self._calls:
            self._find_label(*call)

    def _head(self, operation: int, number: int) -> int:
        self.heads.append(len(self.code))
        if number in self._announces and not self._within(number):
            self.code += (ops.S_FETCH, ~number, len(self.code) + ops.HEAD)
        self._last = operation, number
        self.code += (operation, number, len(self.code))
        return len(self.code) - 1

    def _within(self, number: int) -> bool:
        return self._last in ((ops.S_FETCH, number), (ops.S_SWITCH, number))

    def _simple(self, operation: int, number: int, statement: Statement | None = None) -> None:
        target = self._head(operation, number)
        for part in statement.operands if statement else ():
            if isinstance(part, Computed):
                self.code += part.code
            elif isinstance(part, int):
                self.code.append(part)
        self.code[target] = len(self.code)

    def _statement(self, number: int, statement: Statement) -> Iterator[None] | None:
        keyword, form = word(statement), statement.command.form if statement.command else None
        if keyword in _OPERATIONS:
            self._fetch(number, statement)
            self._simple(_OPERATIONS[keyword], number, statement)
        elif keyword in _WRITERS:
            return _WRITERS[keyword](self, number, statement)
        elif keyword and form in (Form.VARIABLE, Form.ARRAY):
            self._fetch(number, statement)
            self._simple(ops.S_LET if form is Form.VARIABLE else ops.S_ELEMENT, number, statement)
        elif keyword not in SILENT:
            self._simple(ops.S_TRAP, number)
        return None

    def _fetch(self, number: int, statement: Statement) -> None:
        if any(part.fetches for part in statement.computed):
            self._simple(ops.S_FETCH, number)

    def _jump(self, number: int, to: int) -> None:
        self._jumps.append((self._head(ops.S_JUMP, number), to))

    def _label(self, _: int, statement: Statement) -> None:
        self.labels.setdefault(digits(statement), len(self.code))

    def _goto(self, number: int, statement: Statement) -> None:
        target = self._head(ops.S_JUMP, number)
        self._calls.append((target, digits(statement), target - 2, len(self.code)))

    def _gosub(self, number: int, statement: Statement) -> None:
        target = self._head(ops.S_GOSUB, number)
        self.code.append(target - 2)
        self.code[target] = len(self.code)
        self._calls.append((target + 1, digits(statement), target - 2, len(self.code)))

    def _find_label(self, at: int, label: int, begin: int, end: int) -> None:
        """Set the jump target of a GOTO or GOSUB.  A statement whose label does not exist sets Bs."""
        if label in self.labels:
            self.code[at] = self.labels[label]
        else:
            self.code[begin], self.code[begin + 2] = ops.S_TRAP, end

    def _condition(self, number: int, statement: Statement) -> None:
        block = self.blocks[number]
        if number != block.begin:
            self._jump(number, block.end)
            self._entries[number] = len(self.code)
        self._fetch(number, statement)
        target = self._head(ops.S_IF, number)
        self.code += statement.computed[0].code
        self._jumps.append((target, block.after(number)))

    def _else(self, number: int, _: Statement) -> None:
        self._jump(number, self.blocks[number].end)
        self._entries[number] = len(self.code)

    def _loop(self, number: int, _: Statement) -> None:
        self._jump(number, self.blocks[number].begin)
        self._entries[number] = len(self.code)

    def _break(self, number: int, _: Statement) -> None:
        self._jump(number, self.blocks[number].end)

    def _switch(self, number: int, statement: Statement) -> Iterator[None]:
        block = self.blocks[number]
        cases = [part for part in block.parts if word(self.statements[part]) == "CASE"]
        otherwise = next((part for part in block.parts if word(self.statements[part]) != "CASE"), block.end)
        self._fetch(number, statement)
        self._jumps.append((self._head(ops.S_SWITCH, number), otherwise))
        self.code += statement.computed[0].code
        if cases:
            yield from self._cases(cases, otherwise)
        else:
            self._jump(number, otherwise)

    def _cases(self, cases: Sequence[int], otherwise: int) -> Iterator[None]:
        for count, (case, following) in enumerate(zip(cases, (*cases[1:], None), strict=True), 1):
            target = self._case(case)
            if following is None:
                self._jumps.append((target, otherwise))
            else:
                self.code[target] = len(self.code)
            if count % PIECE == 0:
                yield

    def _case(self, case: int) -> int:
        """Write the comparison of a CASE with its constant; a CASE without a constant sets Bs."""
        if self.statements[case].problem is not None:
            target = self._head(ops.S_IF, case)
            self.code += WITHOUT_VALUE.code
            return target
        target = self._head(ops.S_CASE, case)
        self.code += (digits(self.statements[case]), 0)
        self._jumps.append((len(self.code) - 1, case))
        return target


def digits(statement: Statement) -> int:
    """Return the number that a label, GOTO, GOSUB or CASE contains."""
    value = statement.operands[0]
    assert isinstance(value, int)
    return value


_OPERATIONS = {
    "END": ops.S_END, "RETURN": ops.S_RETURN, "RETURNF": ops.S_RETURN, "RETURNI": ops.S_RETURNI, "STACK": ops.S_STACK,
    "WAIT=": ops.S_WAIT, "TWAIT": ops.S_TWAIT,
}  # fmt: skip
_WRITERS: dict[str, Callable[[_Writer, int, Statement], Iterator[None] | None]] = {
    "Cn": _Writer._label, "GOTOn": _Writer._goto, "GOSUBn": _Writer._gosub, "IF": _Writer._condition,
    "ELSEIF": _Writer._condition, "ELSE": _Writer._else, "WHILE": _Writer._condition, "LOOP": _Writer._loop,
    "SWITCH": _Writer._switch, "BREAK": _Writer._break,
}  # fmt: skip
"""Functions that write statements which are more than an operation with an expression, by keyword."""
