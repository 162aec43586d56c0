"""A front panel as somebody sees it who stands before the controller."""

from axistwin.bench import Controller
from axistwin.controllers.front import Item, Lamp


def items(controller: Controller) -> dict[tuple[str, str], Item]:
    """All there is on it, by group and label (or name, where it has no label)."""
    return {(group.title, item.label or item.name): item for group in controller.product.front for item in group.items}


def lamps(controller: Controller) -> set[tuple[str, str]]:
    """Lamps, by group and label."""
    return {key for key, item in items(controller).items() if isinstance(item, Lamp)}


def shown(controller: Controller, group: str, label: str) -> bool | str:
    """Whether a lamp is lit; what a word or a reading says."""
    item = items(controller)[group, label]
    if item.source in controller.terminals:
        return item.shows(controller.terminals[item.source].level)
    return item.shows(controller.registers[item.source].read())
