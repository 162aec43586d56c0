"""Reduce a signal to the pixels of a screen: the least and greatest value in each pixel, and a line through them.

The time span of a pixel includes its start but not its end.  The value at the start of a pixel counts as a value of
the pixel, so that every edge is visible.  The line has at most two points per pixel: the change if there is only one,
else the least and the greatest value.
"""

from bisect import bisect_left
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from axistwin.ui.panel.scope.tracks import Numbers, Rows, Times, Track, Words

FEW = 4  # Average number of pixels per change above which a line contains every change exactly.


@dataclass(frozen=True)
class Window:
    """Values of a signal for each pixel; pixel n is the time from `edges[n]` to `edges[n + 1]`.  NaN: unknown."""

    edges: Times
    low: Numbers  # Least value in each pixel.
    high: Numbers  # Greatest value in each pixel.
    times: Times  # Times of the points of the line.
    values: Numbers


class Line(NamedTuple):
    """Points of a stepped curve: the value is constant from each point to the next point."""

    times: Times
    values: Numbers


@dataclass(frozen=True)
class _Pixels:
    held: Numbers
    low: Numbers
    high: Numbers
    ends: NDArray[np.intp]  # For each pixel, the number of rows that begin before its end.
    single: NDArray[np.bool_]
    busy: NDArray[np.bool_]


def window(track: Track, from_ns: int, to_ns: int, pixels: int, now_ns: int) -> Window:
    """Return the data to plot a signal from `from_ns` to `to_ns`.  Values after `now_ns` are unknown."""
    edges = from_ns + (to_ns - from_ns) * np.arange(pixels + 1, dtype=np.int64) // pixels
    # The last change before the start of the plot determines the signal's value at the start.
    rows = track.rows(from_ns - 1, min(to_ns, now_ns) + 1)
    seen = _pixels(rows, edges)
    past = edges[:-1] >= now_ns
    seen.low[past] = seen.high[past] = np.nan
    times, values = _line(rows, edges, seen, min(to_ns, now_ns))
    return Window(edges, seen.low, seen.high, times, values)


def line(track: Track, from_ns: int, to_ns: int, pixels: int, now_ns: int) -> Line:
    """Return the line of a track from `from_ns` to `to_ns`; many changes are reduced to the extremes of each pixel."""
    until_ns = min(to_ns, now_ns)
    rows = track.rows(from_ns, until_ns + 1)
    single = rows.begin is rows.end or np.array_equal(rows.begin, rows.end)
    if len(rows.begin) > pixels // FEW or not single:
        seen = window(track, from_ns, to_ns, pixels, now_ns)
        return Line(seen.times, seen.values)
    first = max(int(rows.begin.searchsorted(from_ns, "right")) - 1, 0)
    begin, last = rows.begin[first:], rows.last[first:]
    if not len(begin) or max(begin[0], from_ns) >= until_ns:
        return Line(begin[:0], last[:0])
    times, values = np.empty(len(begin) + 1, np.int64), np.empty(len(begin) + 1)
    np.maximum(begin, from_ns, out=times[:-1])
    values[:-1] = last
    times[-1], values[-1] = until_ns, last[-1]
    return Line(times, values)


def _pixels(rows: Rows, edges: Times) -> _Pixels:
    begun = np.searchsorted(rows.begin, edges)
    begins, ends, counts = begun[:-1], begun[1:], np.diff(begun)
    held = np.full(len(begins), np.nan)
    first_known = begins.searchsorted(0, "right")
    held[first_known:] = rows.last[begins[first_known:] - 1]
    low, high = held.copy(), held.copy()
    some, single, busy = counts > 0, counts == 1, counts > 1
    if some.any():
        starts, upto = begins[some], ends[-1]
        low[some] = np.fmin(low[some], np.fmin.reduceat(rows.low[:upto], starts))
        high[some] = np.fmax(high[some], np.fmax.reduceat(rows.high[:upto], starts))
    _spread(rows, edges, (low, high, busy))
    return _Pixels(held, low, high, ends, single & ~busy, busy)


def _spread(rows: Rows, edges: Times, pixels: tuple[Numbers, Numbers, NDArray[np.bool_]]) -> None:
    """Apply the extremes of each merged interval to all its pixels, because the exact times are unknown."""
    wide = np.flatnonzero((rows.end > rows.begin) & (rows.end >= edges[0]))
    if not len(wide):
        return
    low, high, busy = pixels
    first = np.maximum(np.searchsorted(edges, rows.begin[wide], "right") - 1, 0)
    last = np.minimum(np.searchsorted(edges, rows.end[wide], "right") - 1, len(low) - 1)
    counts = np.maximum(last - first + 1, 0)
    which = np.repeat(wide, counts)
    where = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(first, counts)
    np.fmin.at(low, where, rows.low[which])
    np.fmax.at(high, where, rows.high[which])
    busy[where] = True


def _line(rows: Rows, edges: Times, seen: _Pixels, until_ns: int) -> tuple[Times, Numbers]:
    """Return the points of a line: at most two points per pixel, and one point at the end."""
    times, values = np.empty((len(seen.low), 2), np.int64), np.full((len(seen.low), 2), np.nan)
    used = np.zeros(times.shape, bool)
    busy, single = seen.busy, seen.single
    left = ~busy & np.concatenate(((True,), busy[:-1])) & ~np.isnan(seen.held)
    times[:, 0], used[:, 0] = edges[:-1], left | busy
    # In a pixel column, first plot the minimum or the maximum, whichever is nearer to the previous point.
    low_first = seen.held - seen.low <= seen.high - seen.held
    values[:, 0] = np.where(busy, np.where(low_first, seen.low, seen.high), seen.held)
    times[:, 1], used[:, 1] = edges[:-1], single | busy
    values[:, 1] = np.where(busy, np.where(low_first, seen.high, seen.low), np.nan)
    rows_of = seen.ends[single] - 1
    times[single, 1], values[single, 1] = rows.begin[rows_of], rows.last[rows_of]
    used &= times < until_ns
    found_times, found_values = times[used], values[used]
    if len(found_times) and until_ns > found_times[-1]:
        last = rows.last[-1]
        return np.append(found_times, until_ns), np.append(found_values, last)
    return found_times, found_values


def marks(words: Words, from_ns: int, to_ns: int, most: int) -> list[tuple[int, str]]:
    """Divide the time into `most` equal parts; return the first text in each part, with its start time."""
    edges = [from_ns + (to_ns - from_ns) * n // most for n in range(most + 1)]
    places = [bisect_left(words.begins, edge) for edge in edges]
    firsts = [first for first, upto in pairwise(places) if first < upto]
    return [(words.begins[at], words.messages[at]) for at in firsts]
