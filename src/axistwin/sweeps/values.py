"""Parse the values of a varied path: `1..5`, `0.05..0.4:8`, `1..1000:4:log`, `[a, b]`, `normal(m, s)`, `uniform(a, b)`.

A grid runs the listed values.  A random design draws values from the whole interval between `a` and `b`.
"""

import re
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import exp, log, sqrt
from statistics import NormalDist
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, check_values, real, shortened, whole

Value = Any  # A value in a scene file: a number, a text or a list.
MOST = 1_000_000  # Largest number of values of one path.
EXAMPLES = "1..5, 0.05..0.4:8, 1..1000:4:log, [1, 2], normal(1, 0.1), uniform(0, 1) or triangular(0, 1, 3)"
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(rf"(?P<low>{_NUMBER})\.\.(?P<high>{_NUMBER})(?::(?P<count>\d+))?(?P<log>:log)?", re.ASCII)
_DRAWN = re.compile(r"(?P<name>[a-z]+)\((?P<given>[^()]*)\)")
_WHOLE = re.compile(r"[+-]?\d+", re.ASCII)


@dataclass(frozen=True)
class Values:
    """The values of one setting in a sweep; `listed`: those of a grid, empty for random ones."""

    text: str
    listed: Sequence[Value]
    at: Callable[[float], Value]
    """Function that returns the value at a fraction of the distribution; 0 <= fraction < 1."""
    interval: tuple[float, float, bool] | None = None
    """Both ends of a range, and True for a logarithmic range; the ends are integers in a range of integers."""
    ordered: bool = True  # True if all values are numbers; a search needs numbers.

    @property
    def samples(self) -> list[Value]:
        """Some values, e.g. the first, the middle and the last, which are checked before a sweep."""
        if len(self.listed) > len(_ENDS):
            return [self.listed[0], self.listed[len(self.listed) // 2], self.listed[-1]]
        return list(self.listed) or [self.at(fraction) for fraction in _ENDS]


_ENDS = (0.0, 0.001, 0.5, 0.999, 1 - 2**-53)


def read_values(given: Value) -> Values:
    """Parse the text, list or value of one setting.  Raises UsageError for invalid values."""
    if isinstance(given, list):
        return _listed(str(given), given)
    if not isinstance(given, str):
        return _listed(str(given), [given])
    text = given.strip()
    if found := _RANGE.fullmatch(text):
        return _range(text, found)
    if found := _DRAWN.fullmatch(text):
        return _distribution(text, found["name"], found["given"])
    if ".." in text and not text.startswith(('"', "'", "[")):
        raise UsageError(f"invalid range {shortened(text)}: expected e.g. {EXAMPLES}")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return _listed(text, [_bare(text)])
    check_values(value)
    return _listed(text, value if isinstance(value, list) else [value])


def _bare(text: str) -> Value:
    if not text or text[0] in "[{(\"'":
        raise UsageError(f"invalid value {shortened(text)}: expected e.g. {EXAMPLES}")
    return text


def _listed(text: str, values: Sequence[Value]) -> Values:
    if not values:
        raise UsageError("the list of values is empty: expected at least one value, e.g. [1, 2]")
    numbers = all(isinstance(value, int | float) for value in values)
    return Values(text, values, lambda fraction: values[int(fraction * len(values))], ordered=numbers)


def _number(text: str) -> float:
    return whole(text) if _WHOLE.fullmatch(text) else real(text)


def _range(text: str, found: re.Match[str]) -> Values:
    low, high = _number(found["low"]), _number(found["high"])
    if not low < high:
        raise UsageError(f"invalid range {text}: expected the lower value first, e.g. 1..5")
    logarithmic = found["log"] is not None
    if logarithmic and low <= 0:
        raise UsageError(f"invalid logarithmic range {text}: expected a lower limit above 0, e.g. 1..1000:4:log")
    whole_ends = isinstance(low, int) and isinstance(high, int)
    interval = None if found["count"] else (low, high, logarithmic)
    if found["count"] is not None:
        listed = _points(text, low, high, int(found["count"]), logarithmic)
    else:
        listed = range(int(low), int(high) + 1) if whole_ends and not logarithmic else ()
    if len(listed) > MOST:
        raise UsageError(
            f"the range {text} has {len(listed):,} values: expected at most {MOST:,}, e.g. {text}:100 for 100 values"
        )
    if whole_ends and (found["count"] is None or all(isinstance(value, int) for value in listed)):
        return Values(text, listed, partial(_whole_at, int(low), int(high), logarithmic), interval)
    return Values(text, listed, partial(_between, low, high, logarithmic), interval)


def _points(text: str, low: float, high: float, count: int, logarithmic: bool) -> Sequence[Value]:
    if not 2 <= count <= MOST:
        raise UsageError(f"invalid count of values in {text}: expected 2 to {MOST:,}, e.g. {low}..{high}:5")
    values: list[float] = [low, *(_between(low, high, logarithmic, n / (count - 1)) for n in range(1, count - 1)), high]
    if isinstance(low, int) and isinstance(high, int) and all(float(value).is_integer() for value in values):
        return [int(value) for value in values]
    return [float(value) for value in values]


def _between(low: float, high: float, logarithmic: bool, fraction: float) -> float:
    return exp(log(low) + (log(high) - log(low)) * fraction) if logarithmic else low + (high - low) * fraction


def _whole_at(low: int, high: int, logarithmic: bool, fraction: float) -> int:
    if logarithmic:
        return min(high, max(low, round(_between(low, high, True, fraction))))
    return low + int(fraction * (high - low + 1))


def _normal(mean: float, deviation: float, fraction: float) -> float:
    return NormalDist(mean, deviation).inv_cdf(min(max(fraction, 2**-53), 1 - 2**-53))


def _triangular(low: float, mode: float, high: float, fraction: float) -> float:
    span, share = high - low, (mode - low) / (high - low)
    if fraction < share:
        return low + sqrt(fraction * span * (mode - low))
    return high - sqrt((1 - fraction) * span * (high - mode))


DISTRIBUTIONS: dict[str, tuple[Callable[..., float], str, Callable[[list[float]], bool]]] = {
    "normal": (_normal, "normal(mean, deviation) with a deviation above 0", lambda given: given[1] > 0),
    "uniform": (
        lambda low, high, fraction: _between(low, high, False, fraction), "uniform(low, high) with low below high",
        lambda given: given[0] < given[1],
    ),
    "triangular": (
        _triangular, "triangular(low, mode, high) in this order",
        lambda given: given[0] <= given[1] <= given[2] and given[0] < given[2],
    ),
}  # fmt: skip
"""Distributions by name: function for the value at a fraction, notation, and check of the parameters."""


def _distribution(text: str, name: str, given: str) -> Values:
    if name not in DISTRIBUTIONS:
        raise UsageError(f"unknown distribution {name!r} in {text}: expected one of {', '.join(DISTRIBUTIONS)}")
    value_at, notation, fits = DISTRIBUTIONS[name]
    try:
        numbers = [real(part) for part in given.split(",")]
    except NumberError:
        raise UsageError(f"invalid distribution {text}: expected {notation}") from None
    if len(numbers) != notation.partition(")")[0].count(",") + 1 or not fits(numbers):
        raise UsageError(f"invalid distribution {text}: expected {notation}")
    return Values(text, (), partial(value_at, *numbers))
