"""Acts at the machine, faults and alarms in words, for the list of a conversation."""

from collections.abc import Iterator
from typing import NamedTuple

from axistwin.bench import Bench, Controller
from axistwin.bench.events import FaultChanged, ManualAction
from axistwin.controllers.front import Lamp
from axistwin.scenes.reasons.reasons import EMERGENCY_STOPS
from axistwin.scenes.sessions.condition import spaced
from axistwin.scenes.tables import OperatorTable
from axistwin.sim.manual_actions import ManualAct

LEVELS = ("high", "low", "release")
POWER = {"high": "on", "low": "off"}  # Power is a level for a user, and on or off in a script.
SCRIPT = "script: "


class Told(NamedTuple):
    """Words of an entry; `bad`: it is a fault or an emergency stop."""

    words: str
    bad: bool = False


def told_of(operator: OperatorTable, event: ManualAction | FaultChanged) -> Told | None:
    """Return an act in words, e.g. `Start pressed`; None for a selector's position that is left."""
    if isinstance(event, FaultChanged):
        return Told(f"{'Fault' if event.act == 'fault' else 'End of fault'}: {event.words}", event.act == "fault")
    return _act(operator, event.controller, event.act, event.value)


def planned(operator: OperatorTable, bench: Bench, text: str) -> Iterator[tuple[str, Told]]:
    """Yield the acts of a scene's script that the bench does not report, with their controllers.

    `text`: one of `Bench.planned`.  The levels of terminals are reported.
    """
    text = text.removeprefix(SCRIPT)
    name, _, rest = text.partition(" ")
    if name not in bench.controllers:
        name, rest = next(iter(bench.controllers)), text
    for each in rest.split(", "):
        target, _, value = each.partition(" ")
        told = None if target in bench[name].pins else _act(operator, name, target, value)
        if told is not None:
            yield name, told


def _act(operator: OperatorTable, controller: str, name: str, value: str) -> Told | None:
    pin = f"{controller}.{name}"
    if name != ManualAct.POWER and value in LEVELS:
        for button in operator.button:
            if button.pin == pin:
                pressed = value == button.pressed
                words = f"{button.name} {'pressed' if pressed else 'released'}"
                return Told(words, pressed and "stop" in button.name.lower())
        for selector in operator.selector:
            word = next((word for word, selected in selector.positions.items() if selected == pin), "")
            if word:
                return Told(f"{selector.name}: {word}") if value == selector.selected else None
    level = "released" if value == "release" else value
    if name == ManualAct.POWER:
        level = POWER.get(value, value)
    return Told(_sentence(f"{spaced(name)} {level}"), name in EMERGENCY_STOPS and value == "low")


def alarm(controller: Controller, flag: str) -> Told:
    """Return an alarm in words, as the front panel names it, e.g. `Plus limit`."""
    lamps = (lamp for group in controller.product.front for lamp in group.items if isinstance(lamp, Lamp))
    named = next((lamp.name for lamp in lamps if lamp.label == flag), spaced(flag)).partition(",")[0]
    is_fault = named.endswith((" limit", "fault", "stop", "stall", "error"))
    return Told(_sentence(named if is_fault else f"{named} fault"), bad=True)


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}"
