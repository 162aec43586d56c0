"""Events that a board reports to the driver."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Ready:
    """Event: the board accepts pulses.  `positions`: net pulses by axis; `inputs`: level by input."""

    positions: Mapping[str, int]
    inputs: Mapping[str, bool]


@dataclass(frozen=True)
class InputChanged:
    """Event: an input of the board has changed.  `at_s`: time of the change in seconds of the host's clock."""

    to: str
    level: bool
    at_s: float


@dataclass(frozen=True)
class Stopped:
    """Event: axes have stopped.  `positions`: net pulses by axis; `by`: input that stopped them, or ""."""

    reason: str
    positions: Mapping[str, int] = field(default_factory=dict)
    by: str = ""


@dataclass(frozen=True)
class Failed:
    """The board is not used until the user continues.  `gone`: that is impossible, and the run must end."""

    reason: str
    gone: bool = False


Event = Ready | InputChanged | Stopped | Failed
