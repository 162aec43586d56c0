"""Digiplan IF1 and IF2: RS232 stepper motor interfaces of 1986."""

from axistwin.controllers.digiplan.card import PRODUCTS
from axistwin.controllers.digiplan.commands import COMMANDS
from axistwin.controllers.digiplan.language import Accept, parse
from axistwin.controllers.digiplan.listing import listed, typed
from axistwin.controllers.digiplan.options import Wiring

__all__ = ["COMMANDS", "PRODUCTS", "Accept", "Wiring", "listed", "parse", "typed"]
