"""Options of controllers: the checks of all families, and the options of a device, each given by an `Option`."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, make_dataclass
from functools import cache
from math import inf, isfinite
from typing import Any, Literal, cast, get_args, get_origin, get_type_hints

from axistwin.core.errors import UsageError


@dataclass(frozen=True)
class Option:
    """A keyword of `Bench.add` and of scenes: its usual value, its range or choices, and what it means."""

    usual: Any
    low: float | None = None
    high: float | None = None
    choices: tuple[Any, ...] = ()
    doc: str = ""


def options_class(listed: Mapping[str, Option]) -> type[Any]:
    """Return a dataclass of options; to make one of it checks their values."""
    fields: list[Any] = [
        (name, Literal[one.choices] if one.choices else type(one.usual), one.usual) for name, one in listed.items()
    ]
    ranges = {
        name: (-inf if one.low is None else one.low, inf if one.high is None else one.high)
        for name, one in listed.items()
    }
    return make_dataclass("Options", fields, namespace={"__post_init__": lambda made: check(made, ranges)})


def check(options: object, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Raise UsageError for an option that has not its type, is none of its choices, or is out of its range."""
    for name, kind in _kinds(cast("Hashable", type(options))).items():
        given = getattr(options, name)
        if get_origin(kind) is Literal:
            good, expected = given in get_args(kind), f"one of {', '.join(map(repr, get_args(kind)))}"
        elif kind is bool:
            good, expected = isinstance(given, bool), "true or false"
        elif kind is str:
            good, expected = isinstance(given, str), f"a text, e.g. {getattr(type(options), name)!r}"
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
