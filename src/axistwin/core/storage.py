"""Non-volatile memory of controllers, whose contents are kept without power; and the encodings of text files."""

import codecs
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from errno import EDQUOT, EFBIG, EINVAL, EIO, ENOSPC, ENOTSUP
from glob import escape
from logging import getLogger
from pathlib import Path
from typing import TextIO
from weakref import WeakKeyDictionary, WeakValueDictionary

from axistwin.core.errors import AxistwinError, UsageError, reason

LOCK, HOLDER = ".axistwin.lock", ".axistwin.holder"
"""Files of a state directory: the lock, and its holder (process number, blank, the program's name)."""
MOST_BYTES = 1 << 20  # Maximum size of a controller's memory file.
FULL = {ENOSPC, EDQUOT, EIO, EFBIG}  # Error numbers of a full or broken disk.
LONGEST = 80
STANDARD_INPUT = Path("-")  # This object, and no equal path, stands for the standard input.
MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
"""Byte order marks with their encodings."""
DOS, WINDOWS = "cp850", "latin-1"  # Encodings of old texts.  Code page 437 has the letters of 850 in the same places.
TYPOGRAPHIC = {0x84, *range(0x91, 0x98)}  # Bytes of quotation marks, a bullet and dashes in code page 1252 of Windows.

_log = getLogger("axistwin.state")


class MemoryStore:
    """Emulated non-volatile memory of a controller.  The contents are kept in the computer's RAM, not in a file."""

    lost = False

    def __init__(self) -> None:
        self._contents: bytes | None = None

    def load(self) -> bytes | None:
        """Return the contents that `save` has stored, or None before the first `save`."""
        return self._contents

    def save(self, contents: bytes) -> None:
        self._contents = contents

    def end(self) -> None: ...


class FileStore:
    """A file that contains the emulated non-volatile memory of a controller.

    After a crash, the file has either the old or the new contents, never a mixture.  The directory belongs to this
    process while one of its controllers stores memory there.  If the file cannot be written, the contents stay in RAM
    until the power is off; the file keeps the last complete image.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._directory = _state_directory(path.parent)
        _sweep(path)
        self.found = self._read()  # Contents of the file when the store was created; None if there was no file.
        self._image = self.found
        self._unwritten: bytes | None = None
        """Contents of the emulated memory if the last write to the file has failed; otherwise None."""
        self._writes = self._failures = 0
        self._counted = 0  # Number of failed writes that the log already contains.
        self._given_up = False
        self.lost = False
        """True if contents were lost when the power was switched off, and no others have been written since."""

    def __str__(self) -> str:
        return str(self.path)

    def load(self) -> bytes | None:
        return self._image if self._unwritten is None else self._unwritten

    def save(self, contents: bytes) -> None:
        """Write a temporary file, flush the file to disk, and rename it to replace the old file.

        If writing fails, the contents stay in RAM; the first failure after each call of `end` is logged.
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
                warning = (
                    f"{self.path} cannot be written: {reason(error)}: the memory is in RAM only until the power is off"
                )
                _log.warning("%s", warning)

    def end(self) -> None:
        """If the last write has failed, try one more time to write the file.

        Called when the controller is switched off or the program ends.  The contents are then discarded.  The number of
        failed writes since this store was made is logged.
        """
        if self._unwritten is not None:
            with suppress(OSError):
                self._write(self._unwritten)
        if self._failures > self._counted:
            _log.warning("%s", f"{self.path}: {self._failures} of {self._writes} writes failed: {self._outcome}")
        self.lost |= self._unwritten is not None
        self._unwritten, self._counted = None, self._failures

    @property
    def _outcome(self) -> str:
        if self._unwritten is None:
            return "the file is up to date again"
        return "there is no file" if self._image is None else "the file has the contents of the last complete write"

    def _write(self, contents: bytes) -> None:
        write_whole(self.path, contents)
        self._image, self._unwritten, self.lost = contents, None, False

    def put_back(self) -> None:
        """Restore the contents that the file had when the simulation began.

        Later calls of `save` change nothing.  Raises AxistwinError if the original contents cannot be restored.
        """
        try:
            if self.found is not None:
                write_whole(self.path, self.found)
            else:
                self.path.unlink(missing_ok=True)
        except OSError as error:
            remove_or_write = "remove" if self.found is None else "write"
            raise AxistwinError(f"cannot {remove_or_write} the file {self.path}: {reason(error)}") from None
        self._given_up, self._unwritten, self._counted = True, None, self._failures

    def _read(self) -> bytes | None:
        try:
            if self.path.exists() and not (self.path.is_file() or self.path.is_dir()):
                raise UsageError(f"cannot read {self.path}: expected a regular file")
            with self.path.open("rb") as file:
                contents = file.read(MOST_BYTES + 1)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise UsageError(f"cannot read {self.path}: {reason(error)}") from None
        if len(contents) > MOST_BYTES:
            raise UsageError(
                f"the controller's memory file {self.path} is invalid (larger than {MOST_BYTES} bytes): "
                "delete the file to start the controller without stored data"
            )
        return contents


