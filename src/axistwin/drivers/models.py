"""Models and their protocol cores."""

from collections.abc import Callable
from inspect import signature
from typing import Any

from axistwin.drivers.board import Board
from axistwin.drivers.core import Core
from axistwin.drivers.errors import DriverError
from axistwin.drivers.if1 import IF1
from axistwin.drivers.smartmotor import SmartMotors
from axistwin.drivers.text import TextDriver, core_of_device

MODELS: dict[str, Callable[..., Core]] = {
    "if1": IF1, "if2": IF1, "1810": Board, "1811": Board, "smartmotor": SmartMotors,
}  # fmt: skip
"""Cores by the model's name."""


def make(model: Any, options: dict[str, Any]) -> Core:
    """Return the protocol core of a model: a name, a `TextDriver`, or a device that has one.

    Raises DriverError for an unknown model or option.
    """
    name = model if isinstance(model, str) else getattr(model, "model", "of this driver")
    if isinstance(model, str):
        if model not in MODELS:
            raise DriverError(f"unknown model {model!r}: expected one of {', '.join(MODELS)}, or the class of a device")
        core = MODELS[model]
    else:
        core = model if isinstance(model, TextDriver) else core_of_device(model)
    known = signature(core).parameters
    for option in options:
        if option not in known:
            raise DriverError(f"unknown option {option!r} for the model {name}: expected one of {', '.join(known)}")
    try:
        return core(**options)
    except (TypeError, ValueError) as reason:
        raise DriverError(f"invalid options for the model {name}: {reason}") from None
