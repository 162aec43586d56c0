"""Non-volatile memory: contents that are there when the power comes back."""

import os
from pathlib import Path

from axistwin.errors import AxistwinError, UsageError


class MemoryStore:
    """Kept as long as the bench."""

    def __init__(self) -> None:
        self._contents: bytes | None = None

    def load(self) -> bytes | None:
        """What was saved last."""
        return self._contents

    def save(self, contents: bytes) -> None:
        """Keep this."""
        self._contents = contents


class FileStore:
    """Kept in a file, which a crash at any moment leaves with the old or the new contents, never a mixture."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"no state directory {path.parent}: {(error.strerror or str(error)).lower()}") from None
        except ValueError as error:  # a NUL
            raise UsageError(f"no state directory {str(path.parent)!r}: {error}") from None
        self.found = self.load()
        """What was there before; None: nothing."""
        self._given_up = False

    def __str__(self) -> str:
        return str(self.path)

    def load(self) -> bytes | None:
        """The file's contents; None: there is no file yet.  Raises UsageError if it cannot be read."""
        try:
            return self.path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise UsageError(f"cannot read {self.path}: {(error.strerror or str(error)).lower()}") from None

    def save(self, contents: bytes) -> None:
        """Write a new file beside the old one, make sure it is on the disk, and let it take the old one's place."""
        if self._given_up:
            return
        try:
            self._write(contents)
        except OSError as error:
            raise AxistwinError(
                f"cannot keep {self.path}: {(error.strerror or str(error)).lower()}: choose another state directory"
            ) from None

    def put_back(self) -> None:
        """It is again as it was found, for somebody else; this one keeps nothing any more.  Raises AxistwinError."""
        if self.found is not None:
            self.save(self.found)
        else:
            self._remove()
        self._given_up = True

    def _remove(self) -> None:
        try:
            self.path.unlink(missing_ok=True)
        except OSError as error:
            raise AxistwinError(f"cannot remove {self.path}: {(error.strerror or str(error)).lower()}") from None

    def _write(self, contents: bytes) -> None:
        beside = self.path.with_name(self.path.name + ".new")
        with beside.open("wb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, self.path)
        directory = os.open(self.path.parent, os.O_RDONLY)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)
