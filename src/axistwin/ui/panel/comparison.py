"""What a panel shows of a real machine beside its twin."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol


class Found(NamedTuple):
    """A difference, in the words of its list."""

    at: str
    text: str
    times: str
    note: bool  # True if it is no finding: what the twin has taken over from the machine.


class Comparison(Protocol):
    """A machine beside its twin, now or at the moment of a difference."""

    @property
    def state(self) -> str:
        """Whether they agree, or what differs."""

    @property
    def differs(self) -> bool: ...

    @property
    def clock(self) -> str:
        """Time of the machine that is shown."""

    @property
    def past(self) -> bool:
        """True if this time is past."""

    @property
    def found(self) -> Sequence[Found]:
        """All differences, the newest first."""

    def beside(self, axis: str) -> int | None:
        """Return the machine's position, in the twin's pulses or counts; None if no answer has told it."""

    def go_back(self, found: Found) -> bool:
        """Show the moment of a difference.  Return False if what led to it is no longer kept."""

    def go_on(self) -> None:
        """Show the present again."""
