"""The front panel of a controller as data: lamps, words and readings, in groups.

A display reads terminals and registers by name, and depends on nothing else in the controller.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple


class Tone(Enum):
    """Meaning of a lamp that is lit: normal state, warning or fault."""

    PLAIN = "on"
    WARNING = "warning"
    FAULT = "fault"


@dataclass(frozen=True)
class _Item:
    label: str  # Letter or number of the item in the manual.
    name: str  # A short description of the item.
    source: str  # The name of a terminal or a register.


@dataclass(frozen=True)
class Lamp(_Item):
    """A lamp that indicates the level of a terminal or one bit of a register."""

    bit: int | None = None  # Number of the bit in the register, from 0; None: any value but 0 lights the lamp.
    lit: bool = True  # The level at which the lamp is lit.
    tone: Tone = Tone.PLAIN
    doc: str = ""

    def shows(self, value: int | None) -> bool:
        """Return True if this level or value lights the lamp.  Without power (None) the lamp is dark."""
        if value is None:
            return False
        on = value != 0 if self.bit is None else value >> self.bit & 1 == 1
        return on is self.lit


@dataclass(frozen=True)
class Word(_Item):
    """A register whose values are shown as words."""

    words: Mapping[Any, str] = field(default_factory=dict)  # Words by value; other values are shown as numbers.
    tones: Mapping[Any, Tone] = field(default_factory=dict)
    doc: str = ""
    unpowered: str = ""  # Text that is shown while the power is off.

    def shows(self, value: int | str | None) -> str:
        """Return the text for this value; None: no power."""
        return self.unpowered if value is None else self.words.get(value, str(value))


@dataclass(frozen=True)
class Reading(_Item):
    """A register shown as a quantity: its value times `scale`, in a unit."""

    unit: str = ""
    scale: float = 1
    digits: int = 0
    doc: str = ""

    def shows(self, value: int | None) -> str:
        """Return the text for this value, without its unit; empty without power (None)."""
        return "" if value is None else f"{value * self.scale:.{self.digits}f}"


Item = Lamp | Word | Reading


@dataclass(frozen=True)
class Group:
    """A group of lamps and registers on the front panel, described in one chapter of the manual."""

    title: str
    chapter: str
    items: tuple[Item, ...]
    row: bool = False  # True if the lamps are in one row, like the bits of a byte.

    @property
    def sources(self) -> Iterator[str]:
        return iter(dict.fromkeys(item.source for item in self.items))


class Status(NamedTuple):
    """A status register of a device: what its bits mean, from 0, and its section in the manual."""

    bits: Mapping[int, str]
    section: str
    restless: bool
    text: bool


def front_of(registers: Mapping[str, Status], pins: Iterable[str]) -> tuple[Group, ...]:
    """Return a front panel: each register, bit by bit if its bits have meanings, and the terminals."""
    groups = []
    for name, status in registers.items():
        title = name.replace("_", " ")
        lamps = tuple(Lamp(str(bit), words, name, bit) for bit, words in sorted(status.bits.items()))
        groups.append(Group(title, status.section, lamps or (Word(name, title, name),)))
    terminals = tuple(Lamp(name, name, name) for name in pins)
    return (*groups, Group("Terminals", "", terminals)) if terminals else tuple(groups)
