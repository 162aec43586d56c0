"""Measurement with two cursors: the time between the cursors, and the values of each signal."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from axistwin.core.units import MS, US, S
from axistwin.ui.panel.scope.tracks import Track


@dataclass(frozen=True)
class Reading:
    """Values of a signal at two cursors and between them; NaN: unknown."""

    a: float
    b: float
    low: float
    high: float
    mean: float

    @property
    def difference(self) -> float:
        return self.b - self.a


def value_at(track: Track, time_ns: int) -> float:
    """Return the value of a signal at a time, after all changes at this time; NaN within a merged interval."""
    rows = track.rows(time_ns, time_ns + 1)
    place = int(rows.begin.searchsorted(time_ns, "right")) - 1
    return np.nan if place < 0 or rows.end[place] > time_ns else float(rows.last[place])


def between(track: Track, a_ns: int, b_ns: int) -> Reading:
    from_ns, to_ns = sorted((a_ns, b_ns))
    rows = track.rows(from_ns, to_ns + 1)
    begun = int(np.searchsorted(rows.begin, to_ns, "right"))
    first = max(int(np.searchsorted(rows.begin, from_ns, "right")) - 1, 0)
    part = rows.cut(slice(first, begun))
    at = value_at(track, a_ns), value_at(track, b_ns)
    if not len(part.begin) or part.begin[0] > from_ns:
        return Reading(*at, np.nan, np.nan, np.nan)
    within = bool(part.end[0] > from_ns)
    low = np.append(part.low[1:], part.low[0] if within else part.last[0]).min()
    high = np.append(part.high[1:], part.high[0] if within else part.last[0]).max()
    return Reading(*at, float(low), float(high), _mean(track, from_ns, to_ns))


def _mean(track: Track, from_ns: int, to_ns: int) -> float:
    """Return the mean of a signal between two times, weighted by the duration of each value."""
    rows = track.rows(from_ns, to_ns)
    if to_ns == from_ns:
        return value_at(track, from_ns)
    ends = np.append(rows.begin[1:], max(to_ns, int(rows.end[-1])))
    inside = np.clip(rows.end, from_ns, to_ns) - np.clip(rows.begin, from_ns, to_ns)
    spans = np.maximum(rows.end - rows.begin, 1)
    still = np.clip(ends, from_ns, to_ns) - np.clip(rows.end, from_ns, to_ns)
    areas = np.where(inside > 0, rows.area / spans * inside, 0.0) + np.where(still > 0, rows.last * still, 0.0)
    return float(areas.sum() / (to_ns - from_ns))


def nearest_edge(tracks: Iterable[Track], time_ns: int, within_ns: int) -> int | None:
    """Return the nearest signal change before or after `time_ns`; None if none is within `within_ns`."""
    found: list[int] = []
    for track in tracks:
        begins = track.rows(time_ns - within_ns - 1, time_ns + within_ns + 1).begin
        if not len(begins):
            continue
        place = int(np.searchsorted(begins, time_ns))
        found += begins[max(place - 1, 0) : place + 1].tolist()
    near = [edge for edge in found if abs(edge - time_ns) <= within_ns]
    return min(near, key=lambda edge: abs(edge - time_ns), default=None)


def next_edge(tracks: Iterable[Track], time_ns: int, upto_ns: int) -> int | None:
    """Search from `time_ns` to `upto_ns`, forward or backward; return the time of the first change found."""
    found: list[int] = []
    for track in tracks:
        begins = track.rows(min(time_ns, upto_ns), max(time_ns, upto_ns) + 1).begin
        if upto_ns > time_ns:
            found += begins[(begins > time_ns) & (begins <= upto_ns)][:1].tolist()
        else:
            found += begins[(begins < time_ns) & (begins >= upto_ns)][-1:].tolist()
    return min(found, key=lambda edge: abs(edge - time_ns), default=None)


def duration(time_ns: float) -> str:
    """Format a duration with a suitable unit, e.g. `12.5 ms`."""
    size = abs(time_ns)
    unit, name = next(((u, n) for u, n in ((S, "s"), (MS, "ms"), (US, "µs")) if size >= u), (1, "ns"))
    return f"{time_ns / unit:.9g} {name}"


def rate(time_ns: int) -> str:
    """Format the reciprocal of a period as a frequency, e.g. `50 Hz`."""
    return f"{S / abs(time_ns):.6g} Hz" if time_ns else "–"
