"""Animatics SmartMotor with firmware 4.76: a servo motor that runs its own language."""

from axistwin.controllers.smartmotor.card import PRODUCTS
from axistwin.controllers.smartmotor.commands import COMMANDS
from axistwin.controllers.smartmotor.nonvolatile import Nonvolatile
from axistwin.controllers.smartmotor.registers import numbers

__all__ = ["COMMANDS", "PRODUCTS", "Nonvolatile", "numbers"]
