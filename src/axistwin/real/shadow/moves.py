"""Moves of the twin and of the machine: how long they take, seen through the answers to a polling host."""

from collections import deque
from collections.abc import Callable
from math import sqrt
from typing import NamedTuple

from axistwin.core.units import MS, S
from axistwin.real.shadow.learning import REFINES, Learned, Usual
from axistwin.real.shadow.talk import Command

LEARNS = 5
SHORTEST_NS = 100 * MS  # Shorter moves are not judged.
SAME_NS = 30 * MS  # Pause between two motions of the same command.
OVERDUE_NS = 1 * S
RELATIVE = 0.004  # Part of a duration that is always permitted; a clock of 200 ppm is far within.
POOLED, SIGMAS = 12, 5
EVERY = Command("moves", "", b"")
WIDEST_NS = 2 * S


class Timed(NamedTuple):
    """A move that both have ended.  `low` and `high`: the machine's end minus the twin's."""

    kind: str
    command: Command
    began_ns: int
    duration_ns: int
    low_ns: int
    high_ns: int

    @property
    def middle_ns(self) -> int:
        return (self.low_ns + self.high_ns) // 2


class Move:
    """A motion of the twin, and what is known of the machine's."""

    def __init__(self, command: Command, began_ns: int) -> None:
        self.command, self.began_ns = command, began_ns
        self.ended_ns: int | None = None
        self.last_busy_ns: int | None = None
        self.clear_ns: int | None = None
        self.excused = self.told = False


