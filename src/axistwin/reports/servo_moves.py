"""Find the moves of a servo axis in its samples."""

from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from axistwin.plant.counts import Samples
from axistwin.plant.machine_units import MachineUnits
from axistwin.plant.servo_axis import ServoAxis
from axistwin.units import MS, S

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

REST_NS = 80 * MS
"""Time in ns without a change of position after which a move has ended."""
JITTER = 2
"""Largest deviation from the commanded position, in counts, that is not regarded as motion."""
WINDOW = 16
"""Number of samples for the average of a velocity; one count per sample is already thousands of counts/s."""
MOVES = 10_000
"""Largest number of stored moves; the oldest are deleted."""


@dataclass
class ServoMove:
    """A move of a servo axis, from one rest to the next.  `end_ns`: None while the axis is moving."""

    controller: str
    axis: str
    start_ns: int
    origin: int
    target: int
    last_ns: int
    top_rate: float = 0.0
    """Highest speed in counts/s, in either direction."""
    low: int = 0
    high: int = 0
    commanded: bool = False
    """True if the commanded position has moved."""
    end_ns: int | None = None
    units: MachineUnits | None = None
    unit = "counts"

    @property
    def now_ns(self) -> int:
        """Time of the latest position of the move."""
        return self.last_ns

    @property
    def is_significant(self) -> bool:
        """True if the commanded position has moved, or if the motion is more than `JITTER`."""
        return self.commanded or self.high - self.low > JITTER


@dataclass
class ServoMoves:
    """The moves of one servo axis.  `forgotten`: True if old moves have been deleted."""

    controller: str
    name: str
    axis: ServoAxis
    moves: deque[ServoMove] = field(default_factory=lambda: deque(maxlen=MOVES))
    forgotten: bool = False

    def __post_init__(self) -> None:
        self._position = self.axis.position
        self._commanded: int | None = None
        # time of the next sample, and the last `WINDOW` positions
        self._latest: tuple[int, NDArray[np.int64] | None] = (-1, None)

    def add_samples(self, samples: Samples) -> None:
        """Find the moves in the next block of samples."""
        import numpy as np

        positions, commanded = (np.asarray(numbers, np.int64) for numbers in (samples.positions, samples.commanded))
        whole = self._with_window(samples, positions)
        before = int(commanded[0]) if self._commanded is None else self._commanded
        shaft_moved = np.diff(positions, prepend=self._position) != 0
        trajectory_moved = np.diff(commanded, prepend=before) != 0
        active = np.flatnonzero(trajectory_moved | (shaft_moved & (np.abs(commanded - positions) > JITTER)))
        if len(active):
            times = samples.start_ns + samples.period_ns * np.arange(len(positions), dtype=np.int64)
            self._find_moves(samples, times, whole, trajectory_moved, active)
        self._position, self._commanded = int(positions[-1]), int(commanded[-1])
        if self.moves:
            self.moves[-1].target = self._position  # the target changes while the servo settles after the move

    def _with_window(self, samples: Samples, positions: "NDArray[np.int64]") -> "NDArray[np.int64]":
        """Return the positions of a block, preceded by the last `WINDOW` positions before the block.

        If the samples before the block are unknown, the axis is assumed to have been at rest.
        """
        import numpy as np

        next_ns, before = self._latest
        if before is None or samples.start_ns != next_ns:
            before = np.full(WINDOW, self._position, np.int64)
        whole: NDArray[np.int64] = np.concatenate((before, positions))
        end_ns = samples.start_ns + len(positions) * samples.period_ns
        self._latest = end_ns if samples.period_ns else -1, whole[-WINDOW:]
        return whole

    def _find_moves(
        self,
        samples: Samples,
        times: "NDArray[np.int64]",
        whole: "NDArray[np.int64]",
        trajectory_moved: "NDArray[np.bool_]",
        active: "NDArray[np.int64]",
    ) -> None:
        """Find the moves in a block; `whole`: result of `_with_window`, `active`: indices of samples with motion."""
        import numpy as np

        positions = whole[WINDOW:]
        ends = np.flatnonzero(np.diff(times[active]) > REST_NS)
        for first, last in zip((active[0], *active[ends + 1]), (*active[ends], active[-1]), strict=True):
            before = int(positions[first - 1]) if first else self._position
            move = self._move(int(times[first]) - samples.period_ns, before)
            part = positions[first : last + 1]
            move.low, move.high = min(move.low, int(part.min())), max(move.high, int(part.max()))
            move.target, move.last_ns = int(part[-1]), int(times[last])
            move.commanded |= bool(trajectory_moved[first : last + 1].any())
            if samples.period_ns:
                fastest = int(np.abs(part - whole[first : last + 1]).max())
                move.top_rate = max(move.top_rate, fastest * S / (WINDOW * samples.period_ns))

    def _move(self, start_ns: int, before: int) -> ServoMove:
        """Return the present move, or a new move if the last move ended more than `REST_NS` ago."""
        if self.moves and start_ns - self.moves[-1].last_ns <= REST_NS:
            return self.moves[-1]
        if self.moves:
            self.moves[-1].target = before
        self._close()
        self.forgotten |= len(self.moves) == MOVES
        self.moves.append(
            ServoMove(self.controller, self.name, start_ns, before, before, start_ns, low=before, high=before)
        )
        self.moves[-1].units = self.axis.units
        return self.moves[-1]

    def _close(self) -> None:
        """End the latest move; delete the move if its motion is only jitter."""
        if self.moves:
            self.moves[-1].end_ns = self.moves[-1].last_ns
            if not self.moves[-1].is_significant:
                self.moves.pop()

    def moves_until(self, now_ns: int) -> list[ServoMove]:
        """Return all stored moves up to the time `now_ns`."""
        if self.moves and now_ns - self.moves[-1].last_ns > REST_NS and self.moves[-1].end_ns is None:
            self._close()
        found = [move for move in self.moves if move.is_significant]
        if found and found[-1].end_ns is None and not self.axis.moving:
            found[-1].end_ns = found[-1].last_ns
        return found
