"""Non-volatile memory: contents that are there when the power comes back."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EINVAL, ENOTSUP
from glob import escape
from logging import getLogger
from pathlib import Path
from typing import ClassVar
from weakref import WeakValueDictionary

from axistwin.errors import AxistwinError, UsageError

LOCK, HOLDER = ".axistwin.lock", ".axistwin.holder"
"""Files of a state directory: the lock, and who holds it: a process number, a blank, what the process runs."""
MOST_BYTES = 1 << 20
"""The largest file that can be the memory of a controller."""
LONGEST = 80

_log = getLogger("axistwin.state")


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

    def end(self) -> None:
        """Nothing can be lost when the power goes."""


class FileStore:
    """Kept in a file, which a crash at any moment leaves with the old or the new contents, never a mixture.

    The directory belongs to this process for as long as one of its controllers keeps something there.  If the file
    cannot be written, the contents are kept in RAM until the power is off; the file holds the last whole image.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._directory = _Directory.held(path.parent)
        _sweep(path)
        self.found = self._read()
        """What was there before; None: nothing."""
        self._image = self.found
        self._unwritten: bytes | None = None  # what should be in the file in the place of the image
        self._writes = self._failures = 0
        self._counted = 0
        """Failures that have been told with a count."""
        self._given_up = False

    def __str__(self) -> str:
        return str(self.path)

    def load(self) -> bytes | None:
        """What was saved last; None: nothing."""
        return self._image if self._unwritten is None else self._unwritten

    def save(self, contents: bytes) -> None:
        """Write a new file beside the old one, make sure it is on the disk, and let it take the old one's place.

        Where that fails the contents stay in RAM, which is told the first time after each end.
        """
        if self._given_up:
            return
        self._writes += 1
        try:
            self._write(contents)
        except OSError as error:
            self._failures += 1
            self._unwritten = contents
            if self._failures == self._counted + 1:
                told = (
                    f"{self.path} cannot be written: {reason(error)}: the memory is in RAM only until the power is off"
                )
                _log.warning("%s", told)

    def end(self) -> None:
        """The power is off, or the program ends: what could not be written is tried once more, and then forgotten.

        How many writes have failed is told, of all since this store was made.
        """
        if self._unwritten is not None:
            with suppress(OSError):
                self._write(self._unwritten)
        if self._failures > self._counted:
            _log.warning("%s", f"{self.path}: {self._failures} of {self._writes} writes failed: {self._outcome}")
        self._unwritten, self._counted = None, self._failures

    @property
    def _outcome(self) -> str:
        """What has become of the contents."""
        if self._unwritten is None:
            return "the file is up to date again"
        return "there is no file" if self._image is None else "the file holds the last whole image"

    def _write(self, contents: bytes) -> None:
        write_whole(self.path, contents)
        self._image, self._unwritten = contents, None

    def put_back(self) -> None:
        """It is again as it was found, for somebody else; this one keeps nothing any more.  Raises AxistwinError."""
        try:
            if self.found is not None:
                write_whole(self.path, self.found)
            else:
                self.path.unlink(missing_ok=True)
        except OSError as error:
            do = "remove" if self.found is None else "write"
            raise AxistwinError(f"cannot {do} {self.path}: {reason(error)}") from None
        self._given_up, self._unwritten, self._counted = True, None, self._failures

    def _read(self) -> bytes | None:
        """The file's contents; None: there is no file yet.  Raises UsageError if there is something else."""
        try:
            if self.path.exists() and not (self.path.is_file() or self.path.is_dir()):
                raise UsageError(f"cannot read {self.path}: it is no file")
            with self.path.open("rb") as file:
                contents = file.read(MOST_BYTES + 1)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise UsageError(f"cannot read {self.path}: {reason(error)}") from None
        if len(contents) > MOST_BYTES:
            raise UsageError(f"cannot read {self.path}: it has more than {MOST_BYTES} bytes: delete it")
        return contents


