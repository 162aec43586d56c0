"""Answers to an editor.  The first line is 1; `begin` and `end` are indexes into a line, from 0."""

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

from axistwin.bench.codec import show_controls
from axistwin.controllers.commandset import Command, Field


@dataclass(frozen=True)
class Hover:
    """Answer to a hover request: the meaning of a word in Markdown, and its place in the line."""

    text: str
    begin: int
    end: int


@dataclass(frozen=True)
class Item:
    """A completion that an editor proposes; `insert`: the text to insert, if it differs from `label`."""

    label: str
    kind: str = "command"  # One of: command, value, variable, label, key, pin.
    detail: str = ""
    text: str = ""  # Markdown.
    insert: str = ""


@dataclass(frozen=True)
class Symbol:
    """A named part of a program, e.g. a label or a sequence.  `begin` and `end`: line and column."""

    name: str
    kind: str  # One of: label, sequence, step, move, table.
    begin: tuple[int, int]
    end: tuple[int, int]
    detail: str = ""
    children: list["Symbol"] = field(default_factory=list)


class Editing(Protocol):
    """Interface for questions about one kind of program.  `line`: from 1; `at`: index of the character."""

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None: ...

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]: ...

    def symbols(self, lines: list[str]) -> list[Symbol]:
        """Return the named parts of the text, e.g. labels and sequences."""


def explain(command: Command, marked: Field | None = None) -> str:
    """Return the description of a command in Markdown.  `marked`: the parameter to emphasise."""
    code = f"{command.code:02X}" if isinstance(command.code, int) else command.code
    paragraphs = [f"**{show_controls(code)}** {command.name}", f"`{show_controls(command.syntax)}`"]
    if command.parameters:
        paragraphs.append("\n".join(f"- {_parameter(each, marked)}" for each in command.parameters))
    if command.handler is not None and (description := _docstring(command.handler)):
        paragraphs.append(description)
    paragraphs.append(f"Manual: {command.chapter}")
    return "\n\n".join(paragraphs)


def item(command: Command, label: str, insert: str = "") -> Item:
    return Item(label, "command", f"{command.name} · {show_controls(command.syntax)}", explain(command), insert)


def _parameter(parameter: Field, marked: Field | None) -> str:
    optional = " (may be left out)" if parameter.optional else ""
    text = f"{str(parameter).strip('[]')}{optional}"
    return f"**{text}**" if parameter is marked else text


def _docstring(handler: Callable[..., Any]) -> str:
    """Return the docstring of a command's handler; "" if several commands share the handler."""
    return "" if isinstance(handler, partial) else " ".join((inspect.getdoc(handler) or "").split())


def words(line: str) -> Iterator[tuple[int, int]]:
    at = 0
    for word in line.split():
        begin = line.index(word, at)
        at = begin + len(word)
        yield begin, at
