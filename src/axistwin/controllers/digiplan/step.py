"""What a message or a sequence step asks for, and the parameters it leaves behind."""

from dataclasses import dataclass, field, replace
from enum import Enum

from axistwin.controllers.diagnostics import Rule


class EndOfWork(Exception):  # noqa: N818  # it is not an error of ours
    """What was being carried out is over: a move is refused, or a parameter is out of range."""


class Fault(Enum):
    """How the interface finds a message wrong."""

    DATA = "data fault"
    RANGE = "out of range"


@dataclass(frozen=True)
class Problem:
    """Something wrong with a message: where (index into its text), what, and the manual's chapter."""

    rule: Rule
    fault: Fault
    position: int
    message: str
    chapter: str
    about: tuple[str, ...] = ()
    """The `Parameters` it is about, if it is about values that do not go together."""
    end: int = 0
    """The index behind what it is about; 0: it is about the one character there."""


@dataclass
class Step:
    """One direct message, or one step of a sequence, in the order in which it is carried out.

    Directions are +1 and -1.  None and empty: not said.
    """

    settings: dict[str, int] = field(default_factory=dict)
    """Parameters that are kept: see `Parameters`; `speed` and `distance` among them."""
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
    """Where in the text each of the settings is said."""

    @property
    def moves(self) -> bool:
        """Whether it names an axis."""
        return bool(self.major)

    @property
    def empty(self) -> bool:
        """Whether it asks for nothing at all."""
        return self == Step()


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
"""What each parameter can be."""

RAMP_SETTINGS = frozenset({"speed_range", "start_stop", "acceleration"})
"""Parameters after which the interface calculates a new ramp."""


@dataclass(frozen=True)
class Parameters:
    """What the interface remembers until it is overwritten (chapter Default values)."""

    speed_range: int = 1
    speed: int = 400  # steps/s
    start_stop: int = 4  # x 100 steps/s
    acceleration: int = 10  # x 1000 steps/s²
    distance: int = 0  # steps; also that of the major axis
    minor_distance: int = 0
    backlash: int = 0  # steps, signed
    pulse_length: int = 10  # x 10 ms
    character_delay: int = 0  # x 10 ms

    def after(self, step: Step) -> "Parameters":
        """These with what the step sets."""
        return replace(self, **step.settings) if step.settings else self

    def without_index(self) -> "Parameters":
        """What a run leaves behind: an index length of zero."""
        return replace(self, distance=0, minor_distance=0)

    def left_by(self, step: Step) -> "Parameters":
        """What is kept when the step has begun its move."""
        return self.after(step).without_index() if step.run else self.after(step)
