"""From the relay to the twin's process: copies of all data with their times, through a pipe.

The relay never waits for the twin.  A thread writes; while the pipe is full, data wait in memory up to a limit, and are
then left out.  The twin is told how much.
"""

import time
from collections.abc import Iterator
from contextlib import suppress
from enum import IntEnum
from queue import Empty, Full, Queue
from struct import Struct
from threading import Thread
from typing import IO, NamedTuple

MOST_WAITING = 20_000  # Records that wait for a twin that is busy.
HEADER = Struct("<BqI")


class What(IntEnum):
    """What has happened."""

    HOST, MACHINE, FORMAT, AWAY, BACK, MISSED, LATE, SUMMARY = range(8)


class Record(NamedTuple):
    """Data or an event, with its time in nanoseconds since 1970."""

    what: What
    time_ns: int
    data: bytes = b""

    def pack(self) -> bytes:
        return HEADER.pack(self.what, self.time_ns, len(self.data)) + self.data


def records(stream: IO[bytes]) -> Iterator[Record]:
    """Yield the records of a stream until its end."""
    while len(header := stream.read(HEADER.size)) == HEADER.size:
        what, time_ns, size = HEADER.unpack(header)
        yield Record(What(what), time_ns, stream.read(size))


class Feed:
    """Writes records to the twin's process, after `first`.  `add` returns at once, whatever the twin does."""

    def __init__(self, stream: IO[bytes], ahead_ns: int, first: bytes = b"") -> None:
        self._stream, self._first = stream, first
        self._ahead_ns = ahead_ns  # `ahead_ns`: time since 1970 minus the monotonic clock.
        self._waiting: Queue[Record] = Queue(MOST_WAITING)
        self._missed = 0
        self.broken = False  # True if the twin's process has ended.
        self._moved_s = time.monotonic()
        self._ended = False
        self._thread = Thread(target=self._write, daemon=True)
        self._thread.start()

    def add(self, what: What, data: bytes = b"") -> bool:
        """Return True if the twin now learns that data before these were left out."""
        now_ns, left_out = time.monotonic_ns() + self._ahead_ns, False
        try:
            if self._missed:
                self._waiting.put_nowait(Record(What.MISSED, now_ns, b"%d" % self._missed))
                self._missed, left_out = 0, True
            self._waiting.put_nowait(Record(what, now_ns, data))
        except Full:
            self._missed += len(data)
        return left_out

    @property
    def stuck_s(self) -> float:
        """Seconds for which the twin has read nothing although data wait."""
        return 0.0 if self._waiting.empty() else time.monotonic() - self._moved_s

    def abandon(self) -> None:
        """End the stream of a twin that has ended; the relay does not wait."""
        self._ended = True

    def close(self) -> None:
        """Let the twin read what waits, for at most some seconds, and end the stream."""
        self._ended = True
        self._thread.join(5.0)

    def _write(self) -> None:
        try:
            self._stream.write(self._first)
            self._stream.flush()
            while not (self._ended and self._waiting.empty()):
                try:
                    record = self._waiting.get(timeout=0.05)
                except Empty:
                    continue
                self._moved_s = time.monotonic()
                self._stream.write(record.pack())
                self._stream.flush()
        except (OSError, ValueError):
            self.broken = True
        finally:
            with suppress(OSError):
                self._stream.close()
