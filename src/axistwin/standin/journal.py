"""The journal of a stand-in: one line for each step command that is sent and each position that is read.

The last line of a completed run begins with `end` and has the positions; without this line the positions are unknown.
"""

from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import TextIO

from axistwin.errors import UsageError
from axistwin.storage import reason

MOST_TAIL = 4096
"""Largest number of bytes that the last line of a journal can have."""


class Journal:
    """An open journal file, to which lines are appended."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: TextIO = _open(path)

    def note(self, line: str) -> None:
        """Append a line to the journal file, and flush the file."""
        self._file.write(f"{line}\n")
        self._file.flush()

    def begin(self, title: str) -> None:
        """Write the start time and a title into the journal file."""
        self.note(f"begin {datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ} {title}")

    def end(self, positions: Mapping[str, int]) -> None:
        """Append the last line of the journal file, with the final positions of the axes."""
        self.note("end " + " ".join(f"{axis}={position}" for axis, position in positions.items()))

    def close(self) -> None:
        """Close the journal file."""
        self._file.close()


def _open(path: Path) -> TextIO:
    try:
        return path.open("a", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"journal {path} cannot be written: {reason(error)}") from None


def last_positions(path: Path) -> dict[str, int] | None:
    """Return the axis positions from the last line of a journal file.

    The result is None if the positions are unknown after an interrupted run, and {} if there was no run.
    """
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - MOST_TAIL))
            lines = file.read().decode(errors="replace").splitlines()
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise UsageError(f"journal {path} cannot be read: {reason(error)}") from None
    if not lines:
        return {}
    word, *pairs = lines[-1].split()
    if word != "end":
        return None
    try:
        return {axis: int(position) for axis, _, position in (pair.partition("=") for pair in pairs)}
    except ValueError:
        return None
