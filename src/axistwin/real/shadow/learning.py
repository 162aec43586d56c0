"""What is usual for a machine: medians, spreads and trends of times, learnt from its first samples."""

from collections import OrderedDict
from math import inf
from statistics import median
from typing import Any

from axistwin.core.units import S

WEIGHT = 0.1  # Weight of a new sample in the exponentially weighted mean.
DAY_NS = 86_400 * S
MOST_DAYS = 8
MOST_KINDS = 300  # Kinds of moves and commands that are remembered; the one unused for longest is forgotten.
LAST = 3
REFINES = 15  # Samples from which an interval is learnt more and more exactly.


class Usual:
    """The usual value of a time in ns: median and spread of the first samples, then a weighted mean for each day.

    `learns`: the number of samples from which the median is taken.
    """

    def __init__(self, learns: int) -> None:
        self.learns, self.first = learns, list[float]()
        self.span = -inf, inf  # What all first samples have in common, if they are intervals.
        self.median, self.spread, self.mean, self.count = 0.0, 0.0, 0.0, 0
        self.days: list[tuple[int, float]] = []
        self.outside: list[bool] = []  # The last verdicts: beyond the tolerance or not.

    @property
    def learnt(self) -> bool:
        return self.count >= self.learns

    def add(self, time_ns: int, low: float, high: float, tolerance: float) -> bool:
        """Add a sample that is between `low` and `high`; return True if it is known to differ.

        It differs if two of the last three samples, or the weighted mean, are outside the tolerance.
        """
        self.count += 1
        middle, nearest = (low + high) / 2, max(low, min(high, self.mean))  # A wide interval says nothing.
        if not self.learnt or self.count == self.learns:
            self.first.append(middle)
            self.span = max(self.span[0], low), min(self.span[1], high)
            self._learn()
            return False
        if self.count <= REFINES and max(self.span[0], low) < min(self.span[1], high):
            self.span = max(self.span[0], low), min(self.span[1], high)
            self._centre()
        deviation = self.beyond(low, high)
        self.mean += WEIGHT * max(-2 * tolerance, min(2 * tolerance, nearest - self.mean))
        self._day(time_ns)
        self.outside = [*self.outside, abs(deviation) > tolerance][-LAST:]
        return (self.outside[-1] and sum(self.outside) > 1) or abs(self.drift) > tolerance

    def beyond(self, low: float, high: float) -> float:
        """Return the certain part of the deviation of an interval."""
        return max(low - self.median, 0.0) or min(high - self.median, 0.0)

    def _learn(self) -> None:
        if self.learnt:
            if self.span[0] < self.span[1]:
                self._centre()
            else:
                self.median = median(self.first)
                self.spread = median(abs(value - self.median) for value in self.first)
            self.mean = self.median
            self.first.clear()

    def _centre(self) -> None:
        low, high = self.span
        self.median = self.mean = (low + high) / 2
        self.spread = (high - low) / 8

    @property
    def drift(self) -> float:
        """The weighted mean minus the learnt median."""
        return self.mean - self.median if self.learnt else 0.0

    @property
    def trend(self) -> float:
        """Change in ns a day, over the last days."""
        if len(self.days) < 2:
            return 0.0
        (first, before), (last, now) = self.days[0], self.days[-1]
        return (now - before) / (last - first)

    def _day(self, time_ns: int) -> None:
        day = time_ns // DAY_NS
        if self.days and self.days[-1][0] == day:
            self.days[-1] = (day, self.mean)
        else:
            self.days = [*self.days, (day, self.mean)][-MOST_DAYS:]

    def as_dict(self) -> dict[str, Any]:
        names = ("learns", "first", "median", "spread", "mean", "count", "days", "span")
        return {name: getattr(self, name) for name in names}

    @classmethod
    def of(cls, stored: dict[str, Any]) -> "Usual":
        made = cls(int(stored["learns"]))
        made.first = [float(value) for value in stored["first"]]
        made.median, made.spread, made.mean = (float(stored[name]) for name in ("median", "spread", "mean"))
        low, high = stored["span"]
        made.span = float(low), float(high)
        made.count, made.days = int(stored["count"]), [(int(day), float(mean)) for day, mean in stored["days"]]
        return made


class Learned:
    """The usual values by key, e.g. `late E` or `move X1000$`; a bounded number of them."""

    def __init__(self) -> None:
        self._usual: OrderedDict[str, Usual] = OrderedDict()

    def usual(self, key: str, learns: int) -> Usual:
        found = self._usual.get(key)
        if found is None:
            found = self._usual[key] = Usual(learns)
            if len(self._usual) > MOST_KINDS:
                self._usual.popitem(last=False)
        self._usual.move_to_end(key)
        return found

    def as_dict(self) -> dict[str, Any]:
        return {key: usual.as_dict() for key, usual in self._usual.items()}

    @classmethod
    def of(cls, stored: dict[str, Any]) -> "Learned":
        """Return what `as_dict` has stored; nothing of it if it is damaged."""
        made = cls()
        try:
            made._usual.update({str(key): Usual.of(value) for key, value in list(stored.items())[-MOST_KINDS:]})
        except (KeyError, TypeError, ValueError, AttributeError):
            made._usual.clear()
        return made

    def moves(self) -> dict[str, Usual]:
        return {key.removeprefix("move "): usual for key, usual in self._usual.items() if key.startswith("move ")}
