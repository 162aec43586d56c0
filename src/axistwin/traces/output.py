"""The file of a trace, which grows by whole pieces."""

import os
from collections.abc import Mapping
from pathlib import Path

Provenance = Mapping[str, str]


class Output:
    """A file that grows by whole pieces.  Raises OSError if the disk is full; its former contents are kept."""

    def __init__(self, path: Path) -> None:
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o666)
        self._size = 0

    def append(self, data: bytes) -> None:
        """Append a piece."""
        self.replace_end(data, 0)

    def replace_end(self, data: bytes, of: int) -> None:
        """Replace the last `of` bytes by a piece; restore them if the write fails."""
        start = self._size - of
        before = os.pread(self._file, of, start)
        try:
            _write_at(self._file, data, start)
        except BaseException:
            _write_at(self._file, before, start)
            os.ftruncate(self._file, self._size)
            raise
        self._size = start + len(data)
        os.ftruncate(self._file, self._size)

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


def _write_at(file: int, data: bytes, place: int) -> None:
    left = memoryview(data)
    while left:
        written = os.pwrite(file, left, place)
        left, place = left[written:], place + written
