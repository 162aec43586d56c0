"""Python files of users: their texts, their modules in this process, and their errors with file and line."""

import inspect
import linecache
import re
import shlex
import sys
import traceback
from collections.abc import Collection, Iterator
from contextlib import contextmanager, redirect_stdout
from importlib.util import decode_source
from pathlib import Path
from types import ModuleType
from zlib import crc32

from axistwin.controllers.registry import LOADED
from axistwin.core.errors import DeviceError, UsageError, reason


def source_of(path: str | Path) -> str:
    """Return the text of a Python file.  Raises DeviceError if it cannot be read."""
    try:
        return decode_source(Path(path).read_bytes())
    except OSError as error:
        raise DeviceError(
            f"cannot be read ({reason(error)}): expected a Python file, e.g. stage.py", file=str(path)
        ) from None
    except (SyntaxError, UnicodeDecodeError):
        raise DeviceError("not a Python file: expected text in UTF-8", file=str(path)) from None


@contextmanager
def executed(path: str | Path, text: str) -> Iterator[ModuleType]:
    """Execute the text of a file, which need not exist here, and yield its module.

    After a DeviceError, in the file or in the block, an earlier module of this file is in its place again.
    """
    full = str(Path(path).absolute())
    module = ModuleType(f"axistwin_device_{Path(full).stem}_{crc32(full.encode()):08x}")
    module.__file__ = full
    before = sys.modules.get(module.__name__)
    try:
        _execute(str(path), text, module)
        yield module
    except DeviceError:
        del sys.modules[module.__name__]
        if before is not None:
            sys.modules[module.__name__] = before
        raise


def _execute(shown: str, text: str, module: ModuleType) -> None:
    full = str(module.__file__)
    linecache.cache[full] = len(text), None, text.splitlines(keepends=True), full  # for tracebacks and `inspect`
    if (folder := str(Path(full).parent)) not in sys.path:
        sys.path.append(folder)
    sys.modules[module.__name__] = module
    try:
        with redirect_stdout(sys.stderr):  # The output of a command, or of the language server, is not the file's.
            exec(compile(text, full, "exec", dont_inherit=True), vars(module))  # noqa: S102  # the user asks for it
    except SyntaxError as error:
        file = shown if error.filename in (None, full) else str(error.filename)  # a module that the file imports
        raise DeviceError(f"{error.msg}: correct this line", file=file, line=error.lineno or 0) from None
    except (Exception, SystemExit) as error:  # noqa: BLE001  # of the user's code
        raise error_in(module, shown, error) from None


def error_in(module: ModuleType, shown: str, error: BaseException, line: int = 0) -> DeviceError:
    """Return the error of a file, at the deepest line in the file itself, or at `line`."""
    full = str(module.__file__)
    _, line = line_in(error, [full]) or (full, line)
    if isinstance(error, UsageError):  # One of ours, which may begin with the place.
        at = re.match(rf"{re.escape(Path(full).name)}:(\d+): ", str(error))
        return DeviceError(str(error)[at.end() if at else 0 :], file=shown, line=int(at[1]) if at else line)
    what = f"{type(error).__name__}{f': {error}' if str(error) else ''}"
    remedy = "correct this line"
    if isinstance(error, ModuleNotFoundError):
        what, remedy = f"no module {error.name!r}", "install it in the Python of axistwin, or put it beside the file"
    elif isinstance(error, SystemExit):
        what, remedy = "the file ends the program", 'put this line under if __name__ == "__main__":'
    return DeviceError(f"{what}: {remedy}", file=shown, line=line)


def line_in(error: BaseException, files: Collection[str]) -> tuple[str, int] | None:
    """Return file and line of the deepest frame of an error in these files; None if there is none."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in files]
    return (frames[-1].filename, frames[-1].lineno or 0) if frames else None


def files_of(kind: type, above: type) -> list[str]:
    """Return the files of the methods of a class and its bases, without those of the base `above`."""
    own = (method for base in kind.__mro__ if base is not above for method in vars(base).values())
    return [method.__code__.co_filename for method in own if inspect.isfunction(method)]


def place_of(kind: type, above: type) -> str:
    """Return file and line of a class for a message."""
    name = Path((*files_of(kind, above), kind.__module__)[0]).name
    try:
        return f"{name}:{inspect.getsourcelines(kind)[1]}"
    except (OSError, TypeError):  # A class that was typed, or made by a function, has no source.
        return name


def listing(model: str) -> str:
    """Return how a user lists the commands of a model of somebody else."""
    place = LOADED.get(model)
    file = f"--device {shlex.quote(place.where.rpartition(':')[0])} " if place else ""
    return f"`axistwin {file}commands {model}` lists all"
