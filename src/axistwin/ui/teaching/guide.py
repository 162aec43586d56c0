"""Base class of the tutor's explanations for one controller, with the explanations that all families share."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

from axistwin.bench import show_controls
from axistwin.controllers.commandset import Command
from axistwin.controllers.front import Reading, Word
from axistwin.scenes.reasons.reasons import Reasons


@dataclass(frozen=True)
class Term:
    """A command that a host may send, with its meaning and its notation."""

    text: str
    meaning: str
    syntax: str


class Guide(Reasons, ABC):
    """Explains one controller to the user; each controller family has a subclass."""

    @abstractmethod
    def answer(self, request: bytes, reply: bytes) -> str:
        """Return the meaning of a reply to the last request, or "" if the reply needs no explanation."""

    @abstractmethod
    def number(self, value: int) -> Iterator[str]:
        """Yield all meanings that a number can have in a reply of the controller."""

    @abstractmethod
    def command(self, text: str) -> Iterator[str]: ...

    def notes(self, line: bytes) -> Iterator[str]:  # noqa: ARG002  # subclasses use it
        """Yield notes about a line that is valid but may surprise a new user."""
        yield from ()

    accepted: tuple[bytes, ...] = ()  # Beginnings of the lines that the controller obeys before it is ready.
    single_characters = False  # True if each command is one character, and commands follow each other without blanks.

    def words(self) -> list[Term]:
        return [
            Term(str(command.code), command.name, show_controls(command.syntax))
            for command in self.controller.product.commands
            if command.implemented and not str(command.code).isspace()
        ]

    def shown(self, source: str, text: str) -> str:
        """Return the text that the front panel shows for a reply, e.g. a value with its unit."""
        for group in self.controller.product.front:
            for item in group.items:
                if isinstance(item, Word) and item.source == source:
                    found = [w for v, w in item.words.items() if str(v) == text or w.startswith(f"{text} ")]
                    return found[0] if found else ""
                if isinstance(item, Reading) and item.source == source:
                    return f"{item.name}: {item.shows(_whole(text))} {item.unit}".rstrip()
        return ""


class PlainGuide(Guide):
    """Explains a controller of another package: its commands, its power, and the hint that it gives itself."""

    def answer(self, request: bytes, reply: bytes) -> str:  # noqa: ARG002
        return ""

    def number(self, value: int) -> Iterator[str]:  # noqa: ARG002
        yield from ()

    def command(self, text: str) -> Iterator[str]:
        for command in self.controller.product.commands:
            if str(command.code).lower() == text.lower():
                yield described(command)


def _whole(text: str) -> int | None:
    return int(text) if text.lstrip("-").isdecimal() else None


def described(command: Command) -> str:
    code = f"{command.code:02X}" if isinstance(command.code, int) else show_controls(command.code)
    syntax = show_controls(command.syntax)
    notation = f"   {syntax}" if syntax != code else ""
    parameters = f"   {', '.join(map(str, command.parameters))}" if command.parameters else ""
    return f"{code}  {command.name}{notation}{parameters}   (manual: {command.chapter})"
