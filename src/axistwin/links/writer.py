"""Buffered writing to a non-blocking file descriptor."""

import asyncio
import os
from logging import getLogger

log = getLogger("axistwin.links")

STALLED = 64 * 1024  # Largest number of bytes that are buffered for a slow reader, in addition to the system's buffer.


class Writer:
    """Writes to a non-blocking file descriptor, and discards the newest characters when the buffer is full."""

    def __init__(self, descriptor: int, name: str) -> None:
        self.descriptor, self.name = descriptor, name
        self._loop = asyncio.get_running_loop()
        self._waiting, self._dropped = bytearray(), 0

    def write(self, data: bytes) -> None:
        """Write data to the descriptor, and buffer the bytes that the descriptor does not accept yet."""
        if not self._waiting:
            data = data[self._write(data) :]
            if data:
                self._loop.add_writer(self.descriptor, self._go_on)
        room = STALLED - len(self._waiting)
        self._waiting += data[:room]
        self._dropped += len(data[room:])

    def clear(self) -> None:
        self._waiting.clear()
        self._loop.remove_writer(self.descriptor)

    def _go_on(self) -> None:
        del self._waiting[: self._write(bytes(self._waiting))]
        if self._waiting:
            return
        self._loop.remove_writer(self.descriptor)
        if self._dropped:
            log.warning("%s: reader too slow, %d characters were lost", self.name, self._dropped)
            self._dropped = 0

    def _write(self, data: bytes) -> int:
        try:
            return os.write(self.descriptor, data)
        except BlockingIOError:
            return 0
        except OSError:  # Data that cannot be written are discarded.
            return len(data)
