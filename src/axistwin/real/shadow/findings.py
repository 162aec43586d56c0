"""Findings: each difference once, with its time, section, expectation, and how often it has come since."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from enum import StrEnum
from typing import Any

from axistwin.core.units import MS, S

TOLERANCE_NS = 15 * MS  # Time that is never a finding, unless another one is set.
MOST = 500  # Findings that are remembered one by one; further ones are only counted.


class Kind(StrEnum):
    """What differs.  A note is no difference: the twin has taken over what only the machine can know."""

    ANSWER = "answer"
    LATE = "late"
    MISSING = "missing"
    SURPLUS = "surplus"
    CHARACTERS = "characters"
    DURATION = "duration"
    COUNT = "count"
    FAULT = "fault"
    NOTE = "note"


@dataclass
class Finding:
    """One difference.  Times are nanoseconds since 1970."""

    kind: Kind
    subject: str
    text: str
    section: str
    expected: str
    got: str
    time_ns: int
    count: int = 1
    last_ns: int = 0

    def as_dict(self) -> dict[str, Any]:
        found = asdict(self)
        found["kind"] = str(self.kind)
        return {**found, "time": stamp(self.time_ns), "last": stamp(self.last_ns)}

    def line(self) -> str:
        """The finding in one line, as it is printed."""
        section = f" ({self.section})" if self.section else ""
        return f"{stamp(self.time_ns)} {self.kind}: {self.text}{section}"


def stamp(time_ns: int) -> str:
    return f"{datetime.fromtimestamp(time_ns / S, UTC):%Y-%m-%dT%H:%M:%S.%f}"[:-3] + "Z"


class Findings:
    """All findings by kind and subject.  `tell` receives each one when it is found first."""

    def __init__(self, tell: Callable[[Finding], object]) -> None:
        self._tell = tell
        self._found: dict[tuple[Kind, str], Finding] = {}
        self.further = 0  # Differences beyond `MOST`, which are only counted.

    def add(
        self, kind: Kind, subject: str, text: str, time_ns: int, *, section: str = "", expected: str = "", got: str = ""
    ) -> bool:
        """Add a difference; return True if it is a new one."""
        known = self._found.get((kind, subject))
        if known is not None:
            known.count += 1
            known.last_ns = time_ns
            return False
        if len(self._found) >= MOST:
            self.further += 1
            return False
        found = Finding(kind, subject, text, section, expected, got, time_ns, last_ns=time_ns)
        self._found[kind, subject] = found
        self._tell(found)
        return True

    @property
    def differences(self) -> list[Finding]:
        return [found for found in self._found.values() if found.kind is not Kind.NOTE]

    @property
    def notes(self) -> list[Finding]:
        return [found for found in self._found.values() if found.kind is Kind.NOTE]
