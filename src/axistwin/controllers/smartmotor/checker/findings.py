"""What the checker's rules share: a program with its places, and what has been found in it."""

from collections.abc import Iterator, Sequence

from axistwin.controllers.diagnostics import Diagnostic, Fix, Rule, Sent, diagnose
from axistwin.controllers.smartmotor.language.expressions import Expression, Problem
from axistwin.controllers.smartmotor.language.language import Statement
from axistwin.controllers.smartmotor.language.program import Program, word


class Findings:
    """A program's source and the diagnostics about it.  Statements are told by their numbers."""

    def __init__(self, characters: Sequence[Sent]) -> None:
        self.characters = characters
        self.program = Program.compile(bytes(sent.byte for sent in characters))
        self.statements = self.program.statements
        self.words = [word(statement) for statement in self.statements]
        self.found: list[Diagnostic] = []

    def say(self, rule: Rule, number: int, message: str, fix: Fix | None = None) -> None:
        """Something about a statement."""
        self.found.append(diagnose(rule, self.text(number), message, fix=fix))

    def problem(self, number: int, problem: Problem, fix: Fix | None = None) -> None:
        """What the reader of statements has found wrong with one."""
        self.found.append(told(self.characters, *self.program.places[number][2:], problem, fix))

    def text(self, number: int) -> Sequence[Sent]:
        """The characters of a statement."""
        place = self.program.places[number]
        return self.characters[place.begin : place.end]

    def line(self, number: int) -> int:
        """The line in which a statement stands."""
        return self.characters[self.program.places[number].begin].line

    def all(self, *words: str) -> Iterator[tuple[int, Statement]]:
        """The statements with these keywords."""
        for number, keyword in enumerate(self.words):
            if keyword in words:
                yield number, self.statements[number]

    def has(self, *words: str) -> bool:
        """Whether any of these stands in the program."""
        return any(True for _ in self.all(*words))

    def sets_function(self, bit: int) -> bool:
        """Whether some F= may set this bit."""
        return any(known(statement) is None or (known(statement) or 0) & bit for _, statement in self.all("F="))


def told(characters: Sequence[Sent], begin: int, end: int, problem: Problem, fix: Fix | None = None) -> Diagnostic:
    """A problem with the statement from `begin` to `end`; what is missing at its end is just behind it."""
    here = characters[begin + problem.position : begin + problem.end if problem.end else end]
    if not here:
        at = begin + problem.position
        last = characters[min(at, len(characters)) - 1]
        here = [characters[at] if at < len(characters) else last._replace(column=last.column + last.width, width=0)]
    return diagnose(problem.rule, here, problem.message, problem.chapter, fix)


def known(statement: Statement) -> int | None:
    """The value that a statement assigns, if it is known beforehand."""
    value = statement.operands[-1] if statement.operands else None
    return value.constant if isinstance(value, Expression) else None
