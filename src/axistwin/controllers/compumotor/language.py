"""The command language: a command string is an opcode and its parameter bytes (chapter Command Language Syntax).

Numbers are sent most significant byte first; signed ones in two's complement.  Fields know their size and range; a
command that is short, out of range or followed by bytes other than 00 does not decode, and the board ignores it.
"""

from dataclasses import dataclass
from enum import Flag, auto
from functools import cached_property, partial
from itertools import accumulate
from typing import Any

from axistwin.controllers.commandset import Command, CommandSet, Field

CCW = 0x8000  # Direction bit of a streamed velocity, set for CCW.
LONGEST = 16  # Maximum number of bytes in a command string, and number of bytes in a message.


class Accept(Flag):
    """The attributes of a command (chapter Command attributes), which decide when a command is performed."""

    SINGULAR = auto()  # The host cannot start a second SINGULAR command, e.g. a move, before the first has ended.
    INDEXER = auto()  # INDEXER marks commands that are valid in indexer mode.
    STREAMING = auto()  # STREAMING marks commands that are valid in the streaming modes.
    SEQUENCE = auto()  # SEQUENCE marks commands that can be stored in a sequence.
    DURING_SEQUENCE = auto()  # DURING_SEQUENCE marks commands that the host may send while a sequence is in progress.
    DURING_STREAMING = auto()  # DURING_STREAMING marks commands that the host may send while a stream is in progress.
    DEFINING = auto()  # DEFINING marks commands that the board performs even while the host defines a sequence.
    ENCODER = auto()  # ENCODER marks commands that exist only on the model 1811.


@dataclass(frozen=True)
class Number(Field):
    """Parameter type: a number of `size` bytes."""

    size: int = 1
    signed: bool = False

    def decode(self, data: bytes) -> Any:
        """Convert parameter bytes to a value; None if the value is out of range."""
        value = int.from_bytes(data, "big", signed=self.signed)
        return value if self.allows(value) else None

    def encode(self, value: Any) -> bytes:
        return int(value).to_bytes(self.size, "big", signed=self.signed)


@dataclass(frozen=True)
class Ranges(Number):
    """Parameter type: one byte with velocity range (upper nibble) and acceleration range (lower nibble)."""

    def decode(self, data: bytes) -> tuple[int, int] | None:
        """Return the velocity and the acceleration range of a byte; None if one of them does not exist."""
        velocity, acceleration = divmod(data[0], 0x10)
        return (velocity, acceleration) if velocity <= 5 and acceleration <= 2 else None

    def encode(self, value: tuple[int, int]) -> bytes:
        return bytes([value[0] << 4 | value[1]])


@dataclass(frozen=True)
class StreamedVelocity(Number):
    """Parameter type: bit 15 is CCW, bits 0 to 14 are the velocity in units of effective clock / 65536."""

    def __str__(self) -> str:
        return f"{self.name} 0…{CCW - 1} {self.unit}, CCW {CCW} more"


@dataclass(frozen=True)
class Switch(Number):
    """Parameter type: one byte, in which 00 means off and any other value means on."""

    def decode(self, data: bytes) -> bool:
        """Return True (on) if the parameter byte is not 00."""
        return data[0] != 0


@dataclass(frozen=True)
class OneOf(Number):
    """Parameter type: one byte for which only a few values are valid, e.g. 1 and 6."""

    choices: tuple[int, ...] = ()

    def allows(self, value: int) -> bool:
        return value in self.choices


@dataclass(frozen=True)
class DontCare(Number):
    """Parameter type: bytes that are required but have no meaning."""


def _number(
    size: int, signed: bool, name: str, low: int | None = None, high: int | None = None, unit: str = ""
) -> Number:
    least, most = (-(1 << 8 * size - 1), (1 << 8 * size - 1) - 1) if signed else (0, (1 << 8 * size) - 1)
    return Number(name, unit, least if low is None else low, most if high is None else high, size=size, signed=signed)


u8, u16, u32 = (partial(_number, size, False) for size in (1, 2, 4))
i16, i32 = (partial(_number, size, True) for size in (2, 4))


@dataclass(frozen=True)
class Opcode(Command):
    """A command of the board.  The opcode of the command is a number from 00h to FFh."""

    @property
    def opcode(self) -> int:
        return int(self.code)

    @cached_property
    def fields(self) -> tuple[Number, ...]:
        return tuple(field for field in self.parameters if isinstance(field, Number))

    @cached_property
    def size(self) -> int:
        return sum(field.size for field in self.fields)

    @cached_property
    def _places(self) -> tuple[tuple[Number, int, int], ...]:
        ends = tuple(accumulate(field.size for field in self.fields))
        return tuple(zip(self.fields, (0, *ends), ends, strict=False))

    @property
    def syntax(self) -> str:
        """The opcode in hex, then the parameters, each with its size if that is not one byte."""
        parts = (f.form if f.size == 1 else f"{f.form}[{f.size}]" for f in self.fields)
        return " ".join((f"{self.opcode:02X}", *parts))

    def decode(self, parameters: bytes) -> tuple[Any, ...] | None:
        """Convert the parameter bytes of a command to values.  Return None if the bytes are invalid."""
        if len(parameters) < self.size or any(parameters[self.size :]):
            return None
        values = []
        for field, begin, end in self._places:
            value = field.decode(parameters[begin:end])
            if value is None:
                return None
            if not isinstance(field, DontCare):
                values.append(value)
        return tuple(values)

    def string(self, parameters: bytes) -> bytes:
        """Return the command string: the opcode and the required parameter bytes."""
        return bytes([self.opcode]) + parameters[: self.size]


def decode(commands: CommandSet, data: bytes) -> tuple[Opcode, tuple[Any, ...]] | None:
    """Return the command and the values in a command string, or None if the string is invalid."""
    command = commands.get(data[0]) if data else None
    if not isinstance(command, Opcode):
        return None
    values = command.decode(data[1:])
    return None if values is None else (command, values)
