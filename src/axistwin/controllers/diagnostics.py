"""Data types that the checkers of all families read and return.

A `Rule` is a line in a family's table of codes.  A `Diagnostic` is one violation of a rule, with its place in the
user's file and perhaps a `Fix`.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from axistwin.core.errors import one_line


class Severity(StrEnum):
    """Severity of a diagnostic: error or warning."""

    ERROR = "error"  # Severity for a command that the controller does not accept, e.g. an unknown command.
    WARNING = "warning"  # The controller accepts the command, but the effect is probably not intended.


class Rule(NamedTuple):
    """A kind of problem that a checker reports, with its code and explanation."""

    code: str  # Code such as `DP101`: two letters for the family, one digit for the subject, two digits for the rule.
    title: str
    severity: Severity
    chapter: str  # Chapter of the manual, used if the command does not name a chapter.
    explanation: str  # The controller's reaction, and the remedy.
    example: str
    suffix: str = ""  # File suffix of the example, if it is not the family's own.


class Sent(NamedTuple):
    """A byte that a host sends, with its position in the user's file."""

    byte: int  # In the source of a stored program the code point of the character as typed, which may be above 255.
    line: int
    column: int
    width: int = 1
    """Width of its text in columns: 4 for `\x30`, 0 for the end of a line."""


class Edit(NamedTuple):
    """A text edit: `text` replaces the characters from the begin position up to, but not including, the end position.

    Lines and columns are counted from 1.
    """

    line: int
    column: int
    end_line: int
    end_column: int
    text: str


@dataclass(frozen=True)
class Fix:
    """A suggested correction of the user's file.  `sure` is True if no other correction is possible."""

    title: str
    edits: tuple[Edit, ...]
    sure: bool = True


@dataclass(frozen=True, order=True)
class Diagnostic:
    """A problem in a program: its place (line and column from 1), a message, and the manual's chapter."""

    line: int
    column: int
    severity: Severity
    message: str
    chapter: str = ""
    code: str = ""
    end_line: int = 0
    end_column: int = 0  # Column after the end of the wrong text; 0 if only its beginning is known.
    fix: Fix | None = field(default=None, compare=False)

    @property
    def words(self) -> str:
        """The problem, its correction if there is one, and the code."""
        title = f"; {self.fix.title}" if self.fix is not None and self.fix.title not in self.message else ""
        return f"{self.message}{title} [{self.code}]"

    @property
    def end(self) -> tuple[int, int]:
        return (self.end_line, self.end_column) if self.end_line else (self.line, self.column + 1)


def diagnose(
    rule: Rule, characters: Sequence[Sent], message: str, chapter: str = "", fix: Fix | None = None
) -> Diagnostic:
    """Return a diagnostic that marks these characters; the mark ends with their first line at the latest."""
    first = characters[0]
    last = [sent for sent in characters if sent.line == first.line][-1]
    end = max(last.column + last.width, first.column + 1)
    return Diagnostic(
        first.line, first.column, rule.severity, one_line(message), chapter or rule.chapter, rule.code,
        first.line, end, fix,
    )  # fmt: skip


def replaced(characters: Sequence[Sent], text: str) -> tuple[Edit, ...]:
    """Return an edit that replaces the given characters by `text`.  Characters on several lines are not replaced."""
    first, last = characters[0], characters[-1]
    if first.line != last.line:
        return ()
    return (Edit(first.line, first.column, last.line, last.column + last.width, text),)


def put_behind(sent: Sent, text: str) -> tuple[Edit, ...]:
    column = sent.column + sent.width
    return (Edit(sent.line, column, sent.line, column, text),)


def put_before(sent: Sent, text: str) -> tuple[Edit, ...]:
    return (Edit(sent.line, sent.column, sent.line, sent.column, text),)


def fixing(title: str, edits: Iterable[Edit], sure: bool = True) -> Fix | None:
    """Create a fix from the text edits `edits`.  Return None if `edits` is empty."""
    listed = tuple(edits)
    return Fix(title, listed, sure) if listed else None


class Session(NamedTuple):
    """Data that a host sends between power-on and power-off of the controller."""

    characters: tuple[Sent, ...]
    initialised: bool = False  # True if the controller has been initialised before the first character.
    stored: bool = False  # True if the characters are a program stored in the controller, not data from a host.
    ended: bool = True  # False if the host may send more before power-off, as a user at a terminal may.


Checker = Callable[[Sequence[Session]], list[Diagnostic]]  # Finds problems without running a controller.


def check_last(check: Checker, lines: Sequence[bytes]) -> list[Diagnostic]:
    """Check the last line of a host in the context of the earlier lines, and return its diagnostics."""
    sent = (
        Sent(byte, number, column)
        for number, line in enumerate(lines, start=1)
        for column, byte in enumerate(line, start=1)
    )
    found = check([Session(tuple(sent), initialised=True, ended=False)])
    return [each for each in found if each.line == len(lines)]
