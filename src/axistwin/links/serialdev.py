"""A real serial device, such as /dev/ttyUSB0: here axistwin is the *controller* at the end of a real cable.

On a real wire the real UART counts.  Its baud rate is the one in the URL (`?baud=9600`) or of `--line`, and must be
the host's: a UART cannot measure one.  So automatic baud rate detection finds that rate.  Data bits, parity and stop
bits follow the controller's UART as the host configures it.  What is received with an error on the wire arrives as the
real UART delivers it.

The adapter's outputs DTR and RTS are the controller's, its inputs DSR and CTS are what the controller sees (a crossed
cable, as between two computers).  With `--flow none`, or where the device has no such lines (a pty), they count as on.
"""

import asyncio
import os
import termios
from collections.abc import Callable
from dataclasses import replace
from logging import getLogger
from typing import TYPE_CHECKING, Any, Protocol

from axistwin.errors import LinkError
from axistwin.links.plug import CHUNK, Plug
from axistwin.links.urls import PortUrl
from axistwin.links.writer import Writer
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.serial_port import Flow, HostEnd

if TYPE_CHECKING:
    import serial

log = getLogger("axistwin.links")

LOOK_S = 0.02
"""So often the input lines are looked at; nothing tells when they change."""


class Lines(Protocol):
    """The control lines of a serial device: two outputs, two inputs."""

    dtr: bool
    rts: bool

    @property
    def dsr(self) -> bool:
        """Data set ready."""

    @property
    def cts(self) -> bool:
        """Clear to send."""


class SerialDevice:
    """A serial device on which a controller is plugged in all the time."""

    flow: Flow | None = Flow.NONE
    """The host at the other end watches the controller's DTR itself."""

    def __init__(self, plug: Plug, url: PortUrl) -> None:
        self.plug, self.name = plug, str(url)
        self.format = plug.usual if url.baud is None else replace(plug.usual, baudrate=url.baud)
        self.url = replace(url, baud=self.format.baudrate)
        self._device = _open(url, self.format)
        self._descriptor: int = self._device.fileno()
        self._applied = self.format
        self._loop = asyncio.get_running_loop()
        self._writer = Writer(self._descriptor, f"{plug.name}: {self.name}")
        self._look: asyncio.TimerHandle | None = None
        self._unwatch: list[Callable[[], None]] = []
        self._lines: Lines | None = None
        if not plug.connect(self):
            self._device.close()
            raise LinkError(f"cannot use {url}: another port of {plug.name} is connected already")
        self._begin()

    def _begin(self) -> None:
        plug = self.plug
        plug.serial.host.format = self.format
        self._loop.add_reader(self._descriptor, self._readable)
        self._unwatch = [plug.pacer.watch(self._follow_format)]
        self._lines = control_lines(self._device) if plug.flow is not Flow.NONE else None
        if self._lines is not None:
            lines = lambda: plug.serial.dtr_line, lambda: plug.serial.rts_line
            self._unwatch += [plug.watch(line, self._drive) for line in lines]
            self._drive()
            self._look_at_lines()

    def close(self) -> None:
        """Let go of the device, unless that has been done already."""
        if not self._device.is_open:
            return
        for unwatch in self._unwatch:
            unwatch()
        if self._look is not None:
            self._look.cancel()
        self._loop.remove_reader(self._descriptor)
        self._writer.clear()
        self._device.close()
        self.plug.disconnect(self)

    # From the host

    def _readable(self) -> None:
        try:
            data = os.read(self._descriptor, CHUNK)
        except BlockingIOError:
            return
        except OSError as error:
            self._gone(error.strerror or str(error))
            return
        if data:
            self.plug.send(data)
        else:
            self._gone("it is at its end")

    def _gone(self, reason: str) -> None:
        log.warning("%s: %s has gone: %s", self.plug.name, self.name, reason)
        self.close()

    def _look_at_lines(self) -> None:
        assert self._lines is not None
        host, dsr, cts = self.plug.serial.host, self._lines.dsr, self._lines.cts
        if (host.dtr, host.rts) != (dsr, cts) and not self.plug.deaf:
            self.plug.change(lambda: _set_lines(host, dsr, cts))
        self._look = self._loop.call_later(LOOK_S, self._look_at_lines)

    # To the host

    def deliver(self, data: bytes, errors: LineError) -> None:  # noqa: ARG002
        """Send characters to the host."""
        self._writer.write(data)

    def _drive(self, _: object = None) -> None:
        """The controller's output lines, on the real ones."""
        assert self._lines is not None
        self._lines.dtr, self._lines.rts = self.plug.serial.dtr, self.plug.serial.rts

    def _follow_format(self) -> None:
        """The real UART is the controller's: it follows what the controller has been configured to."""
        inside = self.plug.serial.to_device.receiver.format
        wanted = self.format if inside is None else replace(inside, baudrate=self.format.baudrate)
        if wanted == self._applied or self.plug.deaf:
            return
        self._applied = self.plug.serial.host.format = wanted
        try:
            self._device.apply_settings(settings_of(wanted))
        except (OSError, ValueError, termios.error) as error:
            log.warning("%s: %s cannot do %s: %s", self.plug.name, self.name, wanted, error)

    # What the plug wants to know

    def hung_up(self) -> bool:
        """A cable stays where it is."""
        return False

    def drop(self) -> None:
        """A cable stays where it is."""

    def pause(self) -> None:
        """Take nothing from the device for the moment."""
        self._loop.remove_reader(self._descriptor)

    def resume(self) -> None:
        """Go on taking what comes."""
        self._loop.add_reader(self._descriptor, self._readable)


def _open(url: PortUrl, fmt: UartFormat) -> "serial.Serial":
    import serial  # late: most ports do not need it

    try:
        return serial.Serial(url.path, timeout=0, exclusive=True, **settings_of(fmt))
    except (OSError, ValueError, termios.error) as error:
        raise LinkError(f"cannot open {url}: {why(error)}: is it there, free, and are you allowed to use it?") from None


def why(error: Exception) -> str:
    """In words what has gone wrong with a device; pyserial and termios know it by number."""
    number = getattr(error, "errno", None) or (error.args[0] if isinstance(error, termios.error) else None)
    return os.strerror(number).lower() if number else str(error)


def settings_of(fmt: UartFormat) -> dict[str, Any]:
    """A format as pyserial has it."""
    return {"baudrate": fmt.baudrate, "bytesize": fmt.bytesize, "parity": fmt.parity, "stopbits": fmt.stopbits}


def control_lines(device: "serial.Serial") -> Lines | None:
    """The control lines of the device; a pty has none."""
    try:
        device.dtr = device.dtr
    except OSError:
        return None
    lines: Lines = device
    return lines


def _set_lines(host: HostEnd, dsr: bool, cts: bool) -> None:
    host.dtr, host.rts = dsr, cts
