"""Options of a controller in the text form of a command line or a conversation's header."""

from collections.abc import Iterable
from typing import Any

from axistwin.errors import UsageError
from axistwin.numbers import check_values, shortened

OWN = {
    "model": "name the MODEL",
    "name": "a controller is named after its model; use a scene for other names",
    "state": "use --state",
}
"""Options that `--option` cannot set, each with the error message for the user."""


def read_options(options: Iterable[str]) -> dict[str, Any]:
    """Convert `NAME=VALUE` words to keyword arguments; `X.limits=[-5,5]` becomes `X={"limits": [-5, 5]}`."""
    found: dict[str, Any] = {}
    for option in options:
        name, equals, text = option.partition("=")
        if not equals or not name:
            raise UsageError(f"invalid option {option!r}: expected NAME=VALUE")
        *path, last = name.replace("-", "_").split(".")
        if name in OWN:
            raise UsageError(f"--option {name} is invalid: {OWN[name]}")
        place = found
        for part in path:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise UsageError(f"--option {option}: {part} already has a value")
        place[last] = _value(text)
    return found


def _value(text: str) -> Any:
    """Parse a text as a TOML value; if this is impossible, return the text."""
    import tomllib  # lazy import: needed only for controllers with options

    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except RecursionError:
        raise UsageError(f"--option: {shortened(text)}: too many nested brackets") from None
    except ValueError:  # the text is not TOML, or a number with thousands of digits
        return text
    check_values(value)
    return value
