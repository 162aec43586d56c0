"""The journal of a stand-in: one line for each step command that is sent and each position that is read.

The last line of a completed run begins with `end` and has the positions and a check sum.  If the file does not end in
such a line, complete, the positions are unknown.
"""

import os
import re
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO
from zlib import crc32

from axistwin.core.errors import UsageError, reason
from axistwin.real.standin.writer import Writer

MOST_TAIL = 65_536  # Largest number of bytes that the last line of a journal can have.
LOST = "\nlost: lines are missing here\n"
END, FORMER_END = b"end ", b"was "


class Journal:
    """An open file; a thread writes, `note` never waits.  `tell`, in any thread, reports that writing fails."""

    def __init__(self, path: Path, title: str, tell: Callable[[str], None] = lambda line: None) -> None:
        """Write the start time and a title; the positions of the former run no longer count.

        Raises UsageError, and leaves the disk as it was, if the file cannot be written.
        """
        self.path, self._tell = path, tell
        self._lost = self._told = False
        try:
            new = not path.exists()
            self._file: BinaryIO = path.open("x+b" if new else "r+b", buffering=0)
            self._begin(f"begin {datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ} {title}\n", new=new)
        except OSError as error:
            raise UsageError(f"journal {path} cannot be written: {reason(error)}") from None
        self._writer = Writer("journal", self._append)

    def _begin(self, line: str, *, new: bool) -> None:
        size = self._file.seek(0, os.SEEK_END)
        tail = self._file.seek(max(0, size - MOST_TAIL))
        found = self._file.read()
        try:
            self._write("\n" * (size > 0 and not found.endswith(b"\n")) + line)
            os.fsync(self._file.fileno())
            self._forget(tail + found.rstrip(b"\n").rfind(b"\n") + 1)
        except OSError:
            with suppress(OSError):
                self._file.truncate(size)
            self._file.close()
            if new:
                self.path.unlink()
            raise

    def _forget(self, former: int) -> None:
        """Change the `end` of the former run: a file that loses its last lines must not end in it again."""
        self._file.seek(former)
        if self._file.read(len(END)) == END:
            self._file.seek(former)
            self._write(FORMER_END.decode())
        self._file.seek(0, os.SEEK_END)

    def note(self, line: str) -> None:
        """Append a line.  The method returns at once and raises nothing, whatever the disk does."""
        if not self._writer.put(line):
            self._lost = True

    def end(self, positions: Mapping[str, int]) -> bool:
        """Append the last line, with the final positions of the axes.  False: the positions could not be written."""
        self._writer.close()
        self._told = True
        if not self._writer.is_alive():
            self._append(f"{_end_line(positions)}\n")
            with suppress(OSError):
                os.fsync(self._file.fileno())
                return not self._lost
        return False

    def close(self) -> None:
        self._writer.close()
        if not self._writer.is_alive():
            self._file.close()

    def _append(self, text: str) -> None:
        """Write lines.  After a failure, perhaps in the middle of a line, the next lines begin with `LOST`."""
        lost, self._lost = self._lost, False
        try:
            self._write(LOST * lost + text)
        except OSError as error:
            self._lost = True
            if not self._told:
                self._told = True
                self._tell(
                    f"journal {self.path} cannot be written ({reason(error)}): the run goes on; "
                    "make room on the disk before its end, or the next start needs --unhomed"
                )

    def _write(self, text: str) -> None:
        data = memoryview(text.encode())
        while data:
            data = data[self._file.write(data) :]


def _end_line(positions: Mapping[str, int]) -> str:
    line = " ".join(["end", *(f"{axis}={position}" for axis, position in positions.items())])
    return f"{line} crc32={crc32(line.encode()):08x}"


def last_positions(path: Path, axes: Collection[str]) -> dict[str, int] | None:
    """Return the positions from the last line of a journal file; without a file, 0 for each axis.

    The result is None if the positions are unknown: after an interrupted run, in a damaged file, or if the line has
    not all axes.
    """
    try:
        with path.open("rb") as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - MOST_TAIL))
            lines = file.read().decode(errors="replace").split("\n")
    except FileNotFoundError:
        return dict.fromkeys(axes, 0)
    except OSError as error:
        raise UsageError(f"journal {path} cannot be read: {reason(error)}") from None
    line = lines[-2] if len(lines) > 1 and not lines[-1] else ""
    positions = {axis: int(position) for axis, position in re.findall(r"(\S+)=(-?[0-9]{1,30})(?= )", line)}
    return positions if line == _end_line(positions) and positions.keys() >= set(axes) else None
