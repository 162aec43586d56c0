"""The command language: a command string is an opcode and its parameter bytes (chapter Command Language Syntax).

Numbers are sent most significant byte first; signed ones in two's complement.  Fields know their size and range; what
is short, out of range or has surplus bytes that are not zero does not decode, and the board ignores it.
"""

from dataclasses import dataclass
from enum import Flag, auto
from typing import Any

from axistwin.controllers.commandset import Command, CommandSet, Field

CCW = 0x8000
"""The direction bit of a velocity that is streamed."""
LONGEST = 16
"""Bytes of a command string, and of a message."""


class Accept(Flag):
    """The attributes of a command (chapter Command attributes): they alone decide who is heard when."""

    SINGULAR = auto()  # takes time, and only one can be in progress
    INDEXER = auto()  # valid in indexer mode
    STREAMING = auto()  # valid in the streaming modes
    SEQUENCE = auto()  # may be placed in a sequence buffer
    DURING_SEQUENCE = auto()  # the host may give it while a sequence is being performed
    DURING_STREAMING = auto()  # the host may give it while the streaming buffer is being performed
    DEFINING = auto()  # acts also between D9 and D8
    ENCODER = auto()  # 1811 only


@dataclass(frozen=True)
class Number(Field):
    """A number of `size` bytes."""

    size: int = 1
    signed: bool = False

    def decode(self, data: bytes) -> Any:
        """The value, or None if it is out of range."""
        value = int.from_bytes(data, "big", signed=self.signed)
        return value if self.allows(value) else None

    def encode(self, value: Any) -> bytes:
        """The bytes of a value."""
        return int(value).to_bytes(self.size, "big", signed=self.signed)


@dataclass(frozen=True)
class Ranges(Number):
    """One byte: the velocity range in the upper nibble, the acceleration range in the lower one."""

    def decode(self, data: bytes) -> tuple[int, int] | None:
        """Both ranges, or None if one of them is not defined."""
        velocity, acceleration = divmod(data[0], 0x10)
        return (velocity, acceleration) if velocity <= 5 and acceleration <= 2 else None

    def encode(self, value: tuple[int, int]) -> bytes:
        """Both ranges as one byte."""
        return bytes([value[0] << 4 | value[1]])


@dataclass(frozen=True)
class StreamedVelocity(Number):
    """Two bytes: the most significant bit is the direction, 1 = CCW; the other fifteen are the velocity number."""

    def __str__(self) -> str:
        return f"{self.name} 0…{CCW - 1} {self.unit}, CCW {CCW} more"


@dataclass(frozen=True)
class Switch(Number):
    """One byte: 00 or anything else."""

    def decode(self, data: bytes) -> bool:
        """Whether it is not 00."""
        return data[0] != 0


@dataclass(frozen=True)
class OneOf(Number):
    """One byte of a few."""

    choices: tuple[int, ...] = ()

    def allows(self, value: int) -> bool:
        """Whether it is one of them."""
        return value in self.choices


@dataclass(frozen=True)
class DontCare(Number):
    """Bytes that must be there but mean nothing; a handler does not get them."""


def u8(name: str, low: int = 0, high: int = 0xFF, unit: str = "") -> Number:
    """An unsigned byte."""
    return Number(name, unit, low, high)


def u16(name: str, low: int = 0, high: int = 0xFFFF, unit: str = "") -> Number:
    """Two bytes, unsigned."""
    return Number(name, unit, low, high, size=2)


def u32(name: str, low: int = 0, high: int = 0xFFFF_FFFF, unit: str = "") -> Number:
    """Four bytes, unsigned."""
    return Number(name, unit, low, high, size=4)


def i16(name: str, low: int = -0x8000, high: int = 0x7FFF, unit: str = "") -> Number:
    """Two bytes, signed."""
    return Number(name, unit, low, high, size=2, signed=True)


def i32(name: str, low: int = -0x8000_0000, high: int = 0x7FFF_FFFF, unit: str = "") -> Number:
    """Four bytes, signed."""
    return Number(name, unit, low, high, size=4, signed=True)


@dataclass(frozen=True)
class Opcode(Command):
    """A command of the table; its code is a number from 00h to FFh."""

    @property
    def opcode(self) -> int:
        """The command byte."""
        return int(self.code)

    @property
    def fields(self) -> tuple[Number, ...]:
        """The parameters, as bytes."""
        return tuple(field for field in self.parameters if isinstance(field, Number))

    @property
    def size(self) -> int:
        """How many parameter bytes it requires."""
        return sum(field.size for field in self.fields)

    @property
    def syntax(self) -> str:
        """The opcode in hex and the parameters, with their sizes where they are not one byte."""
        parts = (f.form if f.size == 1 else f"{f.form}[{f.size}]" for f in self.fields)
        return " ".join((f"{self.opcode:02X}", *parts))

    def decode(self, parameters: bytes) -> tuple[Any, ...] | None:
        """The values for the handler, or None: the command is to be ignored."""
        if len(parameters) < self.size or any(parameters[self.size :]):
            return None
        values, at = [], 0
        for field in self.fields:
            value = field.decode(parameters[at : at + field.size])
            at += field.size
            if value is None:
                return None
            if not isinstance(field, DontCare):
                values.append(value)
        return tuple(values)

    def string(self, parameters: bytes) -> bytes:
        """The command as it is kept: without surplus bytes."""
        return bytes([self.opcode]) + parameters[: self.size]


def decode(commands: CommandSet, data: bytes) -> tuple[Opcode, tuple[Any, ...]] | None:
    """A command string as a command of the table and its values; None: nothing that means anything."""
    command = commands.get(data[0]) if data else None
    if not isinstance(command, Opcode):
        return None
    values = command.decode(data[1:])
    return None if values is None else (command, values)
