"""Events that a board reports to the driver."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Ready:
    """Event: the board is configured and accepts pulses.  `positions`: net pulses by axis; `inputs`: levels by
    input.
    """

    positions: Mapping[str, int]
    inputs: Mapping[str, bool]


@dataclass(frozen=True)
class InputChanged:
    """Event: an input has changed.  `at_s`: time in s of the host's clock."""

    to: str
    level: bool
    at_s: float


@dataclass(frozen=True)
class Stopped:
    """Event: axes have stopped.  `positions`: net pulses by axis; `by`: input that stopped them, or "" for another
    reason.
    """

    reason: str
    positions: Mapping[str, int] = field(default_factory=dict)
    by: str = ""


@dataclass(frozen=True)
class Failed:
    """Event: the board has stopped all axes, does not answer, or cannot be used; only the user can continue."""

    reason: str


Event = Ready | InputChanged | Stopped | Failed
