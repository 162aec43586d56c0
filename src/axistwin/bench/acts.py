"""Actions and expectations on a bench as data: the lines of a conversation."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Act:
    """Base class for one line of a conversation: its number in the file, and the controller that it names."""

    line: int = field(default=0, kw_only=True, compare=False)
    controller: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Comment(Act):
    """A comment line of a conversation file; it has no effect."""

    text: str = ""


@dataclass(frozen=True)
class Wait(Act):
    """A waiting time in a conversation file: `+ 0.25` advances virtual time by 0.25 s."""

    ns: int


@dataclass(frozen=True)
class Say(Act):
    """Data that the host sends: a line of a conversation file, e.g. `> U61`."""

    data: bytes


@dataclass(frozen=True)
class Hear(Act):
    """A line of a conversation: the host receives these data, or nothing since the line before if there are none."""

    data: bytes


@dataclass(frozen=True)
class Do(Act):
    """A manual action in a conversation file, e.g. `! power high` (switch the power on)."""

    target: str
    value: str


@dataclass(frozen=True)
class Expect(Act):
    """A line of a conversation file: the expected value of a pin, an axis or the clock."""

    subject: str
    value: str
