"""The answers, in columns of the text.  Lines count from 1; `begin` and `end` are indexes into a line."""

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

from axistwin.bench.control_characters import in_words
from axistwin.controllers.commandset import Command, Field


@dataclass(frozen=True)
class Hover:
    """What a word means, in Markdown, and where in its line the word stands."""

    text: str
    begin: int
    end: int


@dataclass(frozen=True)
class Item:
    """Something that may be written at a place.  `insert`: what is written, where that is not its label."""

    label: str
    kind: str = "command"
    """command, value, variable, label, key, pin."""
    detail: str = ""
    text: str = ""
    """Markdown."""
    insert: str = ""


@dataclass(frozen=True)
class Symbol:
    """A part of the text that has a name, from a place to another."""

    name: str
    kind: str
    """label, sequence, step, move, table, controller."""
    begin: tuple[int, int]
    end: tuple[int, int]
    detail: str = ""
    children: list["Symbol"] = field(default_factory=list)


class Editing(Protocol):
    """What can be asked about a kind of text.  `line` from 1, `at` an index into it: the cursor stands before it."""

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None:
        """What the word at a place means."""

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]:
        """What may be written at a place."""

    def symbols(self, lines: list[str]) -> list[Symbol]:
        """What the text is made of."""


def explained(command: Command, marked: Field | None = None) -> str:
    """A line of the command table in Markdown; `marked`: the parameter that is looked at."""
    paragraphs = [f"**{in_words(str(_code(command)))}** {command.name}", f"`{in_words(command.syntax)}`"]
    if command.parameters:
        paragraphs.append("\n".join(f"- {_parameter(each, marked)}" for each in command.parameters))
    if command.handler is not None and (told := _docstring(command.handler)):
        paragraphs.append(told)
    paragraphs.append(f"Manual: {command.chapter}")
    return "\n\n".join(paragraphs)


def item(command: Command, label: str, insert: str = "") -> Item:
    """A command as something that may be written."""
    return Item(label, "command", f"{command.name} · {in_words(command.syntax)}", explained(command), insert)


def _code(command: Command) -> str:
    return f"{command.code:02X}" if isinstance(command.code, int) else command.code


def _parameter(parameter: Field, marked: Field | None) -> str:
    optional = " (may be left out)" if parameter.optional else ""
    text = f"{str(parameter).strip('[]')}{optional}"
    return f"**{text}**" if parameter is marked else text


def _docstring(handler: Callable[..., Any]) -> str:
    """What the handler of a command says about it, if it is the handler of that command alone."""
    if isinstance(handler, partial):
        return ""
    return " ".join((inspect.getdoc(handler) or "").split())


def words(line: str) -> Iterator[tuple[int, int]]:
    """Where the words of a line begin and end."""
    at = 0
    for word in line.split():
        begin = line.index(word, at)
        at = begin + len(word)
        yield begin, at
