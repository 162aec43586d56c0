"""What somebody needs to add a controller of their own; see the page "A device of your own".

from axistwin.devices import Device, Positioner, command, query

class Stage(Device):
    model, title, framing = "stage", "Example stage controller", Lines(b"\\r")
    axes = {"1": Positioner(velocity=20_000), "2": Positioner(velocity=20_000)}

    @command("{axis}PA{position:int}", section="Absolute move")
    def move_absolute(self, axis: str, position: int) -> None:
        self.axes[axis].move_to(position)
"""

from axistwin.devices.device import Device, Input, Option, Output, register
from axistwin.devices.framing import Datagrams, Lines, Request, add8, xor8
from axistwin.devices.loading import load
from axistwin.devices.table import Refused, Why, command, query
from axistwin.plant.positioner import Positioner

__all__ = [
    "Datagrams", "Device", "Input", "Lines", "Option", "Output", "Positioner", "Refused", "Request", "Why", "add8",
    "command", "load", "query", "register", "xor8",
]  # fmt: skip
