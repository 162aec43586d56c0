"""The stored sequence as lines, one for each step, as a user types them (chapter Programming a sequence)."""

from collections.abc import Iterable, Mapping
from functools import lru_cache

from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import parse
from axistwin.controllers.digiplan.step import Step

SEQUENCE = "sequence"
RAMP = {"speed_range": ">", "start_stop": "<", "acceleration": "^", "character_delay": "D"}
"""Commands that set parameters, but are not allowed in a sequence."""


@lru_cache(maxsize=64)
def listed(sequence: str) -> tuple[str, ...]:
    """Return the steps of a sequence, each without the colons around it; empty if no sequence is stored."""
    return tuple(typed(step) for step in parse(sequence, COMMANDS).steps)


def typed(step: Step) -> str:
    """Return the text of a step, with its commands in the manual's order; parsing the text gives the same step."""
    pulse, length = step.pulse, step.settings.get("pulse_length")
    parts = (
        _lines("H", step.high), _lines("L", step.low), "A" if step.abort else "",
        *(f"{command}{step.settings[name]}" for name, command in RAMP.items() if name in step.settings),
        f"B{step.settings['backlash']:+}" if "backlash" in step.settings else "",
        _move(step), _lines("S", step.set), _lines("R", step.reset),
        "" if pulse is None else f"P{pulse}" if length is None else f"P{pulse},{length}",
        "={},{}".format(*step.repeat) if step.repeat else "",
        "%" if step.hand_over else "",
    )  # fmt: skip
    return "".join(parts)


def _lines(command: str, numbers: Iterable[int]) -> str:
    digits = "".join(map(str, numbers))
    return command + digits if digits else ""


def _move(step: Step) -> str:
    settings = step.settings
    minor = f"/{_axes(step.minor, settings.get('minor_distance'))}" if step.interpolated else ""
    speed = f"@{settings['speed']}" if "speed" in settings else ""
    ending = ("G" if step.run else "") + ("B" if step.corrected else "")
    return _axes(step.major, settings.get("distance")) + minor + speed + ending


def _axes(directions: Mapping[str, int], distance: int | None) -> str:
    named = "".join(f"{axis}{'-' if direction < 0 else ''}" for axis, direction in directions.items())
    return named + ("" if distance is None else str(distance))
