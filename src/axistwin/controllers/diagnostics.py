"""What a checker is given and what it says.  The same for every family."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple


class Severity(StrEnum):
    """How bad it is."""

    ERROR = "error"  # the controller will refuse it
    WARNING = "warning"  # it will be obeyed, or ignored, but hardly as it was meant


@dataclass(frozen=True, order=True)
class Diagnostic:
    """Something wrong with a program: where (line and column from 1), what, and the manual's chapter."""

    line: int
    column: int
    severity: Severity
    message: str
    chapter: str = ""


class Sent(NamedTuple):
    """A character that a host sends, and where it stands in the user's file."""

    byte: int
    line: int
    column: int


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
