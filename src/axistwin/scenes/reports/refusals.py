"""Find the messages of a run that contain lines refused by a controller.

The checkers find the refused lines in the programs.  This module finds the messages in which these lines were sent.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from axistwin.bench import Bench, endpoints
from axistwin.controllers.diagnostics import Diagnostic, Sent
from axistwin.controllers.product import Product
from axistwin.scenes.diagnostics.checking import HostProgram
from axistwin.scenes.reports.run_record import Message

STORED = ".sms"


@dataclass(frozen=True)
class RefusedLine:
    """A refused line; `message`: the host's message with it, None for a line of a stored program."""

    file: str
    error: Diagnostic
    message: Message | None = None

    @property
    def words(self) -> str:
        """Text about a refused command, e.g. `! DP101 unknown character 'x'  (a.if1:2:1)`."""
        return f"! {self.error.code} {self.error.message}  ({self.file}:{self.error.line}:{self.error.column})"


def models_at(bench: Bench) -> dict[str, Product]:
    """Return the product at each endpoint of a bench, by name; "" is also a name of a single endpoint."""
    found = {name: controller.product.with_options(controller.given) for name, controller in bench.controllers.items()}
    found |= {f"{name}.rs485": made for name, made in found.items()}
    found |= {name: bench.lines[name].motors[0].product for name in bench.lines}
    reached = endpoints.names(bench)
    return found | ({"": found[reached[0]]} if len(reached) == 1 else {})


def refusals(said: Iterable[Message], programs: Sequence[HostProgram]) -> list[RefusedLine]:
    """Return all refused commands and program lines: the error, and the host's message with it."""
    senders = [_Sender(program) for program in programs if program.suffix != STORED and program.errors]
    stored = [RefusedLine(p.file, error) for p in programs if p.suffix == STORED for error in p.errors]
    heard = [message for message in said if message.by_host] if senders else []
    several = {message.controller for message in heard}
    found = [
        RefusedLine(sender.program.file, error, message)
        for message in heard
        for sender in senders
        if sender.program.endpoint in (message.controller, *([""] if len(several) == 1 else []))
        for error in sender.errors_in(bytes(message.data))
    ]
    return stored + found


class _Sender:
    def __init__(self, program: HostProgram) -> None:
        self.program = program
        characters = [sent for session in program.sessions for sent in session.characters]
        self._data, self._at = bytes(sent.byte for sent in characters), 0
        on_line: dict[int, list[int]] = {}
        for index, sent in enumerate(characters):
            on_line.setdefault(sent.line, []).append(index)
        self._errors = program.errors
        self._begins = [_index(error, characters, on_line[error.line]) for error in self._errors]
        self._in_greeting = program.suffix == ".if1"
        """True until the host has sent the data format, which is not part of the program."""

    def errors_in(self, data: bytes) -> list[Diagnostic]:
        """Return the errors in a message from the host, e.g. an unknown command.

        The messages must be passed in the order in which the host has sent the messages.  An error belongs to the
        message in which the error begins.  If the message is not part of the program, the list is empty.
        """
        if self._in_greeting:
            self._in_greeting = not data.endswith(b"\r")
            return []
        if not self._data.startswith(data, self._at):
            return []
        begin, self._at = self._at, self._at + len(data)
        return [error for error, index in zip(self._errors, self._begins, strict=True) if begin <= index < self._at]


def _index(error: Diagnostic, characters: Sequence[Sent], on_line: Sequence[int]) -> int:
    return next((index for index in on_line if characters[index].column >= error.column), on_line[-1])
