"""Format numbers, choose round numbers for scales, and decide whether a drawing moves smoothly."""

from collections.abc import Iterator
from math import ceil, floor, log10
from weakref import ref

from axistwin.bench import Bench
from axistwin.core.units import S
from axistwin.plant.axes import Axis

FAR = 1 << 40  # A shadow's limit switches, whose places are unknown, are farther apart.
LONGEST_NS = 1 * S  # Longest virtual time between two frames for a smooth movement; after a longer time, drawings jump.


def grouped(number: int) -> str:
    """Format an integer with thin spaces between thousands, and with `−` (U+2212) as the minus sign."""
    return f"{number:,}".replace(",", "\u2009").replace("-", "\u2212")


def minus(text: str) -> str:
    """Return a number as text with `−` (U+2212) as the minus sign."""
    return text.replace("-", "\u2212")


def signed(number: int) -> str:
    """Format an integer with thin spaces between thousands and with its sign, `+` or `−` (U+2212)."""
    return f"+{grouped(number)}" if number > 0 else grouped(number)


def round_step(span: float, most: int) -> int:
    """Return the smallest of 1, 2, 5, 10, 20, … that divides `span` into at most `most` parts."""
    least = max(span / most, 1.0)
    power: int = 10 ** floor(log10(least))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least)


def ticks(first: float, last: float, most: int) -> Iterator[int]:
    """Yield at most `most` + 1 multiples of a round step from `first` to `last`."""
    step = round_step(last - first, most)
    yield from range(ceil(first / step) * step, floor(last) + 1, step)


def travel(axis: Axis) -> tuple[int, int] | None:
    """Return the limits of an axis; None if it has none, or none that a drawing can show."""
    limits = axis.limits
    return None if limits is None or limits[1] - limits[0] > FAR else limits


class Flow:
    """Decides whether a drawing moves smoothly or jumps to its new state."""

    def __init__(self) -> None:
        self._bench: ref[Bench] = ref(Bench())
        self._ns = 0

    def is_smooth(self, bench: Bench) -> bool:
        """True unless the bench was replaced or more than `LONGEST_NS` has passed since the last call."""
        passed_ns = bench.now - self._ns
        same = self._bench() is bench
        if not same:
            self._bench = ref(bench)
        self._ns = bench.now
        return same and 0 <= passed_ns <= LONGEST_NS
