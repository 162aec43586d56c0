"""Type of the command tables of all families: parser, dispatcher, checker and listing use the same table."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Flag
from typing import Any

Code = str | int  # The name of a command as a host sends it: a character, a keyword, an opcode.


@dataclass(frozen=True)
class Field:
    """A parameter of a command, with a name, a unit and a range.  Subclasses define the notation."""

    name: str
    unit: str = ""
    low: int | None = None
    high: int | None = None
    optional: bool = False

    def allows(self, value: int) -> bool:
        return (self.low is None or value >= self.low) and (self.high is None or value <= self.high)

    @property
    def form(self) -> str:
        """Notation of the parameter in help texts.  Brackets mean that the parameter is optional."""
        return f"[{self.name}]" if self.optional else self.name

    def __str__(self) -> str:
        span = "" if self.low is None and self.high is None else f" {_or_blank(self.low)}…{_or_blank(self.high)}"
        text = f"{self.name}{span}{' ' + self.unit if self.unit else ''}"
        return f"[{text}]" if self.optional else text


def _or_blank(value: int | None) -> str:
    return "" if value is None else str(value)


@dataclass(frozen=True)
class Command:
    """A command: one line of a command table.

    `accepted`: the controller states in which the command is valid, a `Flag` defined by each family.
    `handler` is None for a command that is not implemented.
    """

    code: Code
    name: str
    chapter: str
    parameters: tuple[Field, ...]
    accepted: Flag
    handler: Callable[..., Any] | None = field(compare=False)

    @property
    def implemented(self) -> bool:
        return self.handler is not None

    @property
    def syntax(self) -> str:
        """Syntax line for users: the code, then the parameters."""
        return " ".join((str(self.code), *(part.form for part in self.parameters)))

    def as_dict(self) -> dict[str, Any]:
        """Return the command as a dictionary, which `axistwin commands --json` prints."""
        return {
            "code": self.code,
            "name": self.name,
            "syntax": self.syntax,
            "parameters": [
                {"name": f.name, "unit": f.unit, "low": f.low, "high": f.high, "optional": f.optional}
                for f in self.parameters
            ],
            "chapter": self.chapter,
            "accepted": [flag.name for flag in type(self.accepted) if flag in self.accepted],
            "implemented": self.implemented,
        }


class CommandSet:
    """A table of commands, in the order of the manual's command summary."""

    def __init__(self, *commands: Command) -> None:
        self._by_code = {command.code: command for command in commands}
        assert len(self._by_code) == len(commands), "a code occurs twice in the table"

    def __iter__(self) -> Iterator[Command]:
        return iter(self._by_code.values())

    def __len__(self) -> int:
        return len(self._by_code)

    def get(self, code: Code) -> Command | None:
        return self._by_code.get(code)

    def with_(self, *commands: Command) -> "CommandSet":
        """Return a copy of the command table in which the given commands are added or replaced."""
        return CommandSet(*{**self._by_code, **{command.code: command for command in commands}}.values())

    def without(self, *codes: Code) -> "CommandSet":
        return CommandSet(*(command for command in self if command.code not in codes))
