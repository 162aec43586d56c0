"""Diagnostics of programs for the 1810 and 1811."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.checker.program import acceptable
    from axistwin.controllers.compumotor.checker.texts import LAYOUTS, SPECIAL, Words, name_of
else:
    __getattr__ = lazy(__name__, program="acceptable", texts="LAYOUTS SPECIAL Words name_of")

__all__ = ["LAYOUTS", "SPECIAL", "Words", "acceptable", "name_of"]