class Lock:
    """Lock of a directory, which excludes other processes.

    It ends with `release`, or when this object is deleted or this process ends.  Raises UsageError; `in_use` makes its
    text from the other process, e.g. "process 4711 (axistwin serve)".
    """

    def __init__(self, path: Path, in_use: Callable[[str], str]) -> None:
        from filelock import FileLock, Timeout

        (path / LOCK).touch()  # Creating the lock file fails in a read-only directory.
        self._lock = FileLock(path / LOCK, timeout=0, thread_local=False)
        try:
            self._lock.acquire()
        except Timeout:
            raise UsageError(in_use(_holder(path))) from None
        try:
            _sweep(path / HOLDER)
            write_whole(path / HOLDER, f"{os.getpid()} {_program()}\n".encode())
        except OSError:
            self._lock.release()
            raise

    def release(self) -> None:
        self._lock.release()


_held: WeakValueDictionary[tuple[int, Path], Lock] = WeakValueDictionary()  # The state directories of this process.


def _state_directory(path: Path) -> Lock:
    """Create the directory if necessary, and reserve the directory for this process.

    Raises UsageError if another process holds the directory, or if the directory is not writable.
    """
    with _readable_errors(path):
        path.mkdir(parents=True, exist_ok=True)
        key = os.getpid(), path.resolve()
        found = _held.get(key)
        if found is None:
            found = _held[key] = Lock(
                path,
                lambda other: (
                    f"state directory {path} is in use by {other}: end that process, or choose another directory"
                ),
            )
        return found


