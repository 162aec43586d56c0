"""The status and the unit that the axes of all controllers have."""

from dataclasses import dataclass, replace

from axistwin.drivers.arguments import number
from axistwin.drivers.errors import PositionLostError, RefusedError


@dataclass(frozen=True)
class Fault:
    """A fault of an axis or of its controller.  `remedy`: what the user must do to remove the fault."""

    name: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.name}: {self.remedy}"


@dataclass(frozen=True)
class Status:
    """State of an axis at one moment."""

    position: float
    """Position in counts, or from `Axis.status` in the user's unit; meaningless if `lost` is not empty."""
    setpoint: float
    """Target of the last move."""
    velocity: float
    """Signed velocity in counts/s, or from `Axis.status` in the user's unit/s."""
    moving: bool
    """True until the motion has ended and the exact position has been read."""
    estimated: bool = False
    """True if the position is interpolated from the commanded move."""
    limit_plus: bool = False
    """True while the limit in the positive direction is active."""
    limit_minus: bool = False
    """True while the limit in the negative direction is active."""
    at_home: bool = False
    """True while the home input is active."""
    faults: tuple[Fault, ...] = ()
    """Faults since the last `clear_faults`."""
    lost: str = ""
    """Reason why the position is not known; "" if the position is known."""
    missed: str = ""
    """Reason why an axis at rest is not at the target of its last move, or has not found home.

    "" during a motion, at the target, and after a run, `stop`, `abort` or `set_position`.
    """

    def known_position(self) -> float:
        """Return the position of the axis.  Raises PositionLostError if the position is not known."""
        if cause := self.lost:
            raise PositionLostError(f"the position is not known, because {cause}: home the axis, or call set_position")
        return self.position


@dataclass
class Scale:
    """Unit of an axis, as a number of counts."""

    counts_per_unit: float = 1.0
    """Counts per unit; negative if the unit's positive direction is the negative direction of the counts."""
    unit: str = "counts"

    def __post_init__(self) -> None:
        if not number("counts_per_unit", self.counts_per_unit):
            raise RefusedError("invalid counts_per_unit 0: expected a number other than 0, e.g. 400")

    def counts(self, units: float) -> int:
        """Convert a position from the user's unit to the nearest count."""
        return round(units * self.counts_per_unit)

    def rate(self, units: float) -> float:
        """Convert a velocity, e.g. in mm/s, to counts/s, or an acceleration, e.g. in mm/s², to counts/s²."""
        return abs(units * self.counts_per_unit)

    def status(self, raw: Status) -> Status:
        """Convert the positions and the velocity in `raw` from counts to the user's unit, e.g. mm."""
        k = self.counts_per_unit
        reversed_ = k < 0
        return replace(
            raw, position=raw.position / k, setpoint=raw.setpoint / k, velocity=raw.velocity / k,
            limit_plus=raw.limit_minus if reversed_ else raw.limit_plus,
            limit_minus=raw.limit_plus if reversed_ else raw.limit_minus,
        )  # fmt: skip
