"""Models and their protocol cores."""

from collections.abc import Callable
from inspect import signature
from typing import Any

from axistwin.drivers.board import Board
from axistwin.drivers.core import Core
from axistwin.drivers.errors import DriverError
from axistwin.drivers.if1 import IF1
from axistwin.drivers.smartmotor import SmartMotors

MODELS: dict[str, Callable[..., Core]] = {
    "if1": IF1, "if2": IF1, "1810": Board, "1811": Board, "smartmotor": SmartMotors,
}  # fmt: skip
"""Cores by the model's name."""


def make(model: str, options: dict[str, Any]) -> Core:
    """Return the protocol core of a model.  Raises DriverError for an unknown model or option."""
    if model not in MODELS:
        raise DriverError(f"unknown model {model!r}: expected one of {', '.join(MODELS)}")
    known = signature(MODELS[model]).parameters
    for name in options:
        if name not in known:
            raise DriverError(f"unknown option {name!r} for the model {model}: expected one of {', '.join(known)}")
    try:
        return MODELS[model](**options)
    except (TypeError, ValueError) as reason:
        raise DriverError(f"invalid options for the model {model}: {reason}") from None
