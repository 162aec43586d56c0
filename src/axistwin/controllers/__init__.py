"""One package for each controller family; families do not import each other."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.commandset import Command, CommandSet
    from axistwin.controllers.diagnostics import Diagnostic, Edit, Rule, Sent, Session, Severity
    from axistwin.controllers.front import Item, Lamp
    from axistwin.controllers.product import Abilities, Product
else:
    __getattr__ = lazy(
        __name__,
        commandset="Command CommandSet",
        diagnostics="Diagnostic Edit Rule Sent Session Severity",
        front="Item Lamp",
        product="Abilities Product",
    )

__all__ = [
    "Abilities", "Command", "CommandSet", "Diagnostic", "Edit", "Item", "Lamp", "Product", "Rule", "Sent",
    "Session", "Severity",
]  # fmt: skip
