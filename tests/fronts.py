"""The front panel of a controller as the user sees it."""

from axistwin.bench import Controller
from axistwin.controllers.front import Item, Lamp


def items(controller: Controller) -> dict[tuple[str, str], Item]:
    """Return all items of the front panel, by group and label (or name, if there is no label)."""
    return {(group.title, item.label or item.name): item for group in controller.product.front for item in group.items}


def lamps(controller: Controller) -> set[tuple[str, str]]:
    return {key for key, item in items(controller).items() if isinstance(item, Lamp)}


def shown(controller: Controller, group: str, label: str) -> bool | str:
    """Return True if a lamp is lit; for a text or a reading, return its value."""
    item = items(controller)[group, label]
    if item.source in controller.terminals:
        return item.shows(controller.terminals[item.source].level)
    return item.shows(controller.registers[item.source].read())
