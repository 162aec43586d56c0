"""What is left of something that several defects take from: the worst of them counts."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(eq=False)
class _Weakness:
    left: float


class Weaknesses:
    """`before_change` is called while what is left is still as it was, `on_change` when it has changed."""

    def __init__(self, on_change: Callable[[], None], before_change: Callable[[], None] = lambda: None) -> None:
        self._on_change, self._before_change = on_change, before_change
        self._those: list[_Weakness] = []

    @property
    def left(self) -> float:
        """0 to 1; 1: all of it."""
        return min((one.left for one in self._those), default=1.0)

    def add(self, left: float) -> Callable[[], None]:
        """One more.  Returns what ends it."""
        one = _Weakness(left)
        self._before_change()
        self._those.append(one)
        self._on_change()
        return lambda: self._end(one)

    def _end(self, one: _Weakness) -> None:
        self._before_change()
        self._those.remove(one)
        self._on_change()
