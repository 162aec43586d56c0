"""Check what the user gives, before anything is sent; each function raises RefusedError."""

from collections.abc import Iterable
from math import isfinite, isnan
from numbers import Real
from typing import Any

from axistwin.drivers.errors import RefusedError


def number(what: str, value: Any, *, finite: bool = True) -> float:
    """Return a number as a float; NaN, True and texts are no numbers."""
    if not isinstance(value, bool) and isinstance(value, Real):
        try:
            found = float(value)
        except OverflowError:
            found = float("nan")
        if isfinite(found) or not (finite or isnan(found)):
            return found
    raise RefusedError(f"invalid {what} {value!r}: expected a number, e.g. 12.5")


def positive(what: str, value: Any) -> float:
    """Return a number above 0."""
    found = number(what, value)
    if found <= 0:
        raise RefusedError(f"invalid {what} {value!r}: expected a number above 0, e.g. 12.5")
    return found


def integer(what: str, value: Any, low: int, high: int) -> int:
    """Return a whole number in a range; 20.0 is one."""
    found = number(what, value)
    if not (low <= found <= high and found.is_integer()):
        raise RefusedError(f"invalid {what} {value!r}: expected a whole number from {low} to {high}")
    return int(found)


def items(what: str, value: Any, example: str, count: int | None = None) -> list[Any]:
    """Return the items of a list; a text is no list.  `count`: number of items; None: any."""
    found = None if isinstance(value, str) or not isinstance(value, Iterable) else list(value)
    if found is None or count not in (None, len(found)):
        raise RefusedError(f"invalid {what} {value!r}: expected a list, e.g. {example}")
    return found


def ascii_text(what: str, value: Any, example: str) -> str:
    """Return a text of ASCII characters."""
    if not isinstance(value, str) or not value.isascii():
        raise RefusedError(f"invalid {what} {value!r}: expected ASCII characters, e.g. {example}")
    return value
