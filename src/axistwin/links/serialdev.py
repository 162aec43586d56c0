"""A real serial device, such as /dev/ttyUSB0: axistwin is the *controller* at the end of a real cable.

The real UART uses the baud rate of the URL (`?baud=9600`) or of `--line`.  The host must use the same rate, because a
UART cannot measure a baud rate; a controller with automatic baud rate detection detects this rate.  Data bits, parity
and stop bits follow the controller's UART as the host configures it.  A character with a line error arrives as the real
UART delivers it.

The adapter's outputs DTR and RTS carry the controller's lines; its inputs DSR and CTS are read as the host's lines (a
crossed cable, as between two computers).  With `--flow none`, or on a device without these lines (a pty), the host's
lines are on.
"""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from logging import getLogger

from axistwin.core.errors import LinkError
from axistwin.core.lazy import serial
from axistwin.links.devices import DEVICE_ERRORS, Lines, control_lines, opening, set_lines, settings_of, stream
from axistwin.links.plug import Plug
from axistwin.links.urls import PortUrl
from axistwin.sim.frames import LineError, UartFormat
from axistwin.sim.serial_port import Flow

log = getLogger("axistwin.links")

POLL_S = 0.02  # Interval in seconds between two polls of the input lines, whose changes cause no event.


class SerialDevice:
    """Connects a virtual controller to a serial port of this computer, e.g. /dev/ttyUSB0."""

    flow: Flow | None = Flow.NONE  # Flow control is not simulated, because the real host handles the controller's DTR.

    def __init__(self, plug: Plug, url: PortUrl) -> None:
        self.plug, self.name = plug, str(url)
        self.format = plug.default_format if url.baud is None else replace(plug.default_format, baudrate=url.baud)
        self.url = replace(url, baud=self.format.baudrate)
        self._device = _open(url, self.format)
        self._applied = self.format
        self._loop = asyncio.get_running_loop()
        self._poll: asyncio.TimerHandle | None = None
        self._unsubscribe: list[Callable[[], None]] = []
        self._lines: Lines | None = None
        if not plug.connect(self):
            self._device.close()
            raise LinkError(f"cannot use {url}: {plug.name} is already connected to another port")
        self._begin()

    def _begin(self) -> None:
        plug = self.plug
        plug.serial.host.format = self.format
        self._stream = stream(self._device, f"{plug.name}: {self.name}", plug.send, self._lose)
        self._unsubscribe = [plug.pacer.subscribe(self._follow_format)]
        self._lines = control_lines(self._device) if plug.flow is not Flow.NONE else None
        if self._lines is not None:
            lines = plug.serial.dtr_line, plug.serial.rts_line
            self._unsubscribe += [line.subscribe(self._drive) for line in lines]
            self._drive()
            self._poll_lines()

    def close(self) -> None:
        if not self._device.is_open:
            return
        for unsubscribe in self._unsubscribe:
            unsubscribe()
        if self._poll is not None:
            self._poll.cancel()
        self._stream.close()
        self._device.close()
        self.plug.disconnect(self)

    # From the host

    def _lose(self, reason: str) -> None:
        log.warning("%s: lost %s: %s", self.plug.name, self.name, reason)
        self.close()

    def _poll_lines(self) -> None:
        assert self._lines is not None
        host, dsr, cts = self.plug.serial.host, self._lines.dsr, self._lines.cts
        if (host.dtr, host.rts) != (dsr, cts) and not self.plug.gate.closed:
            self.plug.change(lambda: set_lines(host, dsr, cts))
        self._poll = self._loop.call_later(POLL_S, self._poll_lines)

    # To the host

    def deliver(self, data: bytes, errors: LineError) -> None:  # noqa: ARG002
        self._stream.write(data)

    def _drive(self, _: object = None) -> None:
        assert self._lines is not None
        set_lines(self._lines, self.plug.serial.dtr_line.level, self.plug.serial.rts_line.level)

    def _follow_format(self) -> None:
        inside = self.plug.serial.to_device.receiver.format
        wanted = self.format if inside is None else replace(inside, baudrate=self.format.baudrate)
        if wanted == self._applied or self.plug.gate.closed:
            return
        self._applied = self.plug.serial.host.format = wanted
        try:
            self._device.apply_settings(settings_of(wanted))
        except DEVICE_ERRORS as error:
            log.warning("%s: %s does not support %s: %s", self.plug.name, self.name, wanted, error)

    # Functions that the serial endpoint calls

    def hung_up(self) -> bool:
        return False

    def drop(self) -> None:
        """Ignore a request to end the connection: a real device always stays connected."""

    def pause(self) -> None:
        self._stream.pause()

    def resume(self) -> None:
        self._stream.resume()


def _open(url: PortUrl, fmt: UartFormat) -> "serial.Serial":
    with opening(url):
        return serial.Serial(url.path, timeout=0, exclusive=True, **settings_of(fmt))
