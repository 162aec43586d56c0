"""Pairs each answer of the machine with the twin's: by the request that it answers, and by order."""

from collections import deque
from collections.abc import Callable

from axistwin.core.units import MS, S
from axistwin.real.shadow.talk import Answer, Asked, Command

PATIENCE_NS = 2 * S  # Time after which an answer without a partner has none.
MOVED_ON_NS = 150 * MS  # The same, if the host has asked something else meanwhile.
MOST_WAITING = 64


class Side:
    """The machine or the twin: the answers that it owes, and those without a partner yet."""

    def __init__(self) -> None:
        self.owed: deque[Asked] = deque(maxlen=MOST_WAITING)
        self.waiting: deque[Answer] = deque(maxlen=MOST_WAITING)

    def clear(self) -> None:
        self.owed.clear()
        self.waiting.clear()

    def take(
        self, time_ns: int, data: bytes, speed: float = 0.0, busy: bool = False, total: int = 0, left: int = 0
    ) -> Answer:  # fmt: skip
        """Add an answer, to the request that waits for longest."""
        asked = self.owed.popleft() if self.owed else None
        answer = Answer(time_ns, data, asked, speed, busy, total, left)
        self.waiting.append(answer)
        return answer


class Pairing:
    """Calls `both(machine, twin)` for each pair, and `alone(answer, ours)` for an answer without a partner."""

    def __init__(self, both: Callable[[Answer, Answer], object], alone: Callable[[Answer, bool], object]) -> None:
        self._both, self._alone = both, alone
        self.machine, self.twin = Side(), Side()
        self._number = 0

    def clear(self) -> None:
        self.machine.clear()
        self.twin.clear()

    def ask(self, time_ns: int, command: Command, *, echo: bool) -> None:
        """Note a command; a request that the host has given up is no longer owed."""
        self._number += 1
        for _ in range(echo):
            self._owe(Asked(self._number, command, time_ns, echo=True))
        for _ in range(command.answers):
            self._owe(Asked(self._number, command, time_ns))

    def _owe(self, asked: Asked) -> None:
        for side, other in ((self.machine, self.twin), (self.twin, self.machine)):
            while side.owed and self._given_up(side.owed[0], other, asked.time_ns):
                side.owed.popleft()
            side.owed.append(asked)

    @staticmethod
    def _given_up(owed: Asked, other: Side, now_ns: int) -> bool:
        answered = any(answer.asked is owed and now_ns - answer.time_ns > MOVED_ON_NS for answer in other.waiting)
        return answered or now_ns - owed.time_ns > PATIENCE_NS

    def pair(self, now_ns: int) -> None:
        ours, theirs = self.twin.waiting, self.machine.waiting
        while ours and theirs:
            mine, other = ours[0], theirs[0]
            order = _order(other, mine)
            unasked = mine.asked is None or other.asked is None
            if order == 0 or (unasked and other.data == mine.data):
                ours.popleft()
                theirs.popleft()
                self._both(other, mine)
            elif order > 0:
                self._alone(ours.popleft(), True)
            else:
                self._alone(theirs.popleft(), False)
        for side, mine_too in ((ours, True), (theirs, False)):
            while side and now_ns - side[0].time_ns > PATIENCE_NS:
                self._alone(side.popleft(), mine_too)


def _order(machine: Answer, twin: Answer) -> int:
    """Return 0 if both answer the same request, 1 if the machine's is to a later one, -1 if the twin's is."""
    if machine.asked is None or twin.asked is None:
        return (machine.asked is None) - (twin.asked is None) if machine.asked is not twin.asked else 0
    first, second = ((it.number, not it.echo) for it in (machine.asked, twin.asked))
    return (first > second) - (first < second)
