"""Acts on a bench as data: the lines of a conversation, whoever performs or records them."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Act:
    """One line.  `line` is its number in the file, `controller` the name it begins with, if any."""

    line: int = field(default=0, kw_only=True, compare=False)
    controller: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Comment(Act):
    """Words for the reader."""

    text: str = ""


@dataclass(frozen=True)
class Wait(Act):
    """Time passes."""

    ns: int


@dataclass(frozen=True)
class Say(Act):
    """The host transmits."""

    data: bytes


@dataclass(frozen=True)
class Hear(Act):
    """The host receives.  No data: it has received nothing that was not told."""

    data: bytes


@dataclass(frozen=True)
class Do(Act):
    """Somebody at the machine: a pin driven or released, the power switched."""

    target: str
    value: str


@dataclass(frozen=True)
class Expect(Act):
    """What a pin, an axis or the clock must show."""

    subject: str
    value: str
