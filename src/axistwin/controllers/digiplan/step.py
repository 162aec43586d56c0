"""Messages and sequence steps as data, and the parameters that they set."""

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple

from axistwin.controllers.diagnostics import Rule


class EndOfWork(Exception):  # noqa: N818  # not a programming error
    """Raised to end the work in progress, because of an inhibited move or an invalid parameter."""


class Fault(Enum):
    """Kind of fault that a wrong message raises."""

    DATA = "data fault"
    RANGE = "out of range"


class Problem(NamedTuple):
    """A problem of a message: its place (index into the text), a description, and the manual's chapter."""

    rule: Rule
    fault: Fault
    position: int
    message: str
    chapter: str
    about: tuple[str, ...] = ()  # Names of the `Parameters` that conflict.
    end: int = 0  # Index after the last character of the problem; 0: the problem is the one character at `position`.


@dataclass
class Step:
    """One direct message, or one step of a sequence; its fields are in the order of execution.

    Directions are +1 and -1.  A field that was not stated is None, False or empty.
    """

    settings: dict[str, int] = field(default_factory=dict)  # New values of `Parameters`, by name.
    high: tuple[int, ...] = ()
    low: tuple[int, ...] = ()
    abort: bool = False
    major: dict[str, int] = field(default_factory=dict)
    minor: dict[str, int] = field(default_factory=dict)
    interpolated: bool = False
    run: bool = False
    corrected: bool = False
    set: tuple[int, ...] = ()
    reset: tuple[int, ...] = ()
    pulse: int | None = None
    repeat: tuple[int, int] | None = None
    hand_over: bool = False
    places: dict[str, int] = field(default_factory=dict, compare=False)  # Index of each setting in the text, by name.


RANGES: dict[str, tuple[int, int]] = {
    "speed_range": (1, 4), "speed": (1, 99_999), "start_stop": (1, 40), "acceleration": (1, 500),
    "distance": (0, 999_999_999), "minor_distance": (0, 999_999_999), "backlash": (-255, 255), "pulse_length": (1, 99),
    "character_delay": (0, 25),
}  # fmt: skip

RAMP_SETTINGS = frozenset({"speed_range", "start_stop", "acceleration"})


@dataclass(frozen=True)
class Parameters:
    """Values that are kept until they are overwritten (chapter Default values)."""

    speed_range: int = 1
    speed: int = 400  # Speed in steps/s.
    start_stop: int = 4  # Start/stop speed in units of 100 steps/s.
    acceleration: int = 10  # Acceleration in units of 1000 steps/s².
    distance: int = 0  # Distance of the next move in steps.
    minor_distance: int = 0  # Distance of each minor axis in an interpolated move, in steps.
    backlash: int = 0  # Backlash distance in steps; its sign is the final direction of a move with backlash correction.
    pulse_length: int = 10  # Length of an output pulse in units of 10 ms.
    character_delay: int = 0  # Inter-character delay in units of 10 ms.

    def after(self, step: Step) -> "Parameters":
        return replace(self, **step.settings) if step.settings else self

    def without_index(self) -> "Parameters":
        """Return these parameters with an index length of zero, as a run sets it."""
        return replace(self, distance=0, minor_distance=0)

    def left_by(self, step: Step) -> "Parameters":
        """Return the parameters after the step has begun; a run sets the index length to zero."""
        return self.after(step).without_index() if step.run else self.after(step)
