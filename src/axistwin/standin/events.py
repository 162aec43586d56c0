"""What a board reports to the twin."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Ready:
    """The board is configured, and moves its axes from now on.  `positions`: net pulses, by axis."""

    positions: Mapping[str, int]
    inputs: Mapping[str, bool]


@dataclass(frozen=True)
class InputChanged:
    """An input has changed at this time of the host."""

    to: str
    level: bool
    at_s: float


@dataclass(frozen=True)
class Stopped:
    """Axes have stopped at these net pulses.  `by`: the input that stopped them; "": a human must go on."""

    reason: str
    positions: Mapping[str, int] = field(default_factory=dict)
    by: str = ""


@dataclass(frozen=True)
class Failed:
    """The board has stopped everything, does not answer, or cannot be used: a human must go on."""

    reason: str


Event = Ready | InputChanged | Stopped | Failed
