"""The reasons of each family, and of any other device."""

from importlib import import_module

from axistwin.bench import Controller
from axistwin.scenes.reasons.reasons import Reasons
from axistwin.scenes.reasons.remedies import Remedies

KNOWN = {"digiplan": "DigiplanReasons", "compumotor": "CompumotorReasons", "smartmotor": "SmartMotorReasons"}
"""Families that can tell more than the abilities of every device do, each with its class."""


def reasons_of(controller: Controller, remedies: Remedies) -> Reasons:
    """Return what says why a controller does not move, in the words of `remedies`."""
    family = controller.product.family
    made = getattr(import_module(f"{__package__}.{family}"), KNOWN[family]) if family in KNOWN else Reasons
    found: Reasons = made(controller)
    found.remedies = remedies
    return found
