"""A controller of one's own: a class with its commands as methods; see the page "A device of your own"."""

from axistwin.controllers.options import Option
from axistwin.controllers.patterns import Refused, Why
from axistwin.devices.device import Device, Input, Output, register
from axistwin.devices.framing import Datagrams, Lines, Request, add8, xor8
from axistwin.devices.loading import load
from axistwin.devices.table import command, query
from axistwin.plant.positioner import Positioner

__all__ = [
    "Datagrams", "Device", "Input", "Lines", "Option", "Output", "Positioner", "Refused", "Request", "Why", "add8",
    "command", "load", "query", "register", "xor8",
]  # fmt: skip
