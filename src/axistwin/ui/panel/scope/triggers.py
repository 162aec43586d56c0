"""The oscilloscope's trigger: find the times at which a signal passes a value."""

from dataclasses import dataclass

import numpy as np

from axistwin.ui.panel.scope.tracks import Rows, Times, Track

UP, DOWN, EITHER = "up", "down", "either"
SLOPES = (UP, DOWN, EITHER)
OFF, AUTO, NORMAL, SINGLE = "off", "auto", "normal", "single"
MODES = (OFF, AUTO, NORMAL, SINGLE)
"""`OFF`: show the newest data.  `NORMAL`: show the newest edge.  `AUTO`: show the newest edge or, without an edge, the
newest data.  `SINGLE`: show the first edge, and pause.
"""


@dataclass
class Trigger:
    """Settings of the trigger.  `place`: position of the edge on the screen, from 0 (left) to 1 (right)."""

    mode: str = OFF
    signal: str = ""
    slope: str = UP
    value: float = 0.5
    place: float = 0.5

    def edges(self, track: Track, after_ns: int, upto_ns: int) -> list[int]:
        """Return the times of all edges of a signal from `after_ns` to `upto_ns`."""
        times = edges(track.rows(after_ns - 1, upto_ns + 1), self.slope, self.value)
        found: list[int] = times[(times >= after_ns) & (times <= upto_ns)].tolist()
        return found


def edges(rows: Rows, slope: str, value: float) -> Times:
    """Return the times at which the values reach `value` from below (`UP`), or fall below `value` (`DOWN`).

    The time of an edge within a merged interval is the start of the interval.
    """
    before = np.concatenate(((np.nan,), rows.last[:-1]))
    high = rows.first >= value
    within = (rows.low < value) & (rows.high >= value)
    up = (high & (before < value)) | within
    down = ((rows.first < value) & (before >= value)) | within
    wanted = {UP: up, DOWN: down, EITHER: up | down}[slope]
    return rows.begin[wanted]
