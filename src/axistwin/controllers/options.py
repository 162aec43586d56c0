"""Checks of the options of all families."""

from collections.abc import Hashable, Mapping
from functools import cache
from math import isfinite
from typing import Any, Literal, cast, get_args, get_origin, get_type_hints

from axistwin.core.errors import UsageError


def check(options: object, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Raise UsageError for an option that has not its type, is none of its choices, or is out of its range."""
    for name, kind in _kinds(cast("Hashable", type(options))).items():
        given = getattr(options, name)
        if get_origin(kind) is Literal:
            good, expected = given in get_args(kind), f"one of {', '.join(map(repr, get_args(kind)))}"
        elif kind is bool:
            good, expected = isinstance(given, bool), "true or false"
        elif name in ranges:
            low, high = ranges[name]
            types = (int, float) if kind is float else int
            good = isinstance(given, types) and not isinstance(given, bool) and low <= given <= high
            span = f" from {low} to {high}" if isfinite(low) or isfinite(high) else ""
            expected = f"a number{span}"
        else:
            continue
        if not good:
            raise UsageError(f"{name}={given!r}: expected {expected}")


@cache
def _kinds(options: Any) -> dict[str, Any]:
    """Return the type of each option; cached, because Python reads type hints slowly."""
    return get_type_hints(options)
