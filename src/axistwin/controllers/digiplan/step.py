"""Messages and sequence steps as data, and the parameters that they set."""

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple

from axistwin.controllers.diagnostics import Rule


class EndOfWork(Exception):  # noqa: N818  # not a programming error
    """Exception that ends the move, run or sequence in progress.

    The reason is an inhibited move or an invalid parameter.
    """


class Fault(Enum):
    """Kind of fault that an invalid message causes: a data fault, or a parameter out of range."""

    DATA = "data fault"
    RANGE = "out of range"


class Problem(NamedTuple):
    """A problem in a message from the host.

    `position`: index of the problem in the text of the message.  `message`: description of the problem.  `chapter`:
    chapter of the controller's manual.
    """

    rule: Rule
    fault: Fault
    position: int
    message: str
    chapter: str
    about: tuple[str, ...] = ()
    """Names of the `Parameters` that conflict."""
    end: int = 0
    """Index after the last character of the problem; 0: the problem is the one character at `position`."""


@dataclass
class Step:
    """Commands of one step of a sequence.

    A message that is not a sequence is also one step.  The fields are in the order of execution.
    Directions are +1 and -1.
    A field that was not stated is None, False or empty.
    """

    settings: dict[str, int] = field(default_factory=dict)
    """New values of `Parameters`, by name."""
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
    places: dict[str, int] = field(default_factory=dict, compare=False)
    """Index of each setting in the text, by name."""


RANGES: dict[str, tuple[int, int]] = {
    "speed_range": (1, 4),
    "speed": (1, 99_999),
    "start_stop": (1, 40),
    "acceleration": (1, 500),
    "distance": (0, 999_999_999),
    "minor_distance": (0, 999_999_999),
    "backlash": (-255, 255),
    "pulse_length": (1, 99),
    "character_delay": (0, 25),
}

RAMP_SETTINGS = frozenset({"speed_range", "start_stop", "acceleration"})


@dataclass(frozen=True)
class Parameters:
    """Settings of an IF1 or IF2, e.g. the speed and the distance of a move.

    A setting keeps its value until a message overwrites the value (manual, chapter Default values).
    """

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
        """Return a copy of the settings with the new values from a sequence step, e.g. a new speed.

        `step`: a sequence step, or a message that is not a sequence.
        """
        return replace(self, **step.settings) if step.settings else self

    def without_index(self) -> "Parameters":
        """Return a copy of the motion parameters with a distance of 0.

        `distance` and `minor_distance` are 0, because a run (continuous move) sets both distances to 0.
        """
        return replace(self, distance=0, minor_distance=0)

    def left_by(self, step: Step) -> "Parameters":
        """Return the motion parameters that are valid after a sequence step.

        After a run (continuous move), the distance of a preset move is zero.
        """
        return self.after(step).without_index() if step.run else self.after(step)
