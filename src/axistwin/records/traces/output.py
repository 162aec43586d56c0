"""A file to which each block is written completely or not at all."""

import os
from collections.abc import Mapping
from errno import EFBIG
from pathlib import Path

Provenance = Mapping[str, str]
BINARY: int = getattr(os, "O_BINARY", 0)
"""Flag for binary files; without this flag, Windows would write CR LF for each LF."""


class LimitReachedError(OSError):
    """Raised if a file would become longer than its limit."""

    def __init__(self, message: str) -> None:
        super().__init__(EFBIG, message)


class Output:
    """A file whose blocks are written completely, or raise OSError.  `limit`: largest size in bytes."""

    def __init__(self, path: Path, limit: int | None = None) -> None:
        self._limit = limit
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | BINARY, 0o666)
        self._size = 0

    def append(self, data: bytes) -> None:
        """Append a block.  Raises OSError if it cannot be written; the file is then unchanged."""
        self.replace_end(data, 0)

    def replace_end(self, data: bytes, of: int) -> None:
        """Replace the last `of` bytes of the file.  Raises OSError; the file is then unchanged."""
        start = self._size - of
        if self._limit is not None and start + len(data) > self._limit:
            size = f"{self._limit / 1e6:g} MB" if self._limit >= 1000 else f"{self._limit} bytes"
            raise LimitReachedError(
                f"the trace file has reached the size limit of {size} and receives no more data: "
                "set a larger limit, e.g. --trace-limit 5GB"
            )
        os.lseek(self._file, start, os.SEEK_SET)
        before = os.read(self._file, of)
        try:
            _write_at(self._file, data, start)
        except BaseException:
            _write_at(self._file, before, start)
            os.ftruncate(self._file, self._size)
            raise
        self._size = start + len(data)
        os.ftruncate(self._file, self._size)

    def close(self) -> None:
        os.close(self._file)


def _write_at(file: int, data: bytes, place: int) -> None:
    left = memoryview(data)
    while left:
        written = _write_part(file, left, place)
        left, place = left[written:], place + written


def _write_part(file: int, data: memoryview, place: int) -> int:
    """Write at least one byte at a place in a file; return the number of written bytes."""
    os.lseek(file, place, os.SEEK_SET)
    return os.write(file, data)
