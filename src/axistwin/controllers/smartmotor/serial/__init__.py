"""The SmartMotor's serial channels and its program storage commands."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.serial.serial_data import BAUD_RATES
else:
    __getattr__ = lazy(__name__, serial_data="BAUD_RATES")

__all__ = ["BAUD_RATES"]
