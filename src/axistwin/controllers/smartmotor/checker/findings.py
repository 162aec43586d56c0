"""A program that is being checked: its statements with their places in the text, and its diagnostics."""

from collections.abc import Iterator, Sequence

from axistwin.controllers.diagnostics import Diagnostic, Fix, Rule, Sent, diagnose
from axistwin.controllers.smartmotor.language.expressions import Expression, Problem
from axistwin.controllers.smartmotor.language.language import Statement
from axistwin.controllers.smartmotor.language.program import Program, word


class Findings:
    """Collects the diagnostics of a program; each statement is identified by its number."""

    def __init__(self, characters: Sequence[Sent]) -> None:
        self.characters = characters
        self.program = Program.compile("".join(chr(sent.byte) for sent in characters))
        self.statements = self.program.statements
        self.words = [word(statement) for statement in self.statements]
        self.found: list[Diagnostic] = []

    def report(self, rule: Rule, number: int, message: str, fix: Fix | None = None) -> None:
        self.found.append(diagnose(rule, self.text(number), message, fix=fix))

    def problem(self, number: int, problem: Problem, fix: Fix | None = None) -> None:
        self.found.append(located(self.characters, *self.program.places[number][2:], problem, fix))

    def text(self, number: int) -> Sequence[Sent]:
        place = self.program.places[number]
        return self.characters[place.begin : place.end]

    def line(self, number: int) -> int:
        return self.characters[self.program.places[number].begin].line

    def all(self, *words: str) -> Iterator[tuple[int, Statement]]:
        for number, keyword in enumerate(self.words):
            if keyword in words:
                yield number, self.statements[number]

    def has(self, *words: str) -> bool:
        return any(True for _ in self.all(*words))

    def sets_function(self, bit: int) -> bool:
        """True if a statement F= in the program may set this bit."""
        return any(
            constant_value(statement) is None or (constant_value(statement) or 0) & bit
            for _, statement in self.all("F=")
        )


def located(characters: Sequence[Sent], begin: int, end: int, problem: Problem, fix: Fix | None = None) -> Diagnostic:
    """Return a diagnostic for a problem in, or just after, the statement from `begin` to `end`."""
    here = characters[begin + problem.position : begin + problem.end if problem.end else end]
    if not here:
        at = begin + problem.position
        last = characters[min(at, len(characters)) - 1]
        here = [characters[at] if at < len(characters) else last._replace(column=last.column + last.width, width=0)]
    return diagnose(problem.rule, here, problem.message, problem.chapter, fix)


def constant_value(statement: Statement) -> int | None:
    """Return the constant that a statement assigns, or None if the assigned value is not constant."""
    value = statement.operands[-1] if statement.operands else None
    return value.constant if isinstance(value, Expression) else None
