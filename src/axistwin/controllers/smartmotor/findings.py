"""What the checker's rules share: a program with its places, and what has been found in it."""

from collections.abc import Iterator, Sequence

from axistwin.controllers.diagnostics import Diagnostic, Sent, Severity
from axistwin.controllers.smartmotor.expressions import Expression
from axistwin.controllers.smartmotor.language import Statement
from axistwin.controllers.smartmotor.program import Program, word


class Findings:
    """A program's source and the diagnostics about it.  Statements are told by their numbers."""

    def __init__(self, characters: Sequence[Sent]) -> None:
        self.characters = characters
        self.program = Program.compile(bytes(sent.byte for sent in characters))
        self.statements = self.program.statements
        self.words = [word(statement) for statement in self.statements]
        self.found: list[Diagnostic] = []

    def error(self, number: int, message: str, chapter: str, position: int = 0) -> None:
        """The motor will refuse this statement, or what is at this position of its text."""
        self._add(number, Severity.ERROR, message, chapter, position)

    def warn(self, number: int, message: str, chapter: str, position: int = 0) -> None:
        """The motor will obey this statement, but hardly as it was meant."""
        self._add(number, Severity.WARNING, message, chapter, position)

    def _add(self, number: int, severity: Severity, message: str, chapter: str, position: int) -> None:
        at = place(self.characters, self.program.places[number].begin + position)
        self.found.append(Diagnostic(at.line, at.column, severity, message, chapter))

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


def place(characters: Sequence[Sent], offset: int) -> Sent:
    """Where a character stands; just behind the last one if it is missing."""
    if offset < len(characters):
        return characters[offset]
    last = characters[-1]
    return last._replace(column=last.column + 1)


def known(statement: Statement) -> int | None:
    """The value that a statement assigns, if it is known beforehand."""
    value = statement.operands[-1] if statement.operands else None
    return value.constant if isinstance(value, Expression) else None
