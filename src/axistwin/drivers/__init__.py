"""Drivers for real and virtual controllers: our models, and any that a `TextDriver` describes.

    from axistwin.drivers import connect

    with connect("socket://127.0.0.1:5001", "if1") as if1:
        x = if1.axes["X"]
        x.move_to(4000)
        x.wait(timeout=30)
        assert x.position() == 4000

`connect_async` returns the same controller for asyncio.  Of axistwin this package imports `errors` only.  The
protocol cores (`if1`, `board`, `smartmotor`) do no input and output: each function is a generator of `steps`.
"""

from axistwin.drivers.asynchronous import AsyncAxis, AsyncController, connect_async
from axistwin.drivers.axis import Fault, Scale, Status
from axistwin.drivers.blocking import BlockingAxis, Controller, SerialPort, connect
from axistwin.drivers.board import MESSAGE
from axistwin.drivers.errors import (
    BusyError,
    DriverError,
    PortError,
    PositionLostError,
    RefusedError,
    SilentError,
    StoppedError,
    WrongAnswerError,
)
from axistwin.drivers.if1_axis import Trapezoid
from axistwin.drivers.models import MODELS, make
from axistwin.drivers.steps import Pause
from axistwin.drivers.text import TextDriver

Axis = BlockingAxis
"""The axes of all controllers have the same functions."""

__all__ = [
    "MESSAGE", "MODELS", "AsyncAxis", "AsyncController", "Axis", "BlockingAxis", "BusyError", "Controller",
    "DriverError", "Fault", "Pause", "PortError", "PositionLostError", "RefusedError", "Scale", "SerialPort",
    "SilentError", "Status", "StoppedError", "TextDriver", "Trapezoid", "WrongAnswerError", "connect", "connect_async",
    "make",
]  # fmt: skip
