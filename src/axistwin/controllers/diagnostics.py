"""Input and output of checkers, for all families.

A `Rule` is a line in a family's table of codes; a `Diagnostic` is one violation of a rule, with its place and perhaps a
`Fix`.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from axistwin.errors import one_line


class Severity(StrEnum):
    """Severity of a diagnostic."""

    ERROR = "error"  # the controller refuses it
    WARNING = "warning"  # the controller accepts or ignores it, but the effect is probably not intended


@dataclass(frozen=True)
class Rule:
    """A rule for checkers: a line in a table of codes."""

    code: str
    """Such as `DP101`: two letters for the family, a digit for the subject, two for the rule; never reused."""
    title: str
    severity: Severity
    chapter: str
    """Chapter of the manual, unless the command names its own."""
    explanation: str
    """The controller's reaction, and the remedy."""
    example: str
    suffix: str = ""
    """File suffix of the example, if it is not the family's own."""


class Sent(NamedTuple):
    """A character from a host, and its place in the user's file."""

    byte: int
    line: int
    column: int
    width: int = 1
    """Its width in columns: 4 for `\x30`, 0 for the end of a line."""


class Edit(NamedTuple):
    """A replacement of the text from the first place up to, not including, the second.  Lines and columns from 1."""

    line: int
    column: int
    end_line: int
    end_column: int
    text: str


@dataclass(frozen=True)
class Fix:
    """A correction.  `sure`: no other correction is possible; otherwise the user must choose."""

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
    end_column: int = 0
    """The column after the last one concerned; 0: only the beginning is known."""
    fix: Fix | None = field(default=None, compare=False)

    @property
    def end(self) -> tuple[int, int]:
        """Line and column after the text concerned."""
        return (self.end_line, self.end_column) if self.end_line else (self.line, self.column + 1)


def diagnose(
    rule: Rule, characters: Sequence[Sent], message: str, chapter: str = "", fix: Fix | None = None
) -> Diagnostic:
    """Return a violation of `rule`, from the first of these characters to the last one on the same line."""
    first = characters[0]
    last = [sent for sent in characters if sent.line == first.line][-1]
    end = max(last.column + last.width, first.column + 1)
    return Diagnostic(
        first.line,
        first.column,
        rule.severity,
        one_line(message),
        chapter or rule.chapter,
        rule.code,
        first.line,
        end,
        fix,
    )


def replaced(characters: Sequence[Sent], text: str) -> tuple[Edit, ...]:
    """Return the edit that replaces these characters; none if they are not all on one line."""
    first, last = characters[0], characters[-1]
    if first.line != last.line:
        return ()
    return (Edit(first.line, first.column, last.line, last.column + last.width, text),)


def put_behind(sent: Sent, text: str) -> tuple[Edit, ...]:
    """Return the edit that inserts `text` after a character."""
    column = sent.column + sent.width
    return (Edit(sent.line, column, sent.line, column, text),)


def put_before(sent: Sent, text: str) -> tuple[Edit, ...]:
    """Return the edit that inserts `text` before a character."""
    return (Edit(sent.line, sent.column, sent.line, sent.column, text),)


def fixing(title: str, edits: Iterable[Edit], sure: bool = True) -> Fix | None:
    """Return a fix; None if there are no edits."""
    listed = tuple(edits)
    return Fix(title, listed, sure) if listed else None


@dataclass(frozen=True)
class Session:
    """Data from a host between power-on and power-off of the controller."""

    characters: tuple[Sent, ...]
    initialised: bool = False
    """True if the controller has been initialised before the first character."""
    stored: bool = False
    """True if the characters are a program stored in the controller, instead of data from a host."""


Checker = Callable[[Sequence[Session]], list[Diagnostic]]
"""Finds problems in a host's data for one controller, without running it."""
