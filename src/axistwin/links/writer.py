"""Writing to a file descriptor that may not take everything at once."""

import asyncio
import os
from logging import getLogger

log = getLogger("axistwin.links")

STALLED = 64 * 1024
"""What is kept for a reader that does not read, beyond what the system keeps."""


class Writer:
    """Writes to a non-blocking descriptor; what the reader does not take in time is lost, the newest first."""

    def __init__(self, descriptor: int, name: str) -> None:
        self.descriptor, self.name = descriptor, name
        self._loop = asyncio.get_running_loop()
        self._waiting = bytearray()
        self._dropped = 0

    def write(self, data: bytes) -> None:
        """Write now, or later as the reader takes it."""
        if not self._waiting:
            data = data[self._write(data) :]
            if data:
                self._loop.add_writer(self.descriptor, self._go_on)
        room = STALLED - len(self._waiting)
        self._waiting += data[:room]
        self._dropped += len(data[room:])

    def clear(self) -> None:
        """Forget what has not been taken."""
        self._waiting.clear()
        self._loop.remove_writer(self.descriptor)

    def _go_on(self) -> None:
        del self._waiting[: self._write(bytes(self._waiting))]
        if self._waiting:
            return
        self._loop.remove_writer(self.descriptor)
        if self._dropped:
            log.warning("%s did not take %d characters: they were lost", self.name, self._dropped)
            self._dropped = 0

    def _write(self, data: bytes) -> int:
        try:
            return os.write(self.descriptor, data)
        except BlockingIOError:
            return 0
        except OSError:  # nobody at the other end any more; reading tells, and is acted upon
            return len(data)
