"""Language support for `.181x`: commands for an 1810 or 1811, one per line."""

import re
from collections.abc import Callable
from functools import partial

from axistwin.bench.codec import codec_of
from axistwin.controllers.compumotor.checker.program import MODAL, acceptable
from axistwin.controllers.compumotor.checker.texts import SWITCHES, name_of
from axistwin.controllers.compumotor.language import DontCare, Number, OneOf, Opcode, Ranges, Switch
from axistwin.controllers.compumotor.parts.library import Kind
from axistwin.controllers.diagnostics import Session
from axistwin.controllers.product import Product
from axistwin.scenes.diagnostics.checking import read_acts, sessions
from axistwin.ui.editor.answers import Hover, Item, Symbol, explain, item, words

_HEX = re.compile(r"(?:[0-9A-Fa-f]{2})+")
BEGIN_SEQUENCE, END_SEQUENCE = 0xD9, 0xD8
RANGES = [f"{velocity}{acceleration}" for velocity in range(6) for acceleration in range(3)]


class Commands:
    """Language support for the commands of an 1810 or 1811, in `.181x` files and conversations."""

    def __init__(self, made: Product, suffix: str = ".181x") -> None:
        self.made, self.suffix = made, suffix
        self.names = {name_of(command): command for command in made.commands if isinstance(command, Opcode)}

    def hover(self, lines: list[str], line: int, at: int) -> Hover | None:
        return self.hover_at(_command(lines[line - 1]), at)

    def hover_at(self, text: str, at: int, offset: int = 0) -> Hover | None:
        """Return a command's meaning, with the parameter at `at` emphasised; `offset`: the command's column."""
        listed = list(words(text))
        here = next((number for number, (begin, end) in enumerate(listed) if begin <= at <= end), None)
        command = self._first_command(text)
        if here is None or command is None:
            return None
        begin, end = listed[here]
        return Hover(explain(command, self._parameter(command, text, here)), offset + begin, offset + end)

    def complete(self, lines: list[str], line: int, at: int) -> list[Item]:
        text = lines[line - 1][:at]
        if ";" in text or text.lstrip().startswith(("+", "!")):
            return []
        return self.complete_at(text, partial(self._session, lines[: line - 1]))

    def complete_at(self, text: str, session: Callable[[], Session]) -> list[Item]:
        """Return the completions for an incomplete command.  `session` returns the commands that were sent before."""
        given = text.split()
        number = len(given) - (not text.endswith((" ", "\t")) and bool(given))
        if number == 0:
            return [item(command, name_of(command)) for command in acceptable(self.made.commands, session())]
        command = self.names.get(given[0])
        fields = _written(command) if command is not None else []
        return _values(fields[number - 1]) if number <= len(fields) else []

    def symbols(self, lines: list[str]) -> list[Symbol]:
        found: list[Symbol] = []
        defining: tuple[int, str, list[Symbol]] | None = None
        for number, line in enumerate(lines, start=1):
            text = _command(line)
            command = self._first_command(text)
            if command is None:
                continue
            whole = _symbol(name_of(command), "step", number, text)
            if command.opcode == BEGIN_SEQUENCE:
                defining = number, f"sequence {' '.join(text.split()[1:2])}", []
            elif defining is not None and command.opcode == END_SEQUENCE:
                found.append(_sequence(*defining, (number, len(line) + 1)))
                defining = None
            elif defining is not None:
                defining[2].append(whole)
            elif command.opcode in tuple(Kind):
                found.append(_symbol(f"move {' '.join(text.split()[1:2])}", "move", number, text, command.name))
        if defining is not None:
            found.append(_sequence(*defining, (len(lines), len(lines[-1]) + 1)))
        return found

    def is_modal(self, line: str) -> bool:
        """True for a modal command or an action: it can change which commands the board accepts next."""
        text = line.partition(";")[0]
        command = self._first_command(text)
        return text.lstrip().startswith("!") or (command is not None and command.opcode in MODAL)

    def _first_command(self, text: str) -> Opcode | None:
        first = (text.split() or [""])[0]
        if first in self.names:
            return self.names[first]
        found = self.made.commands.get(int(first[:2], 16)) if _HEX.fullmatch(first) else None
        return found if isinstance(found, Opcode) else None

    def _parameter(self, command: Opcode, text: str, here: int) -> Number | None:
        """Return the parameter that the word with index `here` contains; a hex word can contain several."""
        given = text.split()
        if given[0] in self.names:
            fields = _written(command)
            return fields[here - 1] if 0 < here <= len(fields) else None
        byte = sum(len(word) // 2 for word in given[:here]) - 1
        for each in command.fields:
            if 0 <= byte < each.size:
                return each
            byte -= each.size
        return None

    def _session(self, lines: list[str]) -> Session:
        codec = codec_of(self.made)
        lines = [line if self.is_modal(line) else "" for line in lines]
        acts, _ = read_acts(lines, self.suffix, codec)
        listed = [session for host in sessions(acts, lines, self.suffix, codec) for session in host]
        return listed[-1] if listed else Session(())


def _command(line: str) -> str:
    text = line.partition(";")[0].rstrip()
    return "" if text.lstrip().startswith(("+", "!")) else text


def _written(command: Opcode) -> list[Number]:
    return [each for each in command.fields if not isinstance(each, DontCare)]


def _values(parameter: Number) -> list[Item]:
    if isinstance(parameter, Switch):
        listed = list(SWITCHES)
    elif isinstance(parameter, Ranges):
        listed = RANGES
    elif isinstance(parameter, OneOf):
        listed = [str(choice) for choice in parameter.choices]
    else:
        listed = []
    return [Item(value, "value", str(parameter)) for value in listed]


def _symbol(name: str, kind: str, line: int, text: str, detail: str = "") -> Symbol:
    begin = len(text) - len(text.lstrip())
    return Symbol(name, kind, (line, begin + 1), (line, len(text) + 1), detail)


def _sequence(line: int, name: str, steps: list[Symbol], end: tuple[int, int]) -> Symbol:
    return Symbol(name, "sequence", (line, 1), end, f"{len(steps)} commands", steps)
