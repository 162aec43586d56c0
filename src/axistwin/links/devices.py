"""Real serial devices, as pyserial opens them on every system."""

import asyncio
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from logging import getLogger
from threading import Thread
from typing import TYPE_CHECKING, Any, Protocol

from axistwin.errors import LinkError
from axistwin.links.plug import CHUNK, HostEnd
from axistwin.links.writer import STALLED, Writer
from axistwin.sim.frames import UartFormat

try:
    import termios
except ImportError:  # Windows
    TERMIOS_ERRORS: tuple[type[Exception], ...] = ()
else:
    TERMIOS_ERRORS = (termios.error,)

if TYPE_CHECKING:
    import serial

log = getLogger("axistwin.links")

DEVICE_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError, *TERMIOS_ERRORS)
"""Exceptions of pyserial for a device that does not exist, is lost, or does not support a setting."""
READ_S = 0.02
"""Timeout in seconds of a read in a thread; after each read, the thread checks if it must close the device."""
WRITE_S = 1.0
"""Timeout of a write in seconds; characters that the device has not accepted by then are lost."""

Receive = Callable[[bytes], None]
Lose = Callable[[str], None]


class Lines(Protocol):
    """The control lines of a serial device: two outputs, two inputs."""

    dtr: bool
    rts: bool

    @property
    def dsr(self) -> bool:
        """Level of the input DSR (data set ready)."""

    @property
    def cts(self) -> bool:
        """Level of the input CTS (clear to send)."""


class Stream(Protocol):
    """The characters of an open device.  The callbacks of the constructor are called in the event loop."""

    def write(self, data: bytes) -> None:
        """Send characters, now or later."""

    def pause(self) -> None:
        """Stop reading."""

    def resume(self) -> None:
        """Continue reading."""

    def close(self) -> None:
        """Stop reading and writing."""


def stream(device: "serial.Serial", name: str, receive: Receive, lose: Lose) -> Stream:
    """Return the stream of a device.  The event loop serves devices with a file descriptor, threads all others."""
    try:
        descriptor: int = device.fileno()
    except OSError:  # Windows
        return ThreadStream(device, name, receive, lose)
    return DescriptorStream(descriptor, name, receive, lose)


class DescriptorStream:
    """A stream that the event loop reads and writes."""

    def __init__(self, descriptor: int, name: str, receive: Receive, lose: Lose) -> None:
        self._descriptor, self._receive, self._lose = descriptor, receive, lose
        self._loop = asyncio.get_running_loop()
        self._writer = Writer(descriptor, name)
        self.resume()

    def write(self, data: bytes) -> None:
        """Send characters, now or later."""
        self._writer.write(data)

    def pause(self) -> None:
        """Stop reading."""
        self._loop.remove_reader(self._descriptor)

    def resume(self) -> None:
        """Continue reading."""
        self._loop.add_reader(self._descriptor, self._readable)

    def close(self) -> None:
        """Stop reading and writing."""
        self.pause()
        self._writer.clear()

    def _readable(self) -> None:
        try:
            data = os.read(self._descriptor, CHUNK)
        except BlockingIOError:
            return
        except OSError as error:
            self._lose(error.strerror or str(error))
            return
        if data:
            self._receive(data)
        else:
            self._lose("end of file")


class ThreadStream:
    """A stream that one thread reads and another writes."""

    def __init__(self, device: "serial.Serial", name: str, receive: Receive, lose: Lose) -> None:
        self._device, self._name, self._receive, self._lose = device, name, receive, lose
        self._loop = asyncio.get_running_loop()
        device.timeout, device.write_timeout = READ_S, WRITE_S
        self._closing = self._paused = False
        self._held = bytearray()
        self._queued = self._dropped = 0
        self._worker = ThreadPoolExecutor(1, "axistwin-device")
        self._thread = Thread(target=self._read, name="axistwin-reader", daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        """Send characters, now or later.  If too many characters are waiting, the newest are lost."""
        room = STALLED - self._queued
        self._dropped += len(data[room:])
        if kept := data[:room]:
            self._queued += len(kept)
            self._worker.submit(self._write, kept)

    def pause(self) -> None:
        """Stop reading; characters that have been read are kept for `resume`."""
        self._paused = True

    def resume(self) -> None:
        """Continue reading."""
        self._paused = False
        held, self._held = bytes(self._held), bytearray()
        if held:
            self._receive(held)

    def close(self) -> None:
        """Stop reading and writing."""
        self._closing = True
        self._thread.join()
        self._worker.shutdown(cancel_futures=True)

    def _read(self) -> None:
        while not self._closing:
            if self._paused:
                time.sleep(READ_S)
                continue
            try:
                data = self._device.read(1)
                if data and (more := min(self._device.in_waiting, CHUNK - 1)):
                    data += self._device.read(more)
            except DEVICE_ERRORS as error:
                self._call(self._lose, error_text(error))
                return
            if data:
                self._call(self._take, data)

    def _write(self, data: bytes) -> None:
        lost = 0
        try:
            self._device.write(data)
        except DEVICE_ERRORS:  # a slow device only loses characters; the reading thread detects a lost device
            lost = len(data)
        self._call(self._count, len(data), lost)

    def _call(self, callback: Callable[..., None], *arguments: Any) -> None:
        """Call a function in the event loop, unless the stream has been closed before."""
        if not self._closing:
            self._loop.call_soon_threadsafe(lambda: None if self._closing else callback(*arguments))

    # Functions that run in the event loop

    def _take(self, data: bytes) -> None:
        if self._paused:
            self._held += data
        else:
            self._receive(data)

    def _count(self, count: int, lost: int) -> None:
        self._queued -= count
        self._dropped += lost
        if self._dropped and not self._queued:
            log.warning("%s: reader too slow, %d characters were lost", self._name, self._dropped)
            self._dropped = 0


def error_text(error: Exception) -> str:
    """Return the text of a device error; pyserial and termios give numbers only."""
    number = getattr(error, "errno", None) or (error.args[0] if isinstance(error, TERMIOS_ERRORS) else None)
    return os.strerror(number).lower() if number else str(error)


def settings_of(fmt: UartFormat) -> dict[str, Any]:
    """Return a format as keyword arguments of pyserial."""
    return {"baudrate": fmt.baudrate, "bytesize": fmt.bytesize, "parity": fmt.parity, "stopbits": fmt.stopbits}


def control_lines(device: "serial.Serial") -> Lines | None:
    """Return the control lines of the device; None for a device without control lines, such as a pty."""
    try:
        device.dtr = device.dtr
    except OSError:
        return None
    lines: Lines = device
    return lines


@contextmanager
def opening(url: object) -> Iterator[None]:
    """Within a `with` block, convert the errors of pyserial to LinkError."""
    try:
        yield
    except DEVICE_ERRORS as error:
        raise LinkError(
            f"cannot open {url}: {error_text(error)}: check that it exists, is free and permits access"
        ) from None


def set_lines(of: Lines | HostEnd, dtr: bool, rts: bool) -> None:
    """Set DTR and RTS of a device, or of a host's end of a line."""
    of.dtr, of.rts = dtr, rts
