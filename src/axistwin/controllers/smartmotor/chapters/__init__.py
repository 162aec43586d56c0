"""The chapters of the SmartMotor manuals, one module each."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.chapters.variables import TABLE, find
else:
    __getattr__ = lazy(__name__, variables="TABLE find")

__all__ = ["TABLE", "find"]
