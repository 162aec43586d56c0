"""Entries of the command table: the valid sources of a command, and the form of the command."""

from dataclasses import dataclass
from enum import Enum, Flag, auto

from axistwin.controllers.commandset import Command


class Accept(Flag):
    """The sources from which a command is accepted."""

    HOST = auto()  # Marks a command that a host may send to a serial port of the controller.
    PROGRAM = auto()  # Marks a command that is valid in a stored program.
    BLOCK = auto()  # Marks a command that only a stored program may contain, e.g. LOOP or a label.
    REMOVED = auto()  # Marks a command that firmware 4.76 no longer has (manual, section 1.3).


class Form(Enum):
    """Kinds of command syntax, each with an example."""

    BARE = "G"
    NUMBER = "GOSUBn"
    LET = "A=exp"
    AFTER = "IF exp"
    ITEMS = "PRINT(items)"
    CALL = "VST(variable,n)"
    VARIABLE = "a=exp"
    ARRAY = "ab[exp]=exp"
    REPORT_VARIABLE = "Ra"
    REPORT_ARRAY = "Rab[exp]"
    OUTPUT = "AOUTp,exp"


@dataclass(frozen=True)
class Instruction(Command):
    """A command; `code` is its keyword with the characters that must follow: `G`, `A=` or `GOSUBn`."""

    form: Form = Form.BARE
    written: str = ""  # Syntax of the command, if it cannot be derived from form and parameters.
    instead: str = ""  # Replacement for a command that has been removed in 4.76.

    @property
    def syntax(self) -> str:
        if self.written:
            return self.written
        code = str(self.code)
        match self.form:
            case Form.LET:
                return f"{code}exp"
            case Form.AFTER:
                return f"{code} exp"
            case _:
                return code
