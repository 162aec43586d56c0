"""What an entry of the command table says beyond what all families share: who may give a command, and its form."""

from dataclasses import dataclass
from enum import Enum, Flag, auto

from axistwin.controllers.commandset import Command


class Accept(Flag):
    """From where a command is accepted."""

    HOST = auto()  # over a communication channel
    PROGRAM = auto()  # in the stored program
    BLOCK = auto()  # a label or a part of a block: in the stored program, and nothing else
    REMOVED = auto()  # from nowhere: removed in 4.76 (1.3)


class Form(Enum):
    """How a command is written."""

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
    """A line of the command table.  `code` is the keyword with what follows it at once: `GOSUBn`, `A=`, `PRINT()`."""

    form: Form = Form.BARE
    written: str = ""
    """How it is written, where the form and the parameters do not tell."""
    instead: str = ""
    """What replaces a command that has been removed."""

    @property
    def syntax(self) -> str:
        """How it is written."""
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