class Moves:
    """Follows one move after the other.  `differs(words, timed)` is called for one whose duration is unusual."""

    def __init__(
        self, learned: Learned, tolerance_ns: int, timed: Callable[[Timed], object],
        differs: Callable[[str, Command, int], object],
    ) -> None:  # fmt: skip
        self._learned, self._tolerance_ns, self._timed, self._differs = learned, tolerance_ns, timed, differs
        self._pooled: deque[tuple[float, float]] = deque(maxlen=POOLED)  # Deviations in ns, and their variances.
        self.now: Move | None = None
        self.command: Command | None = None  # The last command that may begin a motion.
        self.edges: deque[tuple[int, bool]] = deque([(0, False)], maxlen=64)  # Changes of the twin's state.
        self.cleared_ns = 0  # When the machine said that it had ended the last finished move.
        self.says_busy = False  # The machine's last word about its motion.
        self.trusted = True  # False while settings from before the twin's beginning may differ.

    def start(self, command: Command) -> None:
        if self.now is not None and self.now.ended_ns is not None:
            self._finish()
        self.command = command

    def twin(self, now_ns: int, busy: bool, ended_ns: int | None) -> None:
        """Note the state of the twin.  `ended_ns`: the exact end of its motion, if it has ended and is known."""
        if busy is not self.edges[-1][1]:
            self.edges.append((now_ns if busy or ended_ns is None else min(ended_ns, now_ns), busy))
            if busy:
                self._began(now_ns)
            elif self.now is not None:
                self.now.ended_ns = self.edges[-1][0]
        move = self.now
        if move is not None and move.ended_ns is not None and now_ns - move.ended_ns > SAME_NS:
            self._judge_late(move, now_ns)

    def _began(self, now_ns: int) -> None:
        move = self.now
        same = move is not None and move.command is self.command
        if same and move is not None and move.ended_ns is not None and now_ns - move.ended_ns <= SAME_NS:
            move.ended_ns = None
            return
        if move is not None:
            self._finish()
        if self.command is not None:
            self.now = Move(self.command, now_ns)

    def machine(self, time_ns: int, busy: bool) -> None:
        """Note the machine's own words about its motion, at the time of the request."""
        move, self.says_busy = self.now, busy
        if move is None or time_ns < move.began_ns:
            return
        if busy:
            move.last_busy_ns, move.clear_ns = time_ns, None
        elif move.clear_ns is None and (move.last_busy_ns is not None or time_ns - move.began_ns > 50 * MS):
            move.clear_ns = time_ns
        if move.ended_ns is not None and move.clear_ns is not None and time_ns - move.ended_ns > SAME_NS:
            self._finish()

    def hurried(self, now_ns: int, left_ns: int) -> None:
        """The twin's motion was cut short by `left_ns`, as the machine's settings are not known."""
        if self.now is not None:
            self.now.ended_ns = now_ns + left_ns
        self.edges.append((now_ns, False))

    def excuse(self) -> None:
        """A person or a switch has ended this move: its duration says nothing."""
        if self.now is not None:
            self.now.excused = True

    def machine_busy(self) -> bool:
        """True if the machine has last said that it works on the present move."""
        return self.now is not None and self.now.last_busy_ns is not None and self.now.clear_ns is None

    def moved(self, since_ns: int, until_ns: int) -> bool:
        """True if the twin was busy, or began or ended a motion, in this time."""
        return any(busy for busy in self._states(since_ns, until_ns))

    def was(self, busy: bool, since_ns: int, until_ns: int) -> bool:
        """True if the twin had this state at some time of these."""
        return busy in self._states(since_ns, until_ns)

    def _states(self, since_ns: int, until_ns: int) -> set[bool]:
        found, before = set[bool](), False
        for time_ns, busy in self.edges:
            if time_ns < since_ns:
                before = busy
            elif time_ns <= until_ns:
                found.add(busy)
        return found | {before}

    def _judge_late(self, move: Move, now_ns: int) -> None:
        """Tell about a machine that is still busy long after the twin, or ended long before."""
        assert move.ended_ns is not None
        if move.clear_ns is not None:
            self._finish()
        elif move.last_busy_ns is not None and not (move.excused or move.told):
            over_ns, duration_ns = move.last_busy_ns - move.ended_ns, move.ended_ns - move.began_ns
            usual = self._learned.usual(f"move {_kind(move.command, duration_ns)}", LEARNS)
            if not self.trusted and not usual.learnt:
                return
            if over_ns - max(usual.median, 0) > OVERDUE_NS + duration_ns // 5:
                move.told = True
                self._differs(
                    f"{move.command.text} still moves {over_ns / S:.1f} s after the twin", move.command, now_ns
                )

    def _finish(self) -> None:
        move, self.now = self.now, None
        if move is None or move.ended_ns is None or move.clear_ns is None or move.excused or move.told:
            return
        duration_ns, self.cleared_ns = move.ended_ns - move.began_ns, move.clear_ns
        busy_ns = move.began_ns if move.last_busy_ns is None else move.last_busy_ns
        timed = Timed(
            _kind(move.command, duration_ns), move.command, move.began_ns, duration_ns,
            busy_ns - move.ended_ns, move.clear_ns - move.ended_ns,
        )  # fmt: skip
        if timed.high_ns - timed.low_ns > max(WIDEST_NS, duration_ns // 2) or duration_ns < SHORTEST_NS:
            return
        self._timed(timed)
        self._judge(timed)

    def _judge(self, timed: Timed) -> None:
        usual, low, high = self._learned.usual(f"move {timed.kind}", LEARNS), timed.low_ns, timed.high_ns
        tolerance = max(self._tolerance_ns, RELATIVE * timed.duration_ns) + 4 * usual.spread
        if not usual.learnt and self.trusted and usual.count + 1 >= LEARNS:
            self._judge_first(timed, usual, tolerance)
        beyond_ns = usual.beyond(low, high)
        if usual.add(timed.began_ns, low, high, tolerance):
            by_ns = usual.drift if abs(usual.drift) > abs(beyond_ns) else beyond_ns
            words = _words(timed, by_ns, "than usual", usual.median)
            self._differs(words, timed.command, timed.began_ns + timed.duration_ns)
        if usual.count > REFINES:
            self._pool(timed, usual)

    def _pool(self, timed: Timed, usual: Usual) -> None:
        """All moves together show less than the polling of one does."""
        half_ns = (timed.high_ns - timed.low_ns) / 2
        off_ns = timed.middle_ns - usual.median
        most_ns = half_ns + 4 * self._tolerance_ns
        self._pooled.append((max(-most_ns, min(most_ns, off_ns)), half_ns**2 / 3 + (self._tolerance_ns / 5) ** 2))
        count = len(self._pooled)
        by_ns = sum(off for off, _ in self._pooled) / count
        noise_ns = sqrt(sum(variance for _, variance in self._pooled)) / count
        # A host that polls at a fixed pace after its command sees every move in the same phase.
        phase_ns = sqrt(sum(variance for _, variance in self._pooled) * 3 / count)
        if count == POOLED and abs(by_ns) > max(SIGMAS * noise_ns, self._tolerance_ns / 2, phase_ns):
            how = "longer" if by_ns > 0 else "shorter"
            words = f"moves take {abs(by_ns) / MS:.0f} ms {how} than usual, the mean of the last {POOLED}"
            self._differs(words, EVERY._replace(section=timed.command.section), timed.began_ns + timed.duration_ns)

    def _judge_first(self, timed: Timed, usual: Usual, tolerance: float) -> None:
        """A machine that was worn from the beginning: all first moves took longer than the manual says."""
        by_ns = min([*usual.first, timed.low_ns], key=abs)
        same = all(value * by_ns > 0 for value in (*usual.first, timed.low_ns))
        if same and abs(by_ns) > max(3 * tolerance, 0.03 * timed.duration_ns):
            self._differs(_words(timed, by_ns, "than the twin"), timed.command, timed.began_ns + timed.duration_ns)


def _words(timed: Timed, by_ns: float, than: str, usual_ns: float = 0.0) -> str:
    """`usual_ns`: by how much the move usually takes longer than the twin's."""
    longer, percent = "longer" if by_ns > 0 else "shorter", 100 * abs(by_ns) / max(timed.duration_ns + usual_ns, MS)
    return f"{timed.command.text} takes {abs(by_ns) / MS:.0f} ms ({percent:.1f} %) {longer} {than}"


def _kind(command: Command, duration_ns: int) -> str:
    return f"{command.text} {float(f'{duration_ns / S:.2g}'):g} s"
