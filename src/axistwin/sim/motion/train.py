"""A pulse train: all moves of one step output, in order of time."""

from bisect import bisect_right
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from axistwin.core.errors import UsageError
from axistwin.core.lazy import NDArray, np
from axistwin.core.units import to_seconds
from axistwin.sim.motion.expansion import expand
from axistwin.sim.motion.profile import Profile

HISTORY = 10_000  # Default number of moves that a train stores; earlier moves are discarded to limit memory use.


@dataclass(slots=True)
class Move:
    """A move in one direction.  The move begins at the time `start_ns` and at the net pulse count `origin`."""

    start_ns: int
    direction: int
    profile: Profile
    origin: int

    @property
    def end_ns(self) -> int | None:
        """Time at which the move ends, or None for an endless move."""
        return None if self.profile.end_ns is None else self.start_ns + self.profile.end_ns

    def position_at(self, time_ns: int) -> int:
        return self.origin + self.direction * self.profile.pulses_by(time_ns - self.start_ns)

    def reaches_ns(self, position: int) -> int | None:
        """Return the time at which this net pulse count is reached; None if never, or if it is the start count."""
        n = (position - self.origin) * self.direction
        if n < 1 or (self.profile.pulses is not None and n > self.profile.pulses):
            return None
        return self.start_ns + self.profile.pulse_ns(n)


class Train:
    """The latest moves of a step output, sorted by start time; the net pulse count begins at 0."""

    def __init__(self, history: int = HISTORY) -> None:
        self.moves: deque[Move] = deque([Move(0, +1, Profile(()), 0)], maxlen=history)
        self.forgotten = 0  # Number of moves that are no longer stored.

    @property
    def move(self) -> Move:
        return self.moves[-1]

    def start(self, now_ns: int, direction: int, profile: Profile) -> Move:
        """Begin a new move.  If the previous move is still in progress, end the previous move."""
        if self.moving(now_ns):
            self.replace(self.move.profile.cut(now_ns - self.move.start_ns))
        self.forgotten += len(self.moves) == self.moves.maxlen
        move = Move(now_ns, direction, profile, self.move.position_at(now_ns))
        self.moves.append(move)
        return move

    def replace(self, profile: Profile) -> None:
        """Replace the velocity profile of the latest move.  Both profiles must be equal up to the present time."""
        self.move.profile = profile

    def moving(self, now_ns: int) -> bool:
        return not self.move.profile.over(now_ns - self.move.start_ns)

    def move_at(self, time_ns: int) -> Move:
        starts = [move.start_ns for move in self.moves]
        first = self.moves[0].start_ns
        if time_ns < first and self.forgotten:
            oldest_s, longer_history = to_seconds(first), 2 * len(self.moves)
            raise UsageError(
                f"pulses before {oldest_s:g} s are no longer stored: request later pulses, "
                f"or call Bench.add with history={longer_history}"
            )
        return self.moves[max(0, bisect_right(starts, time_ns) - 1)]

    def pulse_times(self, start_ns: int, stop_ns: int) -> "NDArray[np.int64]":
        """Return the times of all pulses with start_ns <= time < stop_ns, in order."""
        earliest = self.move_at(start_ns).start_ns
        spans = [
            (move, *self._span(move, start_ns, stop_ns)) for move in self.moves if earliest <= move.start_ns < stop_ns
        ]
        times = np.empty(sum(upto - before for _, before, upto in spans), np.int64)
        filled = 0
        for whole, group in groupby(spans, lambda span: span[1] == 0 and span[2] == span[0].profile.pulses):
            if whole:
                moves = list(group)
                end = filled + sum(upto for _, _, upto in moves)
                expand([(move.start_ns, move.profile) for move, _, _ in moves], times[filled:end])
                filled = end
                continue
            for move, before, upto in group:
                move.profile.fill_pulse_times(before + 1, move.start_ns, times[filled : filled + upto - before])
                filled += upto - before
        return times

    def pulse_runs(self, start_ns: int, stop_ns: int) -> "Iterator[tuple[int, NDArray[np.int64]]]":
        """Yield the direction and the pulse times of each move that has pulses in the given time interval."""
        # If a move begins at `start_ns`, the previous move can have its last pulse at the same time.
        earliest = self.move_at(max(start_ns - 1, 0)).start_ns
        for move in self.moves:
            if earliest <= move.start_ns < stop_ns:
                before = self._pulses_before(move, start_ns)
                times = np.empty(self._pulses_before(move, stop_ns) - before, np.int64)
                move.profile.fill_pulse_times(before + 1, move.start_ns, times)
                if len(times):
                    yield move.direction, times

    def _span(self, move: Move, start_ns: int, stop_ns: int) -> tuple[int, int]:
        profile = move.profile
        if profile.pulses is not None and start_ns <= move.start_ns and profile.over(stop_ns - 1 - move.start_ns):
            return 0, profile.pulses
        return self._pulses_before(move, start_ns), self._pulses_before(move, stop_ns)

    @staticmethod
    def _pulses_before(move: Move, time_ns: int) -> int:
        return move.profile.pulses_by(time_ns - 1 - move.start_ns)
