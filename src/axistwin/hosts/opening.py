"""Serial ports as a host opens them."""

from typing import TYPE_CHECKING

from axistwin.drivers.blocking import open_serial
from axistwin.links.devices import settings_of
from axistwin.links.urls import parse
from axistwin.sim.frames import UartFormat

if TYPE_CHECKING:
    import serial


def open_port(target: str, line: UartFormat, timeout_s: float) -> "serial.Serial":
    """Open a device, a URL of pyserial, or a port that `axistwin serve` prints.  Raises LinkError, UsageError."""
    if target.startswith(("pty:", "serial:")):
        target = parse(target).path
    elif target.startswith("tcp:"):
        target = str(parse(target))
    return open_serial(target, timeout=timeout_s, **settings_of(line))
