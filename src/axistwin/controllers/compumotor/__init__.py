"""Compumotor 1810 and 1811: Multibus motor controllers of 1984."""

from axistwin.controllers.compumotor.card import PRODUCTS
from axistwin.controllers.compumotor.commands import COMMANDS_1811
from axistwin.controllers.compumotor.language import Accept, Opcode

__all__ = ["COMMANDS_1811", "PRODUCTS", "Accept", "Opcode"]
