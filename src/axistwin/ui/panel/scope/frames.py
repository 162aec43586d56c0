"""Messages to the browser with the contents of a screen; lines are pairs of 16-bit numbers in base 64."""

from base64 import b64encode
from math import ceil, floor, isfinite, isnan, log10
from typing import Any

import numpy as np

from axistwin.core.units import MS, US, S
from axistwin.records.traces.signals import COUNT, REAL
from axistwin.ui.panel.scope.cursors import value_at
from axistwin.ui.panel.scope.decimation import Line, line, marks
from axistwin.ui.panel.scope.meaning import PLAIN, Meaning
from axistwin.ui.panel.scope.screen import Screen
from axistwin.ui.panel.scope.tracks import Track, Words
from axistwin.ui.panel.scope.triggers import OFF

FULL = 65_535  # Largest 16-bit number: the right edge of the screen as a time, an unknown value as a value.
TOP = 4000  # Number that represents the highest value of a signal's range; 0 represents the lowest value.
WORD_PIXELS = 72  # Smallest width in pixels that a text needs on the screen.
UNITS = ((S, "s"), (MS, "ms"), (US, "µs"), (1, "ns"))


def frame(screen: Screen) -> dict[str, Any]:
    from_ns, to_ns = screen.edges
    base_ns, unit_ns, unit = _axis(from_ns, to_ns)
    folded = screen.folded_now
    still = all(track.flat for track in screen.tracks.values())
    return {
        "from": (from_ns - base_ns) / unit_ns, "to": (to_ns - base_ns) / unit_ns,
        "axis": f"{unit} after {base_ns / S:.9g} s" if base_ns else unit, "lanes": screen.lanes,
        "signals": [_signal(screen, name, from_ns, to_ns, folded=name in folded) for name in screen.names],
        "cursors": [_place(time_ns, from_ns, to_ns) for time_ns in (screen.cursors.a_ns, screen.cursors.b_ns)],
        "trigger": _place(screen.hit_ns if screen.trigger.mode != OFF else None, from_ns, to_ns),
        "now": _place(screen.record.now_ns, from_ns, to_ns),
        "alarms": [(_place(at_ns, from_ns, to_ns), f"{what}, {at_ns / S:.3f} s")
                   for at_ns, what in screen.recorder.alarms if from_ns <= at_ns <= to_ns],
        "hush": "The curves begin with the first move." if still else "",
    }  # fmt: skip


def _axis(from_ns: int, to_ns: int) -> tuple[int, int, str]:
    """Choose the labels of the time axis: return the origin, the unit in ns, and the unit's name."""
    span_ns = to_ns - from_ns
    unit_ns, unit = next(((u, n) for u, n in UNITS if span_ns >= u), UNITS[-1])
    if abs(to_ns) < 1000 * span_ns or unit_ns == S:
        return 0, unit_ns, unit
    coarse_ns = 10 ** ceil(log10(span_ns)) * 10
    return from_ns // coarse_ns * coarse_ns, unit_ns, unit


def _place(time_ns: int | None, from_ns: int, to_ns: int) -> float | None:
    """Return a time's place on the screen, from 0 (left) to 1 (right); None outside the screen."""
    return None if time_ns is None or not from_ns <= time_ns <= to_ns else (time_ns - from_ns) / (to_ns - from_ns)


def _signal(screen: Screen, name: str, from_ns: int, to_ns: int, *, folded: bool) -> dict[str, Any]:
    track = screen.record.tracks.get(name)
    meaning = screen.recorder.meanings.get(name, PLAIN)
    told = {
        "name": name, "title": screen.title(name), "note": meaning.note, "folded": folded,
        "numbers": track is not None and track.kind in (COUNT, REAL), "data": "", "range": "", "now": "", "unit": "",
        "zero": None, "text": isinstance(track, Words), "words": [],
    }  # fmt: skip
    if track is None:
        return told
    seen = line(track, from_ns, to_ns, screen.pixels, screen.record.now_ns)
    low, high = span(track, seen, meaning.per)
    at_ns = screen.record.now_ns if screen.pointer is None else screen.time_at(screen.pointer)
    few = max(screen.pixels // WORD_PIXELS, 1)
    words = marks(track, from_ns, to_ns, few) if isinstance(track, Words) else []
    told |= {
        "data": packed(seen, (from_ns, to_ns), (low, high)), "now": _value(track, meaning, at_ns),
        "words": [((time_ns - from_ns) / (to_ns - from_ns), _decoded(meaning, text)) for time_ns, text in words],
    }  # fmt: skip
    if told["numbers"]:
        told["range"] = f"{meaning.number(low)} … {meaning.number(high)}"
        told["unit"] = meaning.shown_unit
        if track.kind == REAL and low <= 0 <= high:
            told["zero"] = -low / (high - low)
    return told


def _value(track: Track, meaning: Meaning, at_ns: int) -> str:
    if isinstance(track, Words):
        return ""
    value = value_at(track, at_ns)
    if isnan(value):
        return "–"
    return meaning.number(value) if track.kind in (COUNT, REAL) else meaning.word(value)


def _decoded(meaning: Meaning, text: str) -> str:
    words = meaning.words(text)
    return f"{text}\n{words}" if words else text


def packed(seen: Line, times_ns: tuple[int, int], values: tuple[float, float]) -> str:
    """Encode the points of a line in base 64: times scaled to 0 to `FULL`, values scaled to 0 to `TOP`."""
    (from_ns, to_ns), (low, high) = times_ns, values
    pairs = np.empty((len(seen.times), 2), "<u2")
    pairs[:, 0] = np.rint((seen.times - from_ns) * (FULL / (to_ns - from_ns)))
    parts = np.rint((seen.values - low) * (TOP / (high - low)))
    parts[np.isnan(parts)] = FULL
    pairs[:, 1] = parts
    new = np.ones(len(parts), bool)  # The first and the last point of a signal's line are always sent to the browser.
    np.not_equal(parts[1:-1], parts[:-2], out=new[1:-1])
    return b64encode(pairs[new].tobytes()).decode()


def span(track: Track, seen: Line, per: float = 1.0) -> tuple[float, float]:
    """Return the range of values for the drawing of a signal: 0 to 1 for levels, otherwise multiples of a round step.

    The step is round in a unit of `per` pulses or counts.
    """
    if track.kind not in (COUNT, REAL):
        return 0.0, 1.0
    low = float(np.fmin.reduce(seen.values, initial=np.inf)) / per
    high = float(np.fmax.reduce(seen.values, initial=-np.inf)) / per
    if not isfinite(low) or not isfinite(high):
        return 0.0, 1.0
    if low == high:
        return (low - 1) * per, (high + 1) * per
    grain = _grain(high - low)
    return floor(low / grain) * grain * per, ceil(high / grain) * grain * per


def _grain(size: float) -> float:
    """Return the largest number of the form 1, 2 or 5 × 10ⁿ that is not above a tenth of `size`."""
    power = 10.0 ** floor(log10(size / 10))
    return next((digit * power for digit in (5, 2) if digit * power <= size / 10), power)
