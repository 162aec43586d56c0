"""Actions and expectations on a bench as data: the lines of a conversation."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Act:
    """One line.  `line` is its number in the file, `controller` the name at its beginning, if any."""

    line: int = field(default=0, kw_only=True, compare=False)
    controller: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Comment(Act):
    """A comment for the reader."""

    text: str = ""


@dataclass(frozen=True)
class Wait(Act):
    """Advance virtual time."""

    ns: int


@dataclass(frozen=True)
class Say(Act):
    """The host transmits data."""

    data: bytes


@dataclass(frozen=True)
class Hear(Act):
    """The host receives data.  Without data: the host has received no data since the earlier lines."""

    data: bytes


@dataclass(frozen=True)
class Do(Act):
    """A manual action: drive or release a pin, switch the power."""

    target: str
    value: str


@dataclass(frozen=True)
class Expect(Act):
    """The expected value of a pin, an axis or the clock."""

    subject: str
    value: str
