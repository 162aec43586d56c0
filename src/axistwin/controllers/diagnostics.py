"""What a checker is given and what it says.  The same for every family.

A `Rule` is a line in a family's table of codes; a `Diagnostic` is one case of it, with its place and perhaps a `Fix`.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from axistwin.errors import one_line


class Severity(StrEnum):
    """How bad it is."""

    ERROR = "error"  # the controller will refuse it
    WARNING = "warning"  # it will be obeyed, or ignored, but hardly as it was meant


@dataclass(frozen=True)
class Rule:
    """What a checker can find: a line in its table of codes."""

    code: str
    """Such as `DP101`: two letters for the family, a digit for the subject, two for the rule.  Never used again."""
    title: str
    severity: Severity
    chapter: str
    """The manual's, where the command concerned does not name its own."""
    explanation: str
    """What the controller does, and what to do about it."""
    example: str
    """A program in which it is found."""
    suffix: str = ""
    """The kind of file that the example is, where it is not the family's own."""


class Sent(NamedTuple):
    """A character that a host sends, and where it stands in the user's file."""

    byte: int
    line: int
    column: int
    width: int = 1
    """The columns it takes up there: 4 of `\\x30`, none of a line's end."""


class Edit(NamedTuple):
    """From here, up to but without there, stands this instead.  Lines and columns from 1."""

    line: int
    column: int
    end_line: int
    end_column: int
    text: str


@dataclass(frozen=True)
class Fix:
    """What would mend it.  `sure`: it cannot but have been meant so; otherwise it is for a person to choose."""

    title: str
    edits: tuple[Edit, ...]
    sure: bool = True


@dataclass(frozen=True, order=True)
class Diagnostic:
    """Something wrong with a program: where (line and column from 1), what, and the manual's chapter."""

    line: int
    column: int
    severity: Severity
    message: str
    chapter: str = ""
    code: str = ""
    """Of the rule that it breaks."""
    end_line: int = 0
    end_column: int = 0
    """The column behind the last one concerned; 0: only the place is known."""
    fix: Fix | None = field(default=None, compare=False)

    @property
    def end(self) -> tuple[int, int]:
        """Line and column behind what it is about."""
        return (self.end_line, self.end_column) if self.end_line else (self.line, self.column + 1)


def diagnose(
    rule: Rule, characters: Sequence[Sent], message: str, chapter: str = "", fix: Fix | None = None
) -> Diagnostic:
    """A case of `rule`, about the first of these characters to the last one, as far as they are on one line."""
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
    """The edit that puts `text` in the place of these characters; none if they are not all on one line."""
    first, last = characters[0], characters[-1]
    if first.line != last.line:
        return ()
    return (Edit(first.line, first.column, last.line, last.column + last.width, text),)


def put_behind(sent: Sent, text: str) -> tuple[Edit, ...]:
    """The edit that puts `text` behind a character."""
    column = sent.column + sent.width
    return (Edit(sent.line, column, sent.line, column, text),)


def put_before(sent: Sent, text: str) -> tuple[Edit, ...]:
    """The edit that puts `text` before a character."""
    return (Edit(sent.line, sent.column, sent.line, sent.column, text),)


def fixing(title: str, edits: Iterable[Edit], sure: bool = True) -> Fix | None:
    """A fix, if there is something to edit."""
    listed = tuple(edits)
    return Fix(title, listed, sure) if listed else None


@dataclass(frozen=True)
class Session:
    """What a host sends from switching the controller on to switching it off."""

    characters: tuple[Sent, ...]
    initialised: bool = False
    """Whether the controller has been made ready before the first of them."""
    stored: bool = False
    """Whether they are a program as it is stored in the controller, and not what a host says."""


Checker = Callable[[Sequence[Session]], list[Diagnostic]]
"""Finds what is wrong with what a host sends to one controller, without running it."""
