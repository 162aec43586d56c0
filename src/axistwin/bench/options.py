"""Options of a controller in the text form of a command line or a conversation's header."""

from collections.abc import Iterable
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.core.numbers import check_values, shortened

ADVICE = {
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
        name = name.strip()  # as in the key of a scene, e.g. `X.units = { … }`
        if not equals or not name:
            raise UsageError(f"invalid option {option!r}: expected NAME=VALUE")
        *path, last = name.replace("-", "_").split(".")
        if name in ADVICE:
            raise UsageError(f"--option cannot set {name}: {ADVICE[name]}")
        place = found
        for part in path:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise UsageError(
                    f"--option {option} conflicts with an earlier --option for {part}: remove one of the two"
                )
        place[last] = _value(text)
    return found


def _value(text: str) -> Any:
    """Parse a TOML value; return the given text if it is not TOML."""
    import tomllib

    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except RecursionError:
        raise UsageError(f"invalid option value {shortened(text)}: nested too deeply, expected e.g. [-5,5]") from None
    except ValueError:  # The value of the option is not valid TOML, or is a number with too many digits.
        return text
    check_values(value)
    return value
