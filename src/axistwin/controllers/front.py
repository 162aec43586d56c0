"""The front of a controller as data: what it shows by lamps, by words and by numbers, group by group.

Whoever draws it finds the level of a terminal or the value of a register by name, and needs to know nothing else.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any


class Tone(Enum):
    """What it means that a lamp is lit."""

    PLAIN = "on"
    WARNING = "warning"
    FAULT = "fault"


@dataclass(frozen=True)
class Lamp:
    """A terminal or a bit of a register, which is lit or not."""

    label: str
    """What is written beside it: the letter or number of the manual."""
    name: str
    """What that is, in a few words."""
    source: str
    """A terminal or a register."""
    bit: int | None = None
    """Which bit of the register, from 0; None: it is lit by any value but 0."""
    lit: bool = True
    """At which level it is lit."""
    tone: Tone = Tone.PLAIN
    doc: str = ""
    """What else one should know."""

    def shows(self, value: int | None) -> bool:
        """Whether it is lit by this level or value.  Without power (None) it is dark."""
        if value is None:
            return False
        on = value != 0 if self.bit is None else value >> self.bit & 1 == 1
        return on is self.lit


@dataclass(frozen=True)
class Word:
    """A register that is told in words."""

    label: str
    name: str
    source: str
    words: Mapping[Any, str] = field(default_factory=dict)
    """By value; what is not among them is told as it is."""
    tones: Mapping[Any, Tone] = field(default_factory=dict)
    doc: str = ""
    unpowered: str = ""
    """What is told without power."""

    def shows(self, value: int | str | None) -> str:
        """This value; None: there is no power."""
        return self.unpowered if value is None else self.words.get(value, str(value))


@dataclass(frozen=True)
class Reading:
    """A register that is a quantity: its value times `scale`, in a unit."""

    label: str
    name: str
    source: str
    unit: str = ""
    scale: float = 1
    digits: int = 0
    """Behind the decimal point."""
    doc: str = ""

    def shows(self, value: int | None) -> str:
        """This value, without its unit.  Without power (None) there is none."""
        return "" if value is None else f"{value * self.scale:.{self.digits}f}"


Item = Lamp | Word | Reading


@dataclass(frozen=True)
class Group:
    """What belongs together, and where the manual tells of it."""

    title: str
    chapter: str
    items: tuple[Item, ...]
    row: bool = False
    """Whether its lamps stand in one row, as the bits of a byte do."""

    @property
    def sources(self) -> Iterator[str]:
        """The terminals and registers that one has to look at."""
        return iter(dict.fromkeys(item.source for item in self.items))
