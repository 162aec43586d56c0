"""Compumotor 1810 and 1811: Multibus motor controllers of 1984."""

from axistwin.controllers.compumotor.card import PRODUCTS

__all__ = ["PRODUCTS"]
