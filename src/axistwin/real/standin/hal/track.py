"""Pulses as a continuous position: the axis moves along a line through its pulses."""

from axistwin.core.lazy import NDArray, np

STEP_S = 0.001  # Interval between two knots of the line.
SLOW_S = 0.004  # Longest duration of the line to a pulse; before it the position is constant.
DELAY_S = 0.01  # Knots come this much later than pulses: the line to a pulse, and a servo axis's interval.


class Track:
    """The line of one axis; `position`: net pulses.  Times are in seconds."""

    def __init__(self, position: int = 0) -> None:
        self.position, self.last_s = position, -np.inf  # Net pulses, and time of the last pulse.
        self._times: NDArray[np.float64] = np.empty(0)
        self._positions: NDArray[np.float64] = np.empty(0)
        self._given = float(position)
        self._next: int | None = None

    @property
    def calculated_s(self) -> float:
        """Latest time, in seconds, for which the position of the axis has been calculated."""
        return float("-inf") if self._next is None else (self._next - 1) * STEP_S

    def add(self, direction: int, times: "NDArray[np.float64]") -> None:
        """Append pulses at times in seconds; the direction is +1 or -1."""
        positions = self.position + direction * np.arange(1.0, len(times) + 1)
        slow = np.flatnonzero(np.diff(times, prepend=self.last_s) > SLOW_S)
        self._times = np.concatenate([self._times, np.insert(times, slow, times[slow] - SLOW_S)])
        self._positions = np.concatenate([self._positions, np.insert(positions, slow, positions[slow] - direction)])
        self.position, self.last_s = int(positions[-1]), float(times[-1])

    def knots(self, until_s: float) -> list[tuple[float, float]]:
        """Return the next knots; [] without motion.  All pulses before `until_s` have been added."""
        end = int((until_s - DELAY_S) // STEP_S)
        first = end if self._next is None else self._next
        if end < first:
            return []
        self._next = end + 1
        grid = np.arange(first, end + 1) * STEP_S
        positions = np.full(len(grid), self._given)
        if len(self._times):
            positions = np.interp(grid, self._times, self._positions)
            kept = max(int(np.searchsorted(self._times, grid[-1], "right")) - 1, 0)
            self._times, self._positions = self._times[kept:], self._positions[kept:]
        before, self._given = self._given, float(positions[-1])
        if (positions == before).all():
            return []
        return [((first - 1) * STEP_S, before), *zip(grid.tolist(), positions.tolist(), strict=True)]
