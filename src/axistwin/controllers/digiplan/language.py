"""Parser of the command language: converts the text of a message into steps, or into problems with their places.

The interface sets a fault bit for a problem; the checker reports the problem to the user.  Both use this parser.
Spaces are ignored.  A message is carried out only after all of it has been parsed.
"""

import re
from dataclasses import dataclass, field
from enum import Flag, IntEnum, auto
from functools import cached_property
from typing import Any

from axistwin.controllers.commandset import Command, CommandSet, Field
from axistwin.controllers.diagnostics import Rule
from axistwin.controllers.digiplan import rules
from axistwin.controllers.digiplan.step import Fault, Problem, Step
from axistwin.core.numbers import HIGHEST, NumberError, clipped, whole

MOST_STEPS = 63
LONGEST_MESSAGE = 8192
"""Largest number of characters in a message from the host; the interface drops further characters.

Every valid sequence is shorter.
"""
CANCEL = "#"
OUT_OF_RANGE = (rules.RANGE, rules.TOO_MANY, rules.REPEAT)
NUMBER, SIGNS = frozenset("0123456789,"), frozenset("+-")


class Accept(Flag):
    """Conditions under which a command is allowed, e.g. only during initialisation."""

    DIRECT = auto()  # The command is allowed in a direct message, which is executed immediately.
    STEP = auto()  # The command is allowed in a step of a sequence.
    ALONE = auto()  # Flag of a command that must be the only command in its message, e.g. `#` (cancel).
    LOCKED = auto()  # The command is allowed even while the interface is locked, e.g. `]`, which ends the lock.
    REQUEST = auto()  # The command is a status request, e.g. `E` (busy status).
    SETUP = auto()  # The command is allowed only during initialisation.
    WRITTEN = auto()  # The character is a sign or punctuation, not a command, e.g. the minus sign in `X-100`.


class Order(IntEnum):
    """Order of commands in a message or step (chapter Combining inputs and outputs with move instructions)."""

    ANY, HIGH, LOW, ABORT, MOVE, SET, RESET, PULSE, REPEAT = range(9)  # A message may contain several MOVE commands.


@dataclass(frozen=True)
class Instruction(Command):
    """A command that consists of one character."""

    order: Order = Order.ANY  # Within a message or a sequence step, a command with a lower value must come first.
    form: str = ""  # Syntax, if it cannot be derived from the parameters.

    @property
    def syntax(self) -> str:
        """Syntax as printed in help texts; parts in brackets are optional."""
        parts = "".join(part.form for part in self.parameters)
        return self.form or f"{self.code}{' ' if parts[:1].isalpha() else ''}{parts}"

    @cached_property
    def pattern(self) -> re.Pattern[str]:
        """Regular expression that matches the parameters after the command character."""
        return re.compile("".join(part.pattern for part in self.parameters if isinstance(part, Written)))


@dataclass(frozen=True)
class Written(Field):
    """One parameter of a command, e.g. the distance in `X100`.  `pattern`: an expression with one group."""

    pattern: str = r"(\d+)"

    @property
    def form(self) -> str:
        """Syntax of the parameter, with the comma before it if there is one."""
        text = f"{',' if ',' in self.pattern else ''}{self.name}"
        return f"[{text}]" if self.optional else text

    def read(self, text: str | None) -> tuple[Any, bool]:
        """Read the value of a parameter.  Return the value, and whether the value is within the range."""
        if not text:
            return None, True
        try:
            value = whole(text)
        except NumberError:
            return HIGHEST, False
        return value, self.allows(value)


@dataclass(frozen=True)
class Direction(Written):
    """Parameter type: a direction, `+` or `-`; no sign means `+`."""

    pattern: str = r"([+-]?)"

    @property
    def form(self) -> str:
        return "[+|-]"

    def read(self, text: str | None) -> tuple[int, bool]:
        """Return +1 or -1; always in range."""
        return (-1 if text == "-" else +1), True


@dataclass(frozen=True)
class Lines(Written):
    """Parameter type: the numbers of one or more inputs or outputs, one digit each."""

    def read(self, text: str | None) -> tuple[tuple[int, ...], bool]:
        """Return the numbers of the lines, and True if all are within the range."""
        digits = tuple(int(digit) for digit in text or "")
        return digits, all(self.allows(digit) for digit in digits)


