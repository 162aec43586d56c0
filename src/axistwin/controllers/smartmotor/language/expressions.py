"""Parser of expressions (section 7 of the base language), which converts text to code for the interpreter.

Operators from the strongest to the weakest: unary minus; ^; * / %; + -; comparisons; &; !|; |.  Operations of equal
strength are evaluated from left to right.  Constant parts are computed beforehand, unless they have no value.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, NoReturn

from axistwin.controllers.diagnostics import Rule
from axistwin.controllers.smartmotor import rules
from axistwin.controllers.smartmotor.chapters.variables import ARRAY_SIZES, find
from axistwin.controllers.smartmotor.kernel import interpreter as ops
from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.interpreter import HIGHEST, LOWEST, STACK, combined, evaluate
from axistwin.controllers.smartmotor.language import class5
from axistwin.controllers.smartmotor.processor import Processor

CHAPTER = "Variables and mathematics"
DEEPEST = 20  # The largest depth of nested parentheses and indices.

LEVELS = (
    {"|": ops.OR},
    {"!|": ops.EXCLUSIVE_OR},
    {"&": ops.AND},
    {"==": ops.EQ, "!=": ops.NE, "<=": ops.LE, ">=": ops.GE, "<": ops.LT, ">": ops.GT},
    {"+": ops.ADD, "-": ops.SUBTRACT},
    {"*": ops.MULTIPLY, "/": ops.DIVIDE, "%": ops.REMAINDER},
    {"^": ops.POWER},
)
"""Operations with two values by precedence, the weakest first."""
OPERATIONS = {token: (level, code) for level, listed in enumerate(LEVELS) for token, code in listed.items()}
"""Level of precedence and operation by token."""

_later = re.compile(r"[A-Za-z]+\d*(?:\((?:[^()]|\([^()]*\))*\))?(?::\w+)?", re.ASCII)
"""A value of Class 5, perhaps with arguments and the address of another motor, e.g. `B(0,1)` or `PA:3`."""
_token = re.compile(r"@[A-Z]+|B[a-z]|[A-Z]+\d*|[a-z]+|\d+|!\||[=!<>]=|[-+*/%^&|<>()\[\]]", re.ASCII)


class Problem(NamedTuple):
    """An error in a statement: its place in the text, and the manual's chapter."""

    position: int
    message: str
    chapter: str = CHAPTER
    rule: Rule = rules.EXPRESSION
    end: int = 0  # The index after the wrong part; 0: the end of the statement.


class Malformed(Exception):  # noqa: N818  # internal: `read` catches this error
    """Raised by the parser for text that is not a valid expression or command.  Users never receive this exception."""

    def __init__(
        self, message: str, position: int, chapter: str = CHAPTER, rule: Rule = rules.EXPRESSION, end: int = 0
    ) -> None:
        super().__init__(message)
        self.problem = Problem(position, message, chapter, rule, end)


class Index(NamedTuple):
    """A constant array index, which the checker compares with the array's size."""

    position: int
    array: str
    value: int


@dataclass(frozen=True)
class Computed:
    """Base class of operands whose values the interpreter computes when the statement is executed."""

    code: tuple[int, ...]
    fetches: "tuple[Callable[[Processor], int], ...]" = ()
    """Functions that fetch the external values for the hidden variables, in the order of the text."""
    indices: tuple[Index, ...] = ()
    names: tuple[str, ...] = ()  # The names of the variables, in the order of the text.
    taken: tuple[str, ...] = ()  # Pins whose level the expression assigns to a variable (manual, section 5.1, note 2).

    def fetch(self, motor: Processor) -> None:
        for number, fetch in enumerate(self.fetches):
            motor.v[s.HIDDEN + number] = fetch(motor)


@dataclass(frozen=True)
class Expression(Computed):
    """A compiled expression of a SmartMotor command, e.g. `a+1` in `b=a+1`."""

    @cached_property
    def constant(self) -> int | None:
        known = len(self.code) == 3 and self.code[0] == ops.CONSTANT
        return self.code[1] if known else None

    def value(self, motor: Processor) -> int | None:
        """Return the present value of the expression, or None after an arithmetic or index error."""
        self.fetch(motor)
        stack = [0] * STACK
        return stack[0] if evaluate(motor.i, motor.v, stack, self.code, 0) >= 0 else None


