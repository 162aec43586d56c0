"""Base class of the tutor's explanations for one controller, with the explanations that all families share."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from axistwin.bench import Controller, show_controls
from axistwin.bench.acts import Act
from axistwin.controllers.commandset import Command
from axistwin.controllers.diagnostics import Diagnostic
from axistwin.controllers.front import Lamp, Reading, Word
from axistwin.ui.teaching.remedies import Remedies

MOST_DEVIATION = 20  # The reciprocal of the deviation of a baud rate that still lets characters arrive whole, 5 %.
Refused = Callable[[bytes], Sequence[Diagnostic]]  # Returns the diagnostics of a line that the host would send now.


@dataclass(frozen=True)
class Reason:
    """A cause that prevents a move, with its remedy."""

    text: str
    remedy: str = ""

    def __str__(self) -> str:
        return f"{self.text}: {self.remedy}" if self.remedy else self.text


@dataclass(frozen=True)
class Term:
    """A command that a host may send, with its meaning and its notation."""

    text: str
    meaning: str
    syntax: str


class Guide(ABC):
    """Explains one controller to the user; each controller family has a subclass."""

    def __init__(self, controller: Controller, refused: Refused) -> None:
        self.controller, self.refused = controller, refused
        self.remedies = Remedies()

    @property
    @abstractmethod
    def ready(self) -> bool: ...

    @abstractmethod
    def reasons(self) -> Iterator[Reason]:
        """Yield the causes that prevent a move.  The first cause must be corrected first."""

    @abstractmethod
    def answer(self, request: bytes, reply: bytes) -> str:
        """Return the meaning of a reply to the last request, or "" if the reply needs no explanation."""

    @abstractmethod
    def number(self, value: int) -> Iterator[str]:
        """Yield all meanings that a number can have in a reply of the controller."""

    @abstractmethod
    def command(self, text: str) -> Iterator[str]: ...

    @abstractmethod
    def initialisation(self) -> Iterator[Act]:
        """Yield the actions that make the controller ready; each must be performed before the next."""

    def notes(self, line: bytes) -> Iterator[str]:  # noqa: ARG002  # subclasses use it
        """Yield notes about a line that is valid but may surprise a new user."""
        yield from ()

    suggestions: tuple[tuple[str, str], ...] = ()  # Lines to type when moves are possible, with their meanings.
    accepted: tuple[bytes, ...] = ()  # Beginnings of the lines that the controller obeys before it is ready.
    single_characters = False  # True if each command is one character, and commands follow each other without blanks.

    def words(self) -> list[Term]:
        return [
            Term(str(command.code), command.name, show_controls(command.syntax))
            for command in self.controller.product.commands
            if command.implemented and not str(command.code).isspace()
        ]

    # Explanations that are the same for all controller families

    def restored(self, name: str, level: str, *, then: str = "", away: str = "") -> str:
        """Return advice about an input that prevents motion, e.g. "type  :drive limit_plus high".

        `level`: the level that permits motion, "high" or "low".  `away`: a move that leaves a limit switch.  The input
        is never forced while a machine is connected to the input.
        """
        pin = self.controller.pins[name]
        if pin.held:
            return self.remedies.mend(name)
        if pin.driven and (pin.wired or pin.undriven is (level == "high")):
            return self.remedies.release(name) + then
        if away or pin.wired:
            return away or f"{name} is wired: find what sets it {'low' if level == 'high' else 'high'}"
        return self.remedies.drive(name, level) + then

    def line(self) -> Iterator[Reason]:
        """Yield the reason why no character arrives whole: another baud rate at the host, on a line of its own."""
        own, port = self.controller.line_format, self.controller.ports.get(self.controller.name)
        if own is None or port is None:
            return
        rate = port.host.format.baudrate
        if MOST_DEVIATION * abs(rate - own.baudrate) > own.baudrate:
            yield Reason(f"the host sends at {rate} baud, not at {own.baudrate}", f"type  :drive line {own}")

    def value(self, source: str) -> int | str:
        """Return the value of a register, or the level of a terminal as 0 or 1."""
        if source in self.controller.registers:
            return self.controller.registers[source].read()
        return int(self.controller.pins[source].level)

    def lamps(self, source: str) -> list[Lamp]:
        """Return the lamps of the front panel that represent the bits of a register."""
        lamps = (item for group in self.controller.product.front for item in group.items if isinstance(item, Lamp))
        return [lamp for lamp in lamps if lamp.source == source and lamp.bit is not None]

    def bits(self, source: str, value: int, none: str = "no bit is set") -> str:
        """Return the meaning of each bit that is 1 in a register."""
        lit = [lamp for lamp in self.lamps(source) if lamp.bit is not None and value >> lamp.bit & 1]
        return "; ".join(self._lamp(lamp, one=len(lit) == 1) for lamp in lit) or none

    @staticmethod
    def _lamp(lamp: Lamp, one: bool) -> str:
        return f"{lamp.label} {lamp.name}" + (f" ({lamp.doc.strip().rstrip('.')})" if one and lamp.doc else "")

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

    @property
    def ready(self) -> bool:
        return self.controller.powered

    def reasons(self) -> Iterator[Reason]:
        if not self.controller.powered:
            yield Reason("the power is off", self.remedies.power("on"))
        elif self.controller.hint:
            yield Reason(self.controller.hint)
        else:
            yield from self.line()

    def answer(self, request: bytes, reply: bytes) -> str:  # noqa: ARG002
        return ""

    def number(self, value: int) -> Iterator[str]:  # noqa: ARG002
        yield from ()

    def command(self, text: str) -> Iterator[str]:
        for command in self.controller.product.commands:
            if str(command.code).lower() == text.lower():
                yield described(command)

    def initialisation(self) -> Iterator[Act]:
        yield from ()


def _whole(text: str) -> int | None:
    return int(text) if text.lstrip("-").isdecimal() else None


def described(command: Command) -> str:
    code = f"{command.code:02X}" if isinstance(command.code, int) else show_controls(command.code)
    syntax = show_controls(command.syntax)
    notation = f"   {syntax}" if syntax != code else ""
    parameters = f"   {', '.join(map(str, command.parameters))}" if command.parameters else ""
    return f"{code}  {command.name}{notation}{parameters}   (manual: {command.chapter})"
