"""Compare the motion of two traces whose controllers, names and hosts differ: paths, end points and times of moves.

A move is the time in which at least one of the compared axes moves.  Positions count from the begin of each trace.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from axistwin.core.errors import UsageError, most_similar
from axistwin.core.lazy import NDArray, np
from axistwin.core.units import MS
from axistwin.plant.machine_units import MachineUnits
from axistwin.records.traces.differences import Tolerance, apart, moments
from axistwin.records.traces.reading import Trace, Track
from axistwin.records.traces.signals import COUNT, UNITS

if TYPE_CHECKING:
    Times = NDArray[np.int64]
    Values = NDArray[np.float64]

Span = tuple[int, int]
POSITIONS = ("pulses", "position")  # The signal of a stepper's and of a servo's position.
REST_NS = 100 * MS  # Time without a change after which an axis without the signal `velocity` is at rest.


@dataclass(frozen=True)
class AxisPath:
    """Positions of an axis, `values[n]` from `times[n]` on, in pulses, counts or the units of its scene."""

    name: str
    times: "Times"
    values: "Values"
    moving: Sequence[Span]
    unit: str
    decimals: int

    def part(self, since_ns: int, before_ns: int) -> "tuple[Times, Values]":
        """Return the positions of a time span, beginning with that before it; their times count from its begin."""
        first, last = np.searchsorted(self.times, (since_ns, before_ns))
        before = self.values[max(first - 1, 0)]
        times, values = self.times[first:last] - since_ns, self.values[first:last]
        return np.concatenate(([0], times)), np.concatenate(([before], values))


class Leg(NamedTuple):
    """A move of an axis, with its figures in both traces."""

    move: int
    axes: tuple[AxisPath, AxisPath]
    begin_ns: tuple[int, int]
    lasted_ns: tuple[int, int]
    ends: tuple[float, float]
    apart: float  # Largest distance of the paths, beyond the tolerated time.
    apart_ns: int  # Time of this distance in the first trace.

    @property
    def late_ns(self) -> int:
        return abs(self.lasted_ns[0] - self.lasted_ns[1])

    def differs(self, tolerance: Tolerance) -> bool:
        return self.apart > tolerance.value or self.late_ns > tolerance.time_ns


@dataclass(frozen=True)
class Motion:
    """Result of a comparison; `moves`: their spans in both traces, `end_ns`: the end of the longer trace."""

    axes: Sequence[tuple[AxisPath, AxisPath]]
    moves: tuple[Sequence[Span], Sequence[Span]]
    end_ns: int
    legs: Sequence[Leg]
    by_move: bool  # False: there is one move, the whole trace.

    def broken(self, tolerance: Tolerance) -> list[Leg]:
        """Return the moves of axes that differ by more than the tolerance."""
        return [leg for leg in self.legs if leg.differs(tolerance)]

    def aligned(self, path: AxisPath) -> "tuple[Times, Values]":
        """Return an axis of the second trace, with its moves where the first trace has them."""
        times, values = [np.zeros(1, np.int64)], [path.values[:1]]
        for (begin, until), span in zip(*(_spans(moves, self.end_ns) for moves in self.moves), strict=False):
            after, positions = path.part(*span)
            seen = after < until - begin
            times.append(after[seen] + begin)
            values.append(positions[seen])
        return np.concatenate(times), np.concatenate(values)


def compare_motion(first: Trace, second: Trace, time_ns: int, *, by_move: bool = False, names: str = "") -> Motion:
    """Compare the positions of pairs of axes, with changes up to `time_ns` early or late.

    `names`: the pairs, e.g. "X=0,Y=1"; by default those of the same name, else in their order.  `by_move`: each move
    is compared from its own begin on, so that pauses may differ.  Raises UsageError for axes that cannot be paired.
    """
    axes = _pairs(first, second, names)
    end_ns = max(first.end_ns, second.end_ns)
    whole: list[Span] = [(0, end_ns)]
    one, other = (_joined(span for pair in axes for span in pair[side].moving) if by_move else whole for side in (0, 1))
    legs = []
    for number, ranges in enumerate(zip(_spans(one, end_ns), _spans(other, end_ns), strict=False)):
        for pair in axes:
            parts = [path.part(*span) for path, span in zip(pair, ranges, strict=True)]
            if any(np.ptp(values) for _, values in parts):
                legs.append(_leg(number + 1, pair, (one[number], other[number]), parts, time_ns))
    if not legs and len(one) == len(other):
        raise UsageError(f"nothing to compare: {', '.join(path.name for path, _ in axes)} never moves in both traces")
    return Motion(axes, (one, other), end_ns, legs, by_move)


def _spans(moves: Sequence[Span], end_ns: int) -> Iterator[Span]:
    """Yield the time from the begin of each move to that of the next one."""
    return pairwise([*(begin for begin, _ in moves), end_ns + 1])


def _leg(
    number: int,
    axes: tuple[AxisPath, AxisPath],
    spans: Sequence[Span],
    parts: "Sequence[tuple[Times, Values]]",
    time_ns: int,
) -> Leg:
    one, other = parts
    at = moments(one[0], other[0], time_ns)
    distances = np.maximum(apart(at, one, other, time_ns), apart(at, other, one, time_ns))
    worst = int(np.argmax(distances))
    (begin, end), (begin_2, end_2) = spans
    ends = float(one[1][-1]), float(other[1][-1])
    return Leg(
        number, axes, (begin, begin_2), (end - begin, end_2 - begin_2), ends, float(distances[worst]),
        begin + int(at[worst]),
    )  # fmt: skip


# Axes and their moves


def _pairs(first: Trace, second: Trace, names: str) -> list[tuple[AxisPath, AxisPath]]:
    one, other = _paths(first), _paths(second)
    if names:
        pairs = [(_named(one, a, first), _named(other, b, second)) for a, b in _split(names)]
    else:
        pairs = _found(one, other, (first.path.name, second.path.name))
    for pair in pairs:
        if pair[0].unit != pair[1].unit:
            raise UsageError(
                f"{pair[0].name} is in {pair[0].unit}, {pair[1].name} in {pair[1].unit}: "
                "give both axes the same `units` in their scenes, or none"
            )
    return pairs


def _found(
    one: dict[str, AxisPath], other: dict[str, AxisPath], files: tuple[str, str]
) -> list[tuple[AxisPath, AxisPath]]:
    short = [{name.rpartition(".")[2]: path for name, path in paths.items()} for paths in (one, other)]
    for all_one, all_other in ((one, other), short):
        moved = [
            name for name in {**all_one, **all_other} if any(name in m and m[name].moving for m in (all_one, all_other))
        ]
        unique = (len(all_one), len(all_other)) == (len(one), len(other))
        if moved and unique and all(name in all_one and name in all_other for name in moved):
            return [(all_one[name], all_other[name]) for name in moved]
    moving = [[path for path in paths.values() if path.moving] for paths in (one, other)]
    if len(moving[0]) == len(moving[1]) > 0:
        return list(zip(*moving, strict=True))
    told = (
        f"{', '.join(path.name for path in paths) or 'no axis'} in {f}" for paths, f in zip(moving, files, strict=True)
    )
    raise UsageError(f"cannot pair the axes that move: {' and '.join(told)}; name the pairs, e.g. --axes X=0,Y=1")


def _split(names: str) -> Iterator[tuple[str, str]]:
    for text in names.split(","):
        one, equals, other = (part.strip() for part in text.partition("="))
        if not (one and equals and other):
            raise UsageError(f"invalid pair of axes {text!r}: expected names with =, e.g. --axes X=0,Y=1")
        yield one, other


def _named(paths: dict[str, AxisPath], wanted: str, trace: Trace) -> AxisPath:
    found = [path for name, path in paths.items() if wanted in (name, name.rpartition(".")[2])]
    if len(found) == 1:
        return found[0]
    close = most_similar(wanted, [*paths]) if not found else ""
    hint = f"did you mean {close}?" if close else f"expected one of {', '.join(paths) or 'none'}"
    raise UsageError(f"{'several axes are called' if found else 'no axis'} {wanted!r} in {trace.path.name}: {hint}")


def _paths(trace: Trace) -> dict[str, AxisPath]:
    found = {}
    for full, track in trace.tracks.items():
        name, _, signal = full.rpartition(".")
        if signal in POSITIONS and "." in name and track.kind == COUNT:
            units = trace.about.get(f"units {name}")
            times, counts = track.columns()
            made = MachineUnits.written(units) if units else None
            values = (counts - counts[0]) / float(made.per if made else 1)
            unit, decimals = (made.of, made.decimals) if made else (UNITS[signal, COUNT], 0)
            found[name] = AxisPath(name, times, values, _moving(trace, name, track), unit, decimals)
    return found


def _moving(trace: Trace, name: str, positions: Track) -> list[Span]:
    if velocity := trace.tracks.get(f"{name}.velocity"):
        edges = [*velocity.times, trace.end_ns]
        return _joined(span for span, rate in zip(pairwise(edges), velocity.values, strict=True) if rate)
    changes = trace.tracks.get(f"{name}.commanded", positions).times[1:]
    return _joined(((time_ns, time_ns) for time_ns in changes), REST_NS)


def _joined(spans: Iterable[Span], rest_ns: int = 0) -> list[Span]:
    joined: list[Span] = []
    for begin, end in sorted(spans):
        if joined and begin <= joined[-1][1] + rest_ns:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((begin, end))
    return joined