@dataclass
class Message:
    """A parsed message: a single command, a direct message, or a sequence with its steps."""

    text: str
    problems: list[Problem] = field(default_factory=list)
    alone: Command | None = None
    steps: list[Step] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    sequence: bool = False
    start: bool = False  # True if the message ends in `$`.


def parse(text: str, commands: CommandSet) -> Message:
    """Parse a message without its terminator.  A `#` cancels the characters before it."""
    return _Reader(text, commands).read()


class _Reader:
    def __init__(self, text: str, commands: CommandSet) -> None:
        self.commands = commands
        self.message = Message(text)
        self.text = text.replace(" ", "")
        self.places = [place for place, character in enumerate(text) if character != " "] + [len(text)]
        self.at = 0
        self.begins: list[int] = []  # Start of each sequence step, as an index in `self.text`.

    def read(self) -> Message:
        self.at = self.text.rfind(CANCEL) if CANCEL in self.text else 0
        if self.at < len(self.text) and self._read_alone():
            return self.message
        self.message.start = self.text.endswith("$")
        end = len(self.text) - self.message.start
        self.message.sequence = self.text.startswith(":")
        if self.message.sequence:
            self._read_sequence(end)
        elif self.text:
            self._read_step(end)
            step = self.message.steps[0]
            if (step.high or step.low) and not step.major:
                self._wrong(rules.WAITS, "H and L need a move in the same message, e.g. H1X100$", 0)
        return self.message

    def _wrong(self, rule: Rule, message: str, at: int, end: int = 0, chapter: str = "") -> None:
        fault = Fault.RANGE if rule in OUT_OF_RANGE else Fault.DATA
        behind = self.places[end - 1] + 1 if end > at else 0
        problem = Problem(rule, fault, self.places[at], message, chapter or rule.chapter, end=behind)
        self.message.problems.append(problem)

    def _read_alone(self) -> bool:
        command = self.commands.get(self.text[self.at])
        if command is None or Accept.ALONE not in command.accepted:
            return False
        self.message.alone = command
        if self.at + 1 < len(self.text):
            self._must_be_alone(command, self.at + 1, len(self.text))
        return True

    def _read_sequence(self, end: int) -> None:
        """Parse a sequence `:step:step: … :$`; without a step, `:$` runs the stored sequence again."""
        if not self.message.start or not self.text[:end].endswith(":"):
            self._wrong(rules.SEQUENCE_END, "a sequence ends in :$", len(self.text))
        while self.at < end:
            self.at += 1  # skips the colon
            colon = self.text.find(":", self.at, end)
            stop = end if colon < 0 else colon
            if stop == self.at and stop >= end - 1:
                break  # The text ":$" or "::$" ends a sequence.
            self._read_step(stop)
            self.at = stop
            self._check_sequence_step()
        if len(self.message.steps) > MOST_STEPS:
            message = f"{len(self.message.steps)} steps: a sequence has {MOST_STEPS} at most"
            self._wrong(rules.TOO_MANY, message, self.begins[MOST_STEPS], end)

    def _check_sequence_step(self) -> None:
        step, number, begin = self.message.steps[-1], len(self.message.steps), self.begins[-1]
        if step == Step() and begin == self.at:
            self._wrong(rules.STEP_MISSING, "a step is missing between two colons", begin)
        if step.repeat and step.repeat[1] > number:
            message = f"repeat from step {step.repeat[1]}: expected a step from 1 to {number}"
            self._wrong(rules.REPEAT, message, begin, self.at)

    def _read_step(self, end: int) -> None:
        step, seen, wrong_before = Step(), Order.ANY, len(self.message.problems)
        self.message.steps.append(step)
        self.message.places.append(self.places[self.at])
        self.begins.append(self.at)
        while self.at < end:
            begin = self.at
            command = self.commands.get(self.text[begin])
            self.at += 1
            if not isinstance(command, Instruction):
                self._read_unknown(begin, end)
            elif self._may_stand_here(command, begin):
                seen = self._check_order(command, seen, begin)
                self._read_parameters(command, step, begin, end)
            else:
                self._skip_number(end)
        if len(self.message.problems) == wrong_before:
            self._check_step(step)

    def _read_unknown(self, begin: int, end: int) -> None:
        if self.text[begin] in NUMBER:
            self._skip_number(end)
            self._wrong(rules.LOST_NUMBER, self._lost_number(begin), begin, self.at)
            return
        while self.at < end and self.text[self.at] not in NUMBER and self.commands.get(self.text[self.at]) is None:
            self.at += 1
        unknown = self.text[begin : self.at]
        hint = ": commands are upper case" if all(map(self.commands.get, unknown.upper())) else ""
        message = f"unknown character{'s'[: len(unknown) - 1]} {unknown!r}{hint}"
        self._wrong(rules.UNKNOWN, message, begin, self.at)
        self._skip_number(end)

    def _lost_number(self, begin: int) -> str:
        message = f"{self.text[begin : self.at]} belongs to no command"
        before = self.commands.get(self.text[begin - 1]) if begin > self.begins[-1] else None
        if before is None:
            return message
        takes = " ".join(map(str, before.parameters)) or "no number"
        return f"{message}: {before.code} ({before.name}) takes {takes}"

    def _skip_number(self, end: int) -> None:
        """Skip the number after a wrong command, so that the checker reports only one problem."""
        while self.at < end and self.text[self.at] in NUMBER | SIGNS:
            self.at += 1

    def _may_stand_here(self, command: Command, at: int) -> bool:
        here = Accept.STEP if self.message.sequence else Accept.DIRECT
        alone = Accept.ALONE in command.accepted
        if here in command.accepted and not alone:
            return True
        name = f"{command.code} ({command.name})"
        if Accept.SETUP in command.accepted:
            self._wrong(rules.SETUP, f"{name} is for initialisation only", at, chapter=command.chapter)
        elif alone:
            self._must_be_alone(command, at)
        elif Accept.WRITTEN in command.accepted:
            self._wrong(rules.MISPLACED, f"{name} is not valid here", at, chapter=command.chapter)
        else:
            where = "in a sequence" if self.message.sequence else "in a direct message"
            self._wrong(rules.NOT_IN_THIS_KIND, f"{name} is not allowed {where}", at, chapter=command.chapter)
        return False

    def _must_be_alone(self, command: Command, at: int, end: int = 0) -> None:
        message = f"{command.code} ({command.name}) must be the only command in its message"
        self._wrong(rules.ALONE, message, at, end, command.chapter)

    def _check_order(self, command: Instruction, seen: Order, at: int) -> Order:
        order = command.order
        if order is Order.ANY:
            return seen
        wrong = order < seen or (order == seen != Order.MOVE)
        wrong |= order is Order.PULSE and seen in (Order.SET, Order.RESET)
        wrong |= seen is Order.ABORT and order is not Order.REPEAT
        wrong |= order is Order.REPEAT and seen > Order.ABORT
        if wrong:
            message = f"{command.code} ({command.name}) cannot follow here: the order is H L, move, S R or P; H L A ="
            self._wrong(rules.ORDER, message, at)
        return max(order, seen)

    def _read_parameters(self, command: Instruction, step: Step, begin: int, end: int) -> None:
        match = command.pattern.match(self.text, self.at, end)
        if match is None:
            wanted = " ".join(str(part) for part in command.parameters)
            message = f"{command.code} ({command.name}) needs {wanted}"
            self._wrong(rules.NEEDS, message, self.at, chapter=command.chapter)
            self._skip_number(end)
            return
        values = []
        for group, part in enumerate(command.parameters, 1):
            assert isinstance(part, Written)
            value, in_range = part.read(match[group])
            values.append(value)
            if not in_range:
                message = f"{clipped(match[group])} is out of range: {part}"
                self._wrong(rules.RANGE, message, *match.span(group), command.chapter)
        self.at = match.end()
        if self.at < end and self.text[self.at] in NUMBER:
            return  # The method `_read_step` reports the surplus text after a parameter, e.g. ",5" in `X100,5`.
        assert command.handler is not None
        if complaint := command.handler(step, *values):
            self._wrong(rules.TWICE, complaint, begin, self.at, command.chapter)
        for name in step.settings.keys() - step.places.keys():
            step.places[name] = self.places[begin]

    def _check_step(self, step: Step) -> None:
        begin = self.begins[-1]
        if step.interpolated and not step.minor:
            self._wrong(rules.MINOR, "the minor axis is missing after /", begin, self.at)
        if step.corrected and (step.interpolated or step.run):
            self._wrong(rules.CORRECTION, "B corrects an index on its own axis only", begin, self.at)
        if step.hand_over and step != Step(hand_over=True):
            self._wrong(rules.CONTROL_ALONE, "% must be the only command in its step", begin, self.at)


def written(step: Step) -> None:
    """Do nothing, because the character is parsed together with another command."""