@contextmanager
def _readable_errors(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        write_or_make = "write" if os.path.isdir(path) else "make"  # `is_dir` raises for a long name
        raise write_error(f"cannot {write_or_make} state directory {path}", error, "choose another directory") from None
    except ValueError:
        raise UsageError(
            f"invalid state directory {str(path)!r}: expected a path without NUL characters, e.g. ./state"
        ) from None


def _holder(path: Path) -> str:
    try:
        with (path / HOLDER).open("rb") as file:
            number, _, program = file.read(2 * LONGEST).decode(errors="replace").partition(" ")
    except OSError:
        number, program = "", ""
    # The file `HOLDER` may contain the ID of a process that has ended, e.g. of a killed process.
    if not number.isdecimal() or not _alive(int(number)):
        return "another process"
    return f"process {number} ({excerpt(program)})" if program.strip() else f"process {number}"


def _alive(number: int) -> bool:
    """True if a process with the ID `number` exists.  Also True if the system cannot answer the question."""
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
    """Return the command of this process without its options, because options may contain secrets."""
    path, *arguments = [str(argument) for argument in getattr(sys, "argv", None) or [""]]
    name = Path(path).parent.name if Path(path).name == "__main__.py" else Path(path).name
    words = [name if name not in ("", "-c", "-m") else "python"]
    for argument in arguments:
        if argument.startswith("-"):
            break
        words.append(argument)
    return excerpt(" ".join(words))


def write_whole(path: Path, contents: bytes) -> None:
    """Write a file completely or not at all: write a temporary file, flush it to disk, and rename it.

    A file that is there keeps its permissions.  Raises OSError; the file is then unchanged.
    """
    beside = path.with_name(f"{path.name}.{os.urandom(6).hex()}.new")
    try:
        with beside.open("xb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        with suppress(FileNotFoundError):
            os.chmod(beside, path.stat().st_mode & 0o7777)
        os.replace(beside, path)
    except OSError:
        with suppress(OSError):
            beside.unlink()
        raise
    _sync(path.parent)


def read_file(path: Path) -> bytes:
    """Return the contents of a file that the user has named.

    Raises UsageError for a directory, a pipe or a device, which may never end, and OSError for other reasons.
    """
    try:
        if path.exists() and not path.is_file():
            raise UsageError(f"{path} cannot be read: expected an ordinary file, not a directory or device")
        return path.read_bytes()
    except ValueError:  # The name contains a NUL.
        raise UsageError(f"{str(path)!r} cannot be read: expected the name of a file") from None


def write_file(path: Path, contents: bytes | str, text: str = "") -> None:
    """Write a file for the user completely or not at all; a device or a pipe is written directly.

    Raises UsageError or AxistwinError, as `write_error`.  `text`: what cannot be done, for the message.
    """
    data = contents.encode() if isinstance(contents, str) else contents
    try:
        target = path.resolve()
        if target.exists() and not target.is_file():
            target.write_bytes(data)
        else:
            write_whole(target, data)
    except OSError as error:
        raise write_error(text or f"{path} cannot be written", error) from None


def write_error(text: str, error: OSError, remedy: str = "") -> AxistwinError:
    """Return the error for a file that cannot be written: a UsageError, except if the disk is full or broken."""
    kind = AxistwinError if error.errno in FULL else UsageError
    return kind(f"{text} ({reason(error)}): {remedy}" if remedy else f"{text}: {reason(error)}")


def _sweep(path: Path) -> None:
    """Delete the temporary files (`*.new`) of a process that was killed while it wrote the memory file `path`."""
    for left in path.parent.glob(f"{escape(path.name)}*.new"):
        with suppress(OSError):
            left.unlink()


def _sync(path: Path) -> None:
    """Flush a directory (its list of names) to disk, if the system supports this."""
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


def user_cache() -> Path:
    """Return the user's cache directory.  Raises RuntimeError if the user has no home directory."""
    if sys.platform == "win32":
        cache = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    elif sys.platform == "darwin":
        cache = Path.home() / "Library" / "Caches"
    else:
        given = os.environ.get("XDG_CACHE_HOME", "")
        cache = Path(given) if os.path.isabs(given) else Path.home() / ".cache"
    return cache / "axistwin"


def excerpt(text: object) -> str:
    line = " ".join("".join(letter if letter.isprintable() else " " for letter in str(text)).split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"


@contextmanager
def explaining_memory_errors(memory_file: object, controller: str) -> Iterator[None]:
    """Convert an error in the contents of a memory file, within a `with` block, to a UsageError with the remedy.

    `controller`: the kind of controller to which the file belongs, e.g. "an IF2".
    """
    try:
        yield
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise UsageError(
            f"{memory_file} is not a memory file of {controller} ({excerpt(error)}): "
            "delete the file to start without data"
        ) from None


def check_key(key: str, valid: bool, expected: str) -> None:
    """Raise ValueError if the value of a key in a memory file is not valid.  `expected`: e.g. "true or false"."""
    if not valid:
        raise ValueError(f"invalid value of the key {key!r}: expected {expected}")


_piped: WeakKeyDictionary[TextIO, bytes] = WeakKeyDictionary()


def contents(path: Path, most_mib: int) -> bytes:
    """Return the bytes of an ordinary file, or of `STANDARD_INPUT`, which is read once.  Raises UsageError."""
    if path is STANDARD_INPUT:
        if sys.stdin is None:
            raise UsageError("the standard input is closed: expected a program, e.g. axistwin check if1 - < a.if1")
        if sys.stdin not in _piped:
            _piped[sys.stdin] = sys.stdin.buffer.read()
        return _piped[sys.stdin]
    try:
        if path.is_file() and path.stat().st_size > most_mib << 20:
            raise UsageError(f"{path} is too large: expected a file of at most {most_mib} MiB")
        return read_file(path)
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from None


def split_at_end(data: bytes) -> tuple[bytes, bytes]:
    """Split a text file at Ctrl-Z, the end-of-file mark of DOS editors, behind which old contents may follow."""
    if encoding_of(data) == "utf-16":
        return data, b""
    text, end, rest = data.partition(b"\x1a")
    return text, end + rest


def encoding_of(data: bytes) -> str:
    """Return the encoding of a text file, e.g. UTF-8.

    A byte order mark decides; without one, the encoding is UTF-8 if possible, otherwise a code page.
    In code pages 437 and 850 most national letters are bytes from 80h to 9Fh, which are no letters in Latin-1, but
    typographic characters of Windows: a pair of quotation marks or a dash among nothing else decides for Windows.
    """
    for mark, encoding in MARKS.items():
        if data.startswith(mark):
            return encoding
    try:
        data.decode()
    except UnicodeDecodeError:
        high = {byte for byte in data if 0x80 <= byte <= 0x9F}
        typographic = high <= TYPOGRAPHIC and (high >= {0x93, 0x94} or 0x96 in high)
        return "cp1252" if typographic else DOS if high else WINDOWS
    return "utf-8"


def state_file(name: str) -> Path:
    """Return the path of a file that the program keeps for its user from one session to the next."""
    usual = Path.home() / (".local/state" if os.name == "posix" else "AppData/Local")
    state = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA") or usual
    return Path(state) / "axistwin" / name
