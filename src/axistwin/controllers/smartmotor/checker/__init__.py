"""Diagnostics of SmartMotor programs."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.checker.program import check
else:
    __getattr__ = lazy(__name__, program="check")

__all__ = ["check"]
