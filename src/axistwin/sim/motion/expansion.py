"""Calculate the pulse times of many complete moves at once.  Most segments of these moves are short, as in ramps.

Pulse k of a segment, from 0, happens at floor(first + k * period) nanoseconds.  With period = p/b, the exact time is a
multiple of 1/b: therefore the floor does not change if a float, whose error is below 1/(2b), is increased by 1/(2b).
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, groupby
from typing import NamedTuple

from axistwin.core.lazy import NDArray, np
from axistwin.core.units import S
from axistwin.sim.motion.profile import Profile

Timed = tuple[int, Profile]  # A complete move: its start in ns, and its profile, which ends.
SEGMENTS = 1 << 14  # Number of segments that are calculated together, to limit memory use.
PIECE = 1 << 13  # Number of pulses whose times are calculated together; the arrays then fit into the processor's cache.
EXACT = (1 << 53) // (6 * S)
"""Limit of pulses * per_rate: the float error, below 3 * 2**-53 * pulses * p / b, is then below 1/(2b)."""
LONG = 1 << 10  # Mean number of pulses per segment above which `Profile.fill_pulse_times` is faster.
BITS = 1 << 62  # Upper limit for integers in NumPy arrays.


class _Segments(NamedTuple):
    pulses: "NDArray[np.int64]"
    base_ns: "NDArray[np.int64]"  # Time of the first pulse of each segment in ns, rounded down.
    rest_ns: "NDArray[np.float64]"  # Fraction of a nanosecond that the rounding has removed, plus 1/(2b).
    period_ns: "NDArray[np.float64]"


def expand(moves: Sequence[Timed], out: "NDArray[np.int64]") -> None:
    """Write the times of all pulses of several moves to the array `out`.  The profile of each move must have an end."""
    moves = _shared(moves)
    seen = Counter(id(profile) for _, profile in moves)
    # The pulse times of a repeated velocity profile are computed only once, and stored here.
    patterns: dict[int, NDArray[np.int64]] = {}
    at = 0
    for repeated, group in groupby(moves, lambda move: seen[id(move[1])] > 1):
        if not repeated:
            at = _expand_single(group, out, at)
            continue
        for start_ns, profile in group:
            pattern = patterns.get(id(profile))
            if pattern is None:
                pattern = patterns[id(profile)] = np.empty(_pulses(profile), np.int64)
                _expand_single(iter([(0, profile)]), pattern, 0)
            np.add(pattern, start_ns, out=out[at : at + len(pattern)])
            at += len(pattern)


def _shared(moves: Sequence[Timed]) -> list[Timed]:
    known: dict[tuple[int, ...], Profile] = {}
    found = []
    for start_ns, profile in moves:
        first = known.setdefault((profile.ticks, profile.parts, *profile.starts[-2:], *profile.phases[::64]), profile)
        same = first is profile or (first.rates, first.starts) == (profile.rates, profile.starts)
        found.append((start_ns, first if same else profile))
    return found


def _pulses(profile: Profile) -> int:
    assert profile.pulses is not None
    return profile.pulses


def _expand_single(moves: Iterator[Timed], out: "NDArray[np.int64]", at: int) -> int:
    """Write the pulse times of moves to `out` from the index `at`; return the index after the last."""
    for method, group in groupby(moves, lambda move: _method(move[1])):
        for batch in _batches(group):
            end = at + sum(_pulses(profile) for _, profile in batch)
            method(batch, out[at:end])
            at = end
    return at


def _batches(moves: Iterator[Timed]) -> Iterator[list[Timed]]:
    batch, segments = [], 0
    for move in moves:
        batch.append(move)
        segments += len(move[1].starts)
        if segments >= SEGMENTS:
            yield batch
            batch, segments = [], 0
    if batch:
        yield batch


def _method(profile: Profile) -> Callable[[Sequence[Timed], "NDArray[np.int64]"], None]:
    pulses = _pulses(profile)
    if pulses * profile.per_rate > EXACT or pulses > LONG * len(profile.starts):
        return _one_by_one
    most = max(profile.starts[-1], profile.parts) * S, profile.phases[-1] * profile.ticks
    return _by_arrays if max(most) < BITS else _by_integers


def _one_by_one(moves: Sequence[Timed], out: "NDArray[np.int64]") -> None:
    at = 0
    for start_ns, profile in moves:
        pulses = _pulses(profile)
        profile.fill_pulse_times(1, start_ns, out[at : at + pulses])
        at += pulses


def _by_arrays(moves: Sequence[Timed], out: "NDArray[np.int64]") -> None:
    """Fill `out` with pulse times by NumPy integers of at most 62 bits."""

    def flat(tables: Iterable[Iterable[int]]) -> "NDArray[np.int64]":
        return np.array(list(chain.from_iterable(tables)), np.int64)

    profiles = [profile for _, profile in moves]
    # The last element of `profile.starts` is the end time of the move.
    lengths = flat([[len(profile.starts) for profile in profiles]])
    origins, ticks, parts, per_rate = (
        np.repeat(flat([numbers]), lengths)
        for numbers in zip(*((at, p.ticks, p.parts, p.per_rate) for at, p in moves), strict=True)
    )
    starts, phases = (flat(profile.starts for profile in profiles), flat(profile.phases for profile in profiles))
    ends = np.cumsum(lengths) - 1
    durations = np.diff(starts, append=0)
    durations[ends] = 1
    # Set the pulse rate of each segment of a move to at least 1, to avoid a division by 0.
    rates = np.maximum(np.diff(phases, append=0) // durations, 1)
    done = phases // parts
    pulses = np.diff(done, append=0)
    pulses[ends] = 0
    start_ns, start_rest = np.divmod(starts * S, ticks)
    first_ns, first_rest = np.divmod(((done + 1) * parts - phases) * S, rates * ticks)
    late_ns, rest = np.divmod(start_rest * rates + first_rest, rates * ticks)
    base_ns = origins + start_ns + first_ns + late_ns
    _fill(_Segments(pulses, base_ns, (rest // ticks + 0.5) / rates, per_rate * S / rates), out)


def _by_integers(moves: Sequence[Timed], out: "NDArray[np.int64]") -> None:
    """Fill `out` with pulse times by Python's integers, which have no limit."""
    rows = []
    for origin_ns, profile in moves:
        ticks, parts = profile.ticks, profile.parts
        for j, rate in enumerate(profile.rates):
            done = profile.phases[j] // parts
            if pulses := profile.phases[j + 1] // parts - done:
                first = profile.starts[j] * S * rate + ((done + 1) * parts - profile.phases[j]) * S
                first_ns, rest = divmod(first, rate * ticks)
                rows.append((pulses, origin_ns + first_ns, (rest // ticks + 0.5) / rate, profile.per_rate * S / rate))
    if rows:
        _fill(_Segments(*(np.array(column) for column in zip(*rows, strict=True))), out)


def _fill(segments: _Segments, out: "NDArray[np.int64]") -> None:
    ends = np.cumsum(segments.pulses)
    firsts = ends - segments.pulses
    j, at = 0, 0
    while at < len(out):
        following = max(j + 1, int(np.searchsorted(ends, at + PIECE, side="right")))
        piece = slice(j, following)
        pulses, end = segments.pulses[piece], int(ends[following - 1])
        times = np.arange(at, end, dtype=np.float64)
        times -= np.repeat(firsts[piece].astype(np.float64), pulses)
        times *= np.repeat(segments.period_ns[piece], pulses)
        times += np.repeat(segments.rest_ns[piece], pulses)
        out[at:end] = times  # The assignment rounds the pulse times down, because the array contains integers.
        out[at:end] += np.repeat(segments.base_ns[piece], pulses)
        j, at = following, end
