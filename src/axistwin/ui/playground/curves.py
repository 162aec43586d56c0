"""Position and velocity of all axes over time, sampled at a virtual interval, with bounded memory."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from axistwin.core.units import MS
from axistwin.scenes.sessions.session import Session

FIRST_INTERVAL_NS = 20 * MS
"""Initial interval of the samples in ns; one reading of a moving servo takes as much computing time as 5 ms of
motion.
"""
MOST_SAMPLES = 4096  # Number of samples at which every second sample is deleted, and the interval is doubled.


@dataclass
class Curve:
    """Samples of the position and the velocity of one axis."""

    positions: list[int] = field(default_factory=list)
    velocities: list[float] = field(default_factory=list)


class Curves:
    """Samples of all axes' position and velocity, whose times depend on virtual time alone."""

    def __init__(self, session: Session) -> None:
        self._session, self._bench = session, session.bench
        self.interval_ns = FIRST_INTERVAL_NS
        self.axes = {
            f"{name}.{axis}": Curve()
            for name, controller in self._bench.controllers.items()
            for axis in controller.axes
        }
        self._sample()

    @property
    def samples(self) -> int:
        """Number of samples up to now; the first sample is at the virtual time 0."""
        return max((len(curve.positions) for curve in self.axes.values()), default=0)

    @property
    def next_ns(self) -> int:
        """Virtual time at which the positions and velocities are sampled next, in nanoseconds."""
        return self.samples * self.interval_ns

    def _sample(self) -> None:
        for name, curve in self.axes.items():
            controller, _, axis = name.rpartition(".")
            found = self._bench.controllers[controller].axes[axis]
            curve.positions.append(found.position)
            curve.velocities.append(float(found.velocity))

    def advance(self, until_ns: int) -> Iterator[int]:
        """Advance the bench, and yield the time of each sample; overdue samples have the present values."""
        while self.axes and self.next_ns < self._bench.now:
            self._sample()
            self._thin_out()
        while self.axes and self.next_ns <= until_ns:
            self._session.advance(self.next_ns)
            self._sample()
            self._thin_out()
            yield self._bench.now
        self._session.advance(until_ns)

    def _thin_out(self) -> None:
        if self.samples < MOST_SAMPLES:
            return
        for curve in self.axes.values():
            del curve.positions[1::2], curve.velocities[1::2]
        self.interval_ns *= 2

    def window(self, from_ns: int, points: int) -> dict[str, dict[str, list[list[float]]]]:
        """Return `[seconds, value]` pairs since a time, by axis and quantity; at most `2 * points` pairs of each curve.

        A group of neighbouring samples is represented by its least and its greatest value, in the order of their times.
        """
        first = max(0, from_ns // self.interval_ns)
        return {
            name: {
                "position": self._reduced(curve.positions, first, points),
                "velocity": self._reduced(curve.velocities, first, points),
            }
            for name, curve in self.axes.items()
        }

    def _reduced(self, values: "list[int] | list[float]", first: int, points: int) -> list[list[float]]:
        size = max(1, -(-(len(values) - first) // points))
        found = []
        for start in range(first, len(values), size):
            group = range(start, min(start + size, len(values)))
            ends = {min(group, key=values.__getitem__), max(group, key=values.__getitem__)}
            found += [[n * self.interval_ns / 1e9, values[n]] for n in sorted(ends)]
        return found

    def table(self) -> str:
        head = [f"{name}.{quantity}" for name in self.axes for quantity in ("position", "velocity")]
        rows = [",".join(("seconds", *head))]
        for n in range(self.samples):
            cells = [f"{n * self.interval_ns / 1e9:.9g}"]
            for curve in self.axes.values():
                cells += [str(curve.positions[n]), f"{curve.velocities[n]:.9g}"]
            rows.append(",".join(cells))
        return "\n".join(rows) + "\n"
