"""Find the moves of a servo axis in its samples."""

from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

from axistwin.core.lazy import NDArray, np
from axistwin.core.units import MS, S
from axistwin.plant.counts import Samples
from axistwin.plant.machine_units import MachineUnits
from axistwin.plant.servo_axis import ServoAxis

if TYPE_CHECKING:
    from collections.abc import Iterator


REST_NS = 80 * MS  # Time in ns without a change of position after which a move has ended.
JITTER = 2  # Largest deviation from the commanded position, in counts, that is not regarded as motion.
WINDOW = 16  # Number of samples for the average of a velocity; one count per sample is already thousands of counts/s.
MOVES = 10_000  # Largest number of stored moves; the oldest are deleted.


@dataclass
class ServoMove:
    """A move of a servo axis, from a standstill or a reversal to the next standstill or reversal."""

    controller: str
    axis: str
    start_ns: int
    origin: int
    target: int
    last_ns: int
    top_rate: float = 0.0  # Highest speed in counts/s, in either direction.
    low: int = 0
    high: int = 0
    commanded: bool = False  # True if the commanded position has moved.
    end_ns: int | None = None  # Virtual time at the end of the move; None while the axis is moving.
    units: MachineUnits | None = None
    unit = "counts"

    @property
    def now_ns(self) -> int:
        return self.last_ns

    @property
    def is_significant(self) -> bool:
        """True if the axis was commanded to move, or if the shaft has moved by more than `JITTER` counts."""
        return self.commanded or self.high - self.low > JITTER


