"""Curves of what has moved: of steppers exactly as the profiles have it, rates in steps, positions straight between.

Servos are drawn from sample to sample: where the shaft was and where it should have been, and the difference.
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
"""Points that a curve may have; with more, neighbours are drawn as the span between their extremes."""


@dataclass
class Curve:
    """Values from their times on, in seconds."""

    times: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)

    def add(self, time_ns: int, value: float) -> None:
        """The next point."""
        self.times.append(time_ns / S)
        self.values.append(value)

    def change(self, time_ns: int, value: float) -> None:
        """From now on; what was to be from the same time on never was."""
        if self.times[-1] == time_ns / S:
            self.times.pop()
            self.values.pop()
        self.add(time_ns, value)

    def thinned(self, most: int = MOST) -> "Curve":
        """The same to the eye, with no more points than that."""
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
    """Pulses per second, negative in the negative direction: each value holds until the next."""
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
    """Net pulses, with fractions between one pulse and the next: straight between the points."""
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
    """Position, commanded position and following error (commanded less actual) of a servo, in counts.

    `rows`: time in ns, position, commanded position; before the first and behind the last everything rests.
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
