"""Options of a controller as they stand on a command line or in a conversation's header."""

from collections.abc import Iterable
from typing import Any

from axistwin.errors import UsageError
from axistwin.numbers import check_values, shortened

OWN = {
    "model": "name the MODEL",
    "name": "a controller has its model's name; others are for a scene",
    "state": "there is --state for that",
}
"""What is said otherwise on a command line."""


def read_options(options: Iterable[str]) -> dict[str, Any]:
    """`NAME=VALUE` words as keywords; `X.limits=[-5,5]` is `X={"limits": [-5, 5]}`."""
    found: dict[str, Any] = {}
    for option in options:
        name, equals, text = option.partition("=")
        if not equals or not name:
            raise UsageError(f"no option {option!r}: write it like NAME=VALUE")
        *path, last = name.replace("-", "_").split(".")
        if name in OWN:
            raise UsageError(f"--option {name} is not for here: {OWN[name]}")
        place = found
        for part in path:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise UsageError(f"--option {option}: {part} has a value already")
        place[last] = _value(text)
    return found


def _value(text: str) -> Any:
    """Return a TOML value if the text is one, else the text as it stands."""
    import tomllib  # lazy import: few command lines have options

    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except RecursionError:
        raise UsageError(f"--option: {shortened(text)}: more brackets within one another than anybody wants") from None
    except ValueError:  # it is no TOML, or a number of thousands of digits
        return text
    check_values(value)
    return value
