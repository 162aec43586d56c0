"""The bench that a command line asks for: a MODEL with options, or a SCENE.toml."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from axistwin.bench import Bench
from axistwin.errors import UsageError
from axistwin.numbers import check_values, shortened

OWN = {
    "model": "name the MODEL",
    "name": "a controller has its model's name; others are for a scene",
    "state": "there is --state for that",
}
"""What is said otherwise on a command line."""


def bench_for(target: str, options: Iterable[str] = (), state: Path | None = None) -> Bench:
    """A bench with one controller, or the one that a scene describes."""
    options = tuple(options)
    if not target.endswith(".toml"):
        bench = Bench()
        bench.add(target, state=state, **read_options(options))
        return bench
    if options or state:
        raise UsageError("--option and --state are for a MODEL: write them into the scene")
    from axistwin.scenes.scene import Scene  # brings pydantic along

    made: Bench = Scene.load(Path(target)).build()
    return made


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
    """A TOML value if it is one, otherwise the text as it stands."""
    import tomllib  # late: few need it

    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except RecursionError:
        raise UsageError(f"--option: {shortened(text)}: more brackets within one another than anybody wants") from None
    except ValueError:  # it is no TOML, or a number of thousands of digits
        return text
    check_values(value)
    return value
