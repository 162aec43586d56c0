"""Curves of motion.  Stepper curves are exact: rates in steps, straight lines between positions.

Servo curves join the samples: actual position, commanded position and following error.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from axistwin.plots.history import Move
from axistwin.units import S

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MOST = 20_000
"""Largest number of points of a curve; longer curves are reduced to the extremes of neighbouring points."""


@dataclass
class Curve:
    """Values with their start times, in seconds."""

    times: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def add(self, time_ns: int, value: float) -> None:
        """Append a point."""
        self.times.append(time_ns / S)
        self.values.append(value)

    def change(self, time_ns: int, value: float) -> None:
        """Set a new value from this time on; it replaces a point at the same time."""
        if self.times[-1] == time_ns / S:
            self.times.pop()
            self.values.pop()
        self.add(time_ns, value)

    def thinned(self, most: int = MOST) -> "Curve":
        """Return a curve with at most `most` points that looks the same."""
        if len(self.times) <= most:
            return self
        thin = Curve([self.times[0]], [self.values[0]])
        group = 2 * len(self.times) // most + 1
        for first in range(1, len(self.times), group):
            values = self.values[first : first + group]
            thin.times += [self.times[first], self.times[min(first + group, len(self.times)) - 1]]
            thin.values += [min(values), max(values)]
        thin.times.append(self.times[-1])
        thin.values.append(self.values[-1])
        return thin


def velocity(moves: Iterable[Move], from_ns: int, to_ns: int) -> Curve:
    """Return the velocity in pulses per second, negative in the negative direction, as steps."""
    curve = Curve()
    curve.add(from_ns, 0)
    for move in moves:
        for start_ns, rate in move.segments():
            curve.change(start_ns, move.stroke.direction * float(rate))
        if move.end_ns is not None:
            curve.add(move.end_ns, 0)
    curve.add(to_ns, curve.values[-1])
    return curve


def position(moves: Sequence[Move], from_ns: int, to_ns: int) -> Curve:
    """Return the net pulses, with fractions between pulses, as straight lines."""
    curve = Curve()
    curve.add(from_ns, moves[0].origin)
    for move in moves:
        profile, origin, direction = move.stroke.profile, move.origin, move.stroke.direction
        for (start_ns, _), phase in zip(move.segments(), profile.phases, strict=False):
            curve.add(start_ns, origin + direction * phase / profile.parts)
        if move.end_ns is not None:
            curve.add(move.end_ns, move.target)
    curve.add(to_ns, moves[-1].target)
    return curve


def servo(rows: "NDArray[np.int64]", from_ns: int, to_ns: int) -> tuple[Curve, Curve, Curve]:
    """Return position, commanded position and following error (commanded less actual) of a servo, in counts.

    `rows`: time in ns, position, commanded position; before the first row and after the last row the axis rests.
    """
    import numpy as np

    inside = rows[(rows[:, 0] >= from_ns) & (rows[:, 0] <= to_ns)]
    times = np.concatenate(([from_ns], inside[:, 0], [to_ns])) / S

    def curve(values: "NDArray[np.int64]") -> Curve:
        before = np.flatnonzero(rows[:, 0] < from_ns)
        first = values[before[-1]] if len(before) else values[0]
        seen = values[(rows[:, 0] >= from_ns) & (rows[:, 0] <= to_ns)]
        last = seen[-1] if len(seen) else first
        return Curve(times.tolist(), np.concatenate(([first], seen, [last])).tolist())

    return curve(rows[:, 1]), curve(rows[:, 2]), curve(rows[:, 2] - rows[:, 1])
