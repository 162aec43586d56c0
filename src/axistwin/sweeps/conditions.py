"""Conditions on signals: `table.output1 high and (|motor.RPE| < 20 or not motor.D low)`."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from axistwin.core.errors import UsageError
from axistwin.core.numbers import real, shortened
from axistwin.sweeps.recording import Recording
from axistwin.sweeps.series import Series, combined

Compare = Callable[[Any], Any]
EXAMPLE = "'table.output1 high' or '|motor.RPE| < 20'"
_SIGNS: dict[str, tuple[Callable[[Any, float], Any], Callable[[Any, float], Any]]] = {
    "<": (np.less, lambda x, c: c - x),
    "<=": (np.less_equal, lambda x, c: c - x),
    ">": (np.greater, lambda x, c: x - c),
    ">=": (np.greater_equal, lambda x, c: x - c),
    "=": (np.equal, lambda x, c: -np.abs(x - c)),
    "!=": (np.not_equal, lambda x, c: np.abs(x - c)),
}
"""Two functions for each comparison sign: one returns the truth of the comparison, one its robustness."""
_TOKEN = re.compile(r"\s*(<=|>=|!=|[()|<>=]|[^\s()|<>=!]+)")


@dataclass(frozen=True)
class Condition:
    """A condition on signals, with functions that return its truth (1 or 0) and its robustness (margin) over time."""

    text: str
    signals: tuple[str, ...]
    truth: Callable[[Recording], Series]
    robustness: Callable[[Recording], Series]


def comparison(sign: str, number: str) -> tuple[Compare, Compare]:
    """Build a condition that compares a signal with a number, e.g. "> 100".

    The result is a pair of functions of the signal's value.  The first function returns 1 (true) or 0 (false).
    The second function returns the margin, e.g. 20 for the value 120.  The margin is negative if the comparison is
    false.
    """
    limit = real(number)
    holds, margin = _SIGNS[sign]
    return lambda x: holds(x, limit).astype(float), lambda x: margin(x, limit)


def _level(high: bool) -> tuple[Compare, Compare]:
    return lambda x: ((x > 0) == high).astype(float), lambda x: np.where((x > 0) == high, np.inf, -np.inf)


def condition(text: str) -> Condition:
    """Parse a condition on signals, e.g. `table.output1 high`.  Raises UsageError for an invalid condition."""
    reader = _Reader(text)
    found = reader.either()
    if reader.tokens:
        raise reader.wrong()
    return found


class _Reader:
    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = _TOKEN.findall(text)

    def wrong(self) -> UsageError:
        place = f" at {self.tokens[0]!r}" if self.tokens else ""
        return UsageError(f"invalid condition {shortened(self.text)}{place}: expected e.g. {EXAMPLE}")

    def take(self, *wanted: str) -> str:
        """Return and remove the next token if `wanted` is empty or contains it; otherwise return ""."""
        return "" if not self.tokens or (wanted and self.tokens[0] not in wanted) else str(self.tokens.pop(0))

    def either(self) -> Condition:
        found = self.both()
        while self.take("or"):
            found = self._joined(found, self.both(), np.maximum)
        return found

    def both(self) -> Condition:
        found = self.single()
        while self.take("and"):
            found = self._joined(found, self.single(), np.minimum)
        return found

    def single(self) -> Condition:
        if self.take("not"):
            inner = self.single()
            return Condition(
                self.text, inner.signals, lambda record: inner.truth(record).map(lambda x: 1 - x),
                lambda record: inner.robustness(record).map(np.negative),
            )  # fmt: skip
        if self.take("("):
            inner = self.either()
            if not self.take(")"):
                raise self.wrong()
            return inner
        return self.atom()

    def atom(self) -> Condition:
        magnitude = bool(self.take("|"))
        name = self.take()
        if not name or name in "()|<>=" or (magnitude and not self.take("|")):
            raise self.wrong()
        series = series_of(name, magnitude=magnitude)
        if level := self.take("high", "low"):
            return self._of(name, series, *_level(level == "high"))
        sign, number = self.take(*_SIGNS), self.take()
        if not sign or not number:
            raise self.wrong()
        return self._of(name, series, *comparison(sign, number))

    def _of(self, name: str, series: Callable[[Recording], Series], truth: Compare, margin: Compare) -> Condition:
        return Condition(
            self.text, (name,), lambda record: series(record).map(truth), lambda record: series(record).map(margin)
        )

    def _joined(self, one: Condition, other: Condition, function: Callable[..., Any]) -> Condition:
        return Condition(
            self.text, (*one.signals, *other.signals),
            lambda record: combined(function, one.truth(record), other.truth(record)),
            lambda record: combined(function, one.robustness(record), other.robustness(record)),
        )  # fmt: skip


def series_of(name: str, *, magnitude: bool) -> Callable[[Recording], Series]:
    """Return a function that returns a recorded signal or, if `magnitude`, its absolute value."""
    if magnitude:
        return lambda record: record.series(name).map(np.abs)
    return lambda record: record.series(name)
