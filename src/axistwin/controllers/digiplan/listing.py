"""The stored sequence as lines, one for each step, as a user types them (chapter Programming a sequence)."""

from collections.abc import Iterable, Mapping
from functools import lru_cache

from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import parse
from axistwin.controllers.digiplan.step import Step

SEQUENCE = "sequence"
"""What the one program of an interface is called."""
RAMP = {"speed_range": ">", "start_stop": "<", "acceleration": "^", "character_delay": "D"}
"""Parameters that may not stand in a sequence, by their commands."""


@lru_cache(maxsize=64)
def listed(sequence: str) -> tuple[str, ...]:
    """The steps of a sequence in order, each without the colons around it; nothing if none is stored."""
    return tuple(typed(step) for step in parse(sequence, COMMANDS).steps)


def typed(step: Step) -> str:
    """A step in the order in which the manual has its parts; read again, it is the same step.

    H L A, or H L, parameters, axes and speed, S R, or P; then the repeat.
    """
    parts = (
        _lines("H", step.high),
        _lines("L", step.low),
        "A" if step.abort else "",
        _parameters(step.settings),
        _move(step),
        _lines("S", step.set),
        _lines("R", step.reset),
        _pulse(step),
        "={},{}".format(*step.repeat) if step.repeat else "",
        "%" if step.hand_over else "",
    )
    return "".join(parts)


def _lines(command: str, numbers: Iterable[int]) -> str:
    digits = "".join(map(str, numbers))
    return command + digits if digits else ""


def _parameters(settings: Mapping[str, int]) -> str:
    ramp = "".join(f"{command}{settings[name]}" for name, command in RAMP.items() if name in settings)
    return ramp + (f"B{settings['backlash']:+}" if "backlash" in settings else "")


def _move(step: Step) -> str:
    """Axes with their distance behind the last of them, speed, G, correction."""
    settings = step.settings
    minor = f"/{_axes(step.minor, settings.get('minor_distance'))}" if step.interpolated else ""
    speed = f"@{settings['speed']}" if "speed" in settings else ""
    ending = ("G" if step.run else "") + ("B" if step.corrected else "")
    return _axes(step.major, settings.get("distance")) + minor + speed + ending


def _axes(directions: Mapping[str, int], distance: int | None) -> str:
    """Nothing is +."""
    named = "".join(f"{axis}{'-' if direction < 0 else ''}" for axis, direction in directions.items())
    return named + ("" if distance is None else str(distance))


def _pulse(step: Step) -> str:
    if step.pulse is None:
        return ""
    length = step.settings.get("pulse_length")
    return f"P{step.pulse}" + ("" if length is None else f",{length}")
