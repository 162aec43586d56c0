"""Real serial devices, as pyserial opens them on every system."""

import asyncio
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from logging import getLogger
from threading import Thread
from typing import Any, Protocol

from axistwin.core.errors import LinkError, cannot_open, reason
from axistwin.core.lazy import serial
from axistwin.links.plug import CHUNK, HostEnd
from axistwin.links.writer import STALLED, Writer
from axistwin.sim.frames import UartFormat

try:
    import termios
except ImportError:  # Windows
    TERMIOS_ERRORS: tuple[type[Exception], ...] = ()
else:
    TERMIOS_ERRORS = (termios.error,)

log = getLogger("axistwin.links")

DEVICE_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError, *TERMIOS_ERRORS)
"""Exceptions of pyserial for a device that does not exist, is lost, or does not support a setting."""
READ_S = 0.02  # Timeout in seconds of a read; after it, a thread checks if it must close the device.
WRITE_S = 1.0  # Timeout of a write in seconds; characters that the device has not accepted by then are lost.

Receive = Callable[[bytes], None]
Lose = Callable[[str], None]


class Lines(Protocol):
    """The control lines of a serial device: the outputs DTR and RTS, and the inputs DSR and CTS."""

    dtr: bool
    rts: bool

    @property
    def dsr(self) -> bool: ...

    @property
    def cts(self) -> bool: ...


class DescriptorStream:
    """A stream that the event loop reads and writes."""

    def __init__(self, descriptor: int, name: str, receive: Receive, lose: Lose) -> None:
        self._descriptor, self._receive, self._lose = descriptor, receive, lose
        self._loop = asyncio.get_running_loop()
        self._writer = Writer(descriptor, name)
        self.resume()

    def write(self, data: bytes) -> None:
        self._writer.write(data)

    def pause(self) -> None:
        self._loop.remove_reader(self._descriptor)

    def resume(self) -> None:
        self._loop.add_reader(self._descriptor, self._readable)

    def close(self) -> None:
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
    """Transfers the characters of a device in two threads: one thread reads, the other thread writes."""

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
        """Queue characters for the device; those that do not fit into the queue are discarded."""
        room = STALLED - self._queued
        self._dropped += len(data[room:])
        if kept := data[:room]:
            self._queued += len(kept)
            self._worker.submit(self._write, kept)

    def pause(self) -> None:
        """Stop reading from the device, and keep the characters that have already been read."""
        self._paused = True

    def resume(self) -> None:
        self._paused = False
        held, self._held = bytes(self._held), bytearray()
        if held:
            self._receive(held)

    def close(self) -> None:
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
                self._call(self._lose, reason(error))
                return
            if data:
                self._call(self._take, data)

    def _write(self, data: bytes) -> None:
        lost = 0
        try:
            self._device.write(data)
        except DEVICE_ERRORS:  # After a failed write, count all characters in `data` as lost.
            lost = len(data)
        self._call(self._count, len(data), lost)

    def _call(self, callback: Callable[..., None], *arguments: Any) -> None:
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


Stream = DescriptorStream | ThreadStream  # Reads and writes an open device; calls back in the event loop.


def stream(device: "serial.Serial", name: str, receive: Receive, lose: Lose) -> Stream:
    """Return the stream of a device: by the event loop if the device has a file descriptor, otherwise by threads."""
    try:
        descriptor: int = device.fileno()
    except OSError:  # Windows
        return ThreadStream(device, name, receive, lose)
    return DescriptorStream(descriptor, name, receive, lose)


def settings_of(fmt: UartFormat) -> dict[str, Any]:
    return {"baudrate": fmt.baudrate, "bytesize": fmt.bytesize, "parity": fmt.parity, "stopbits": fmt.stopbits}


def control_lines(device: "serial.Serial") -> Lines | None:
    """Return a device's control lines; None if it has none, as a pseudo terminal."""
    try:
        device.dtr = device.dtr
    except OSError:
        return None
    lines: Lines = device
    return lines


@contextmanager
def opening(url: object) -> Iterator[None]:
    """Convert the errors of pyserial to LinkError within a `with` block."""
    try:
        yield
    except DEVICE_ERRORS as error:
        raise LinkError(cannot_open(url, error)) from None


def set_lines(of: Lines | HostEnd, dtr: bool, rts: bool) -> None:
    of.dtr, of.rts = dtr, rts