class _Directory:
    """A directory that belongs to this process: no other one can hold it before this is gone, or the process is."""

    _held: ClassVar[WeakValueDictionary[tuple[int, Path], "_Directory"]] = WeakValueDictionary()

    def __init__(self, path: Path) -> None:
        from filelock import FileLock, Timeout  # lazy import: only those who keep state need it

        (path / LOCK).touch()  # what cannot be written is no lock of others
        self._lock = FileLock(path / LOCK, timeout=0, thread_local=False)
        try:
            self._lock.acquire()
        except Timeout:
            raise UsageError(
                f"state directory {path} is in use by {_holder(path)}: end that one, or choose another directory"
            ) from None
        try:
            _sweep(path / HOLDER)
            write_whole(path / HOLDER, f"{os.getpid()} {_program()}\n".encode())
        except OSError:
            self._lock.release()
            raise

    @classmethod
    def held(cls, path: Path) -> "_Directory":
        """This directory, made if need be; shared by those of this process that ask for it.

        Raises UsageError if another process holds it, or if nothing can be written there.
        """
        with _told(path):
            path.mkdir(parents=True, exist_ok=True)
            key = os.getpid(), path.resolve()
            found = cls._held.get(key)
            if found is None:
                found = cls._held[key] = cls(path)
            return found


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """What is wrong with a state directory, in a line.  Raises UsageError."""
    try:
        yield
    except OSError as error:
        wrong = "cannot be written" if path.is_dir() else "cannot be made"
        raise UsageError(f"state directory {path} {wrong}: {reason(error)}: choose another directory") from None
    except ValueError as error:  # a NUL
        raise UsageError(f"no state directory {str(path)!r}: {error}") from None


def _holder(path: Path) -> str:
    """Who holds a directory, as far as that is known."""
    try:
        with (path / HOLDER).open("rb") as file:
            number, _, program = file.read(2 * LONGEST).decode(errors="replace").partition(" ")
    except OSError:
        number, program = "", ""
    if not number.isdecimal() or not _alive(int(number)):  # the note is of one that was killed
        return "another process"
    return f"process {number} ({one_line(program)})" if program.strip() else f"process {number}"


def _alive(number: int) -> bool:
    """False if there is certainly no process of this number."""
    if os.name == "nt":
        return True
    try:
        os.kill(number, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


def _program() -> str:
    """What this process runs, in a few words: options may be secret and are left out."""
    path, *arguments = [str(argument) for argument in getattr(sys, "argv", None) or [""]]
    name = Path(path).parent.name if Path(path).name == "__main__.py" else Path(path).name
    words = [name if name not in ("", "-c", "-m") else "python"]
    for argument in arguments:
        if argument.startswith("-"):
            break
        words.append(argument)
    return one_line(" ".join(words))


def write_whole(path: Path, contents: bytes) -> None:
    """Write a file by way of a new one beside it, of a name of its own, that takes its place when it is on the disk.

    Raises OSError; the file is then as it was.
    """
    beside = path.with_name(f"{path.name}.{os.urandom(6).hex()}.new")
    try:
        with beside.open("xb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, path)
    except OSError:
        with suppress(OSError):
            beside.unlink()
        raise
    _sync(path.parent)


def _sweep(path: Path) -> None:
    """Remove what a process left behind that was killed while it wrote this file."""
    for left in path.parent.glob(f"{escape(path.name)}*.new"):
        with suppress(OSError):
            left.unlink()


def _sync(path: Path) -> None:
    """Make sure that the names in a directory are on the disk, where the system can do that."""
    if os.name == "nt":
        return
    directory = os.open(path, os.O_RDONLY)
    try:
        os.fsync(directory)
    except OSError as error:
        if error.errno not in (EINVAL, ENOTSUP):
            raise
    finally:
        os.close(directory)


def reason(error: OSError) -> str:
    """Why the system has refused something."""
    return (error.strerror or str(error)).lower()


def one_line(text: object) -> str:
    """A text, or what an error says, in one short line."""
    line = " ".join("".join(letter if letter.isprintable() else " " for letter in str(text)).split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"
