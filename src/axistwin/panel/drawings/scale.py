"""Numbers for people, scales with round steps, and what moves smoothly from one frame to the next."""

from collections.abc import Iterator
from math import ceil, floor, log10
from weakref import ref

from axistwin.bench import Bench
from axistwin.units import S

LONGEST_NS = 1 * S
"""When more virtual time has passed between two frames nobody could follow: things jump."""


def grouped(number: int) -> str:
    """A whole number with thin spaces between its thousands, and a true minus."""
    return f"{number:,}".replace(",", "\u2009").replace("-", "\u2212")


def signed(number: int) -> str:
    """The same with its sign, unless it is 0."""
    return f"+{grouped(number)}" if number > 0 else grouped(number)


def round_step(span: float, most: int) -> int:
    """The smallest of 1, 2, 5, 10, 20, … that divides `span` into not more than `most`."""
    least = max(span / most, 1.0)
    power: int = 10 ** floor(log10(least))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least)


def ticks(first: float, last: float, most: int) -> Iterator[int]:
    """Round numbers from `first` to `last`, 0 among them if it lies there."""
    step = round_step(last - first, most)
    yield from range(ceil(first / step) * step, floor(last) + 1, step)


class Flow:
    """Whether what is shown now follows on what was shown before, so that one can see it move."""

    def __init__(self) -> None:
        self._bench: ref[Bench] = ref(Bench())
        self._ns = 0

    def goes_on(self, bench: Bench) -> bool:
        """False if another bench is there, if time was turned back, or if much has passed."""
        passed_ns = bench.now - self._ns
        same = self._bench() is bench
        if not same:
            self._bench = ref(bench)
        self._ns = bench.now
        return same and 0 <= passed_ns <= LONGEST_NS