class Reader:
    """Parses expressions.  `at`: current index; `assigned`: True if the value is assigned to a variable."""

    def __init__(self, text: str, at: int = 0, fetches: int = 0, *, assigned: bool = False) -> None:
        self.text, self.at, self._assigned = text, at, assigned
        self._code: list[list[int]] = []  # Compiled expression: a list of operations with their arguments
        self._height = self._highest = self._deep = 0
        self._fetches: list[Callable[[Processor], int]] = []
        self._fetched = fetches
        self._indices: list[Index] = []
        self._names: list[str] = []
        self._taken: list[str] = []

    def expression(self) -> Expression:
        """Parse the expression that begins at the current index in the text.  Raises Malformed."""
        self._binary(0)
        return self._read()

    def element(self) -> Expression:
        """Return the array element at the current index.  Raises Malformed."""
        self._array(self._next())
        return self._read()

    def _read(self) -> Expression:
        if self._highest > STACK:
            raise Malformed(
                "the expression is too long: split the assignment, e.g. write 'a=b+c a=a+d' instead of 'a=b+c+d'",
                self.at,
            )
        code = tuple(number for word in self._code for number in word)
        return Expression(
            (*code, ops.RESULT), tuple(self._fetches), tuple(self._indices), names=tuple(self._names),
            taken=tuple(self._taken),
        )  # fmt: skip

    def index(self) -> Expression:
        """Parse an array index in brackets, e.g. [5], at the present position in the text.  Raises Malformed."""
        self._nested("]")
        return self._read()

    def _next(self) -> str:
        match = _token.match(self.text, self.at)
        return match[0] if match else ""

    def _expect(self, bracket: str) -> None:
        if self._next() != bracket:
            raise Malformed(f"the closing {bracket} is missing: expected e.g. (a+1)*2 or aw[5]", self.at)
        self.at += len(bracket)

    def _emit(self, *word: int) -> None:
        self._code.append(list(word))

    def _push(self, *word: int) -> None:
        self._emit(*word)
        self._height += 1
        self._highest = max(self._highest, self._height)

    def _binary(self, weakest: int) -> None:
        self._unary()
        while (found := OPERATIONS.get(token := self._next())) is not None and found[0] >= weakest:
            level, operation = found
            self.at += len(token)
            self._binary(level + 1)
            self._height -= 1
            self._combine(operation)

    def _combine(self, operation: int) -> None:
        left, right = self._code[-2:] if len(self._code) > 1 else ([], [])
        if left[:1] == right[:1] == [ops.CONSTANT]:
            value = combined(operation, left[1], right[1])
            if LOWEST <= value <= HIGHEST:
                self._code[-2:] = [[ops.CONSTANT, value]]
                return
        self._emit(operation)

    def _unary(self) -> None:
        minuses = 0
        while self._next() == "-":
            minuses += 1
            self.at += 1
        token = self._next()
        if token.isdecimal():
            self._number(token, minuses)
        else:
            self._operand(token)
            # Do not compile `--a` as `a`, because the first negation sets the overflow flag Bd if a is -2147483648.
            # Compile `---a` as `-a`, because the effect is the same.
            for _ in range(2 - minuses % 2 if minuses else 0):
                self._negate()

    def _negate(self) -> None:
        last = self._code[-1]
        if last[0] == ops.CONSTANT and last[1] != LOWEST:
            last[1] = -last[1]
        else:
            self._emit(ops.NEGATIVE)

    def _number(self, token: str, minuses: int) -> None:
        self.at += len(token)
        digits = token.lstrip("0")
        value = int(digits or "0") if len(digits) <= 10 else HIGHEST + 2
        value = -value if minuses % 2 else value
        if LOWEST <= value <= HIGHEST and (minuses < 2 or value != LOWEST):
            self._push(ops.CONSTANT, value)
        else:
            self._push(ops.OVERFLOW)

    def _operand(self, token: str) -> None:
        if token == "(":  # noqa: S105  # of an expression
            self._nested(")")
        elif token in ARRAY_SIZES:
            self._array(token)
        elif (variable := find(token)) is not None and not (token.isupper() and self._later(token)):
            self._names.append(token)
            if variable.fetch is None:
                taken = self._assigned and variable.operation == ops.PIN
                self._taken += [token] if taken else []
                self._push(ops.TAKEN_PIN if taken else variable.operation, variable.place)
            else:
                self._hidden(variable.fetch)
            self.at += len(token)
        else:
            self._refuse(token)

    def _later(self, token: str) -> tuple[str, class5.Found] | None:
        word = _later.match(self.text, self.at)
        texts = (word[0], token) if word else (token,)
        return next(((text, later) for text in texts if (later := class5.find(text, class5.VALUES))), None)

    def _refuse(self, token: str) -> NoReturn:
        if not self.text[self.at :]:
            raise Malformed("a value is missing at the end of the expression: expected e.g. a+1", self.at)
        if not token or not token[-1].isalnum():
            character = self.text[self.at]
            raise Malformed(f"a value is missing before {character!r}: expected a number or a variable", self.at)
        if later := self._later(token):
            raise Malformed(class5.message(later[1]), self.at, rule=rules.LATER, end=self.at + len(later[0]))
        examples = token.lower() if find(token.lower()) else "aa, al[0] or CLK"
        raise Malformed(
            f"there is no variable {token}: expected e.g. {examples}", self.at, rule=rules.VARIABLE,
            end=self.at + len(token),
        )  # fmt: skip

    def _hidden(self, fetch: Callable[[Processor], int]) -> None:
        place = self._fetched + len(self._fetches)
        if place >= s.HIDDEN_MOST:
            raise Malformed(
                f"too many inputs such as GETCHR or AINA1 in one statement: expected at most {s.HIDDEN_MOST}", self.at
            )
        self._fetches.append(fetch)
        self._push(ops.VARIABLE, s.HIDDEN + place)

    def _nested(self, closing: str) -> None:
        self.at += 1
        self._deep += 1
        if self._deep > DEEPEST:
            raise Malformed(f"the parentheses are nested too deep: expected at most {DEEPEST} levels", self.at)
        self._binary(0)
        self._expect(closing)
        self._deep -= 1

    def _array(self, name: str) -> None:
        self.at += len(name)
        position = self.at + 1
        if self._next() != "[":
            raise Malformed(f"the index of the array {name} is missing: expected e.g. {name}[0]", self.at)
        self._nested("]")
        operation, _ = ARRAY_SIZES[name]
        if self._code[-1][0] == ops.CONSTANT:
            self._indices.append(Index(position, name, self._code[-1][1]))
        self._names.append(name)
        self._emit(operation)