@dataclass
class ServoMoves:
    """The moves of one servo axis.  `forgotten`: True after the oldest moves have been deleted."""

    controller: str
    name: str
    axis: ServoAxis
    moves: deque[ServoMove] = field(default_factory=lambda: deque(maxlen=MOVES))
    forgotten: bool = False

    def __post_init__(self) -> None:
        self._position = self.axis.position
        self._commanded: int | None = None
        self._latest: tuple[int, NDArray[np.int64] | None] = (-1, None)
        """A pair: the time in ns at which the next servo sample is due, and the latest shaft positions."""
        self._direction = 0  # Sign of the commanded velocity: +1, -1, or 0 before the motion begins.
        self._farthest = 0  # Commanded position that is farthest from the start of the present move.

    def add_samples(self, samples: Samples) -> None:
        positions, commanded = (np.asarray(numbers, np.int64) for numbers in (samples.positions, samples.commanded))
        whole = self._with_window(samples, positions)
        before = int(commanded[0]) if self._commanded is None else self._commanded
        shaft_moved = np.diff(positions, prepend=self._position) != 0
        trajectory_moved = np.diff(commanded, prepend=before) != 0
        active = np.flatnonzero(trajectory_moved | (shaft_moved & (np.abs(commanded - positions) > JITTER)))
        if len(active):
            times = samples.start_ns + samples.period_ns * np.arange(len(positions), dtype=np.int64)
            self._find_moves(samples, times, whole, commanded, active)
        self._position, self._commanded = int(positions[-1]), int(commanded[-1])
        if self.moves:
            # The shaft continues to move after the end of the trajectory, until the servo has settled.
            self.moves[-1].target = self._position

    def _with_window(self, samples: Samples, positions: "NDArray[np.int64]") -> "NDArray[np.int64]":
        """Prepend the positions of the previous `WINDOW` samples to the array `positions`, and return the result.

        If the previous positions are unknown, the axis is assumed to have been at rest.
        """
        next_ns, before = self._latest
        if before is None or samples.start_ns != next_ns:
            before = np.full(WINDOW, self._position, np.int64)
        whole: NDArray[np.int64] = np.concatenate((before, positions))
        end_ns = samples.start_ns + len(positions) * samples.period_ns
        self._latest = end_ns if samples.period_ns else -1, whole[-WINDOW:]
        return whole

    def _find_moves(
        self, samples: Samples, times: "NDArray[np.int64]", whole: "NDArray[np.int64]", commanded: "NDArray[np.int64]",
        active: "NDArray[np.int64]",
    ) -> None:  # fmt: skip
        positions = whole[WINDOW:]
        # The list of commanded positions begins with the position before the first sample.
        trajectory = np.concatenate(([commanded[0] if self._commanded is None else self._commanded], commanded))
        for first, end, is_new in self._spans(samples, times, trajectory, active):
            if is_new:
                before = int(positions[first - 1]) if first else self._position
                self._begin_move(int(times[first]) - samples.period_ns, before)
            move = self.moves[-1]
            part = positions[first:end]
            move.low, move.high = min(move.low, int(part.min())), max(move.high, int(part.max()))
            move.target, move.last_ns = int(part[-1]), int(times[end - 1])
            move.commanded |= bool(np.diff(trajectory[first : end + 1]).any())
            if samples.period_ns:
                fastest = int(np.abs(part - whole[first:end]).max())
                move.top_rate = max(move.top_rate, fastest * S / (WINDOW * samples.period_ns))

    def _spans(
        self, samples: Samples, times: "NDArray[np.int64]", trajectory: "NDArray[np.int64]", active: "NDArray[np.int64]"
    ) -> "Iterator[tuple[int, int, bool]]":
        """Yield each time span in which the servo axis moves in one direction.

        The elements are the index of the first sample, the index after the last sample, and True if a new move begins.
        """
        rests = np.flatnonzero(np.diff(times[active]) > REST_NS)
        rested = not self.moves or int(times[active[0]]) - samples.period_ns - self.moves[-1].last_ns > REST_NS
        for begin, last in zip((active[0], *active[rests + 1]), (*active[rests], active[-1]), strict=True):
            if rested:
                self._direction, self._farthest = 0, int(trajectory[begin])
            starts = [int(begin) + turn for turn in self._turns(trajectory[begin : last + 2])]
            if not starts or starts[0] > begin:
                yield int(begin), starts[0] if starts else int(last) + 1, rested
            yield from ((first, end, True) for first, end in pairwise((*starts, int(last) + 1)))
            rested = True

    def _turns(self, trajectory: "NDArray[np.int64]") -> list[int]:
        """Return the indices of reversals in `trajectory`, except those of `JITTER` counts or less."""
        steps = np.diff(trajectory)
        moved = np.flatnonzero(steps)
        signs = np.sign(steps[moved])
        extremes = moved[1:][signs[1:] != signs[:-1]]
        found, at = [], 0
        for index in (*extremes, len(trajectory) - 1):
            beyond = int(trajectory[index]) - self._farthest
            if not self._direction or beyond * self._direction >= 0:
                self._direction = self._direction or int(np.sign(beyond))
            elif abs(beyond) > JITTER:
                found.append(at)
                self._direction = -self._direction
            else:
                continue
            self._farthest, at = int(trajectory[index]), int(index)
        return found

    def _begin_move(self, start_ns: int, before: int) -> None:
        if self.moves:
            self.moves[-1].target = before
        self._close()
        self.forgotten |= len(self.moves) == MOVES
        self.moves.append(
            ServoMove(self.controller, self.name, start_ns, before, before, start_ns, low=before, high=before)
        )
        self.moves[-1].units = self.axis.units

    def _close(self) -> None:
        if self.moves:
            self.moves[-1].end_ns = self.moves[-1].last_ns
            if not self.moves[-1].is_significant:
                self.moves.pop()

    def moves_until(self, now_ns: int) -> list[ServoMove]:
        if self.moves and now_ns - self.moves[-1].last_ns > REST_NS and self.moves[-1].end_ns is None:
            self._close()
        found = [move for move in self.moves if move.is_significant]
        if found and found[-1].end_ns is None and not self.axis.moving:
            found[-1].end_ns = found[-1].last_ns
        return found
