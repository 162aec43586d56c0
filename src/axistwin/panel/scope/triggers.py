"""Edges of levels and texts, and of numbers that pass a value."""

from dataclasses import dataclass

import numpy as np

from axistwin.panel.scope.tracks import Rows, Times, Track

UP, DOWN, EITHER = "up", "down", "either"
SLOPES = (UP, DOWN, EITHER)
OFF, AUTO, NORMAL, SINGLE = "off", "auto", "normal", "single"
MODES = {
    OFF: "what is newest",
    AUTO: "the newest edge; without one what is newest",
    NORMAL: "the newest edge",
    SINGLE: "the first edge, and then pause",
}


@dataclass
class Trigger:
    """Selects the edge of a window; `place`: position of the edge, from 0 at the left to 1."""

    mode: str = OFF
    signal: str = ""
    slope: str = UP
    value: float = 0.5
    place: float = 0.5

    def edges(self, track: Track, after_ns: int, upto_ns: int) -> list[int]:
        """Return the edges from `after_ns` to `upto_ns`."""
        times = edges(track.rows(after_ns - 1, upto_ns + 1), self.slope, self.value)
        found: list[int] = times[(times >= after_ns) & (times <= upto_ns)].tolist()
        return found


def edges(rows: Rows, slope: str, value: float) -> Times:
    """Return the times at which a track reaches `value` from below (up), or falls below (down).

    An edge within a stored interval has the start time of the interval.
    """
    before = np.concatenate(((np.nan,), rows.last[:-1]))
    high = rows.first >= value
    within = (rows.low < value) & (rows.high >= value)
    up = (high & (before < value)) | within
    down = ((rows.first < value) & (before >= value)) | within
    wanted = {UP: up, DOWN: down, EITHER: up | down}[slope]
    return rows.begin[wanted]
