"""Load devices from Python files: for this process, and as texts for the processes that it starts."""

import inspect
import linecache
import re
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import redirect_stdout
from importlib.util import decode_source
from pathlib import Path
from types import ModuleType
from typing import Any
from zlib import crc32

from axistwin.controllers.registry import FILES, LOADED, Place, check_name
from axistwin.core.errors import DeviceError, UsageError, reason
from axistwin.devices.device import Device
from axistwin.devices.making import product_of

EXAMPLE = 'class Stage(Device): model = "stage"'


def load(path: str | Path) -> tuple[type[Device], ...]:
    """Load the devices of a Python file: the classes in it that derive from `Device` and have a `model`.

    Then their models have names, as ours have.  The file may import modules beside it.  A file that has changed is
    loaded again.  Raises DeviceError with file and line.
    """
    file = Path(path)
    try:
        text = decode_source(file.read_bytes())
    except OSError as error:
        raise DeviceError(
            f"cannot be read ({reason(error)}): expected a Python file, e.g. stage.py", file=str(path)
        ) from None
    except (SyntaxError, UnicodeDecodeError):
        raise DeviceError("not a Python file: expected text in UTF-8", file=str(path)) from None
    return load_text(file, text)


def load_text(path: str | Path, text: str) -> tuple[type[Device], ...]:
    """Load the devices of a Python file from its text; the file need not exist here."""
    shown, full = str(path), str(Path(path).absolute())
    for name, (_, there) in FILES.items():
        if there == text:  # The same file, or a copy of it, e.g. in an FMU.
            return tuple(_classes(sys.modules[name]).values())
    module = ModuleType(f"axistwin_device_{Path(full).stem}_{crc32(full.encode()):08x}")
    before = sys.modules.get(module.__name__)
    try:
        _execute(shown, full, text, module)
        places = _places(shown, full, module)
    except DeviceError:
        del sys.modules[module.__name__]
        if before is not None:
            sys.modules[module.__name__] = before
        raise
    for name in [name for name, place in LOADED.items() if place.object.startswith(f"{module.__name__}:")]:
        del LOADED[name]
    LOADED.update(places)
    FILES[module.__name__] = full, text
    return tuple(_classes(module).values())


def load_texts(texts: Mapping[str, str]) -> None:
    for path, text in texts.items():
        load_text(path, text)


def _execute(shown: str, full: str, text: str, module: ModuleType) -> None:
    module.__file__ = full
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
        raise _error(shown, full, error) from None


def _error(shown: str, full: str, error: BaseException, line: int = 0) -> DeviceError:
    """Return the error of a file, at the deepest line in the file itself."""
    lines = [frame.lineno or 0 for frame in traceback.extract_tb(error.__traceback__) if frame.filename == full]
    line = lines[-1] if lines else line
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


def _classes(module: ModuleType) -> dict[str, Any]:
    found = {
        id(each): (name, each)
        for name, each in vars(module).items()
        if isinstance(each, type) and issubclass(each, Device)
        and each.__module__ == module.__name__ and "model" in vars(each)
    }  # fmt: skip
    return dict(found.values())


def _places(shown: str, full: str, module: ModuleType) -> dict[str, Place]:
    """Return the places of the models of a file.  Raises DeviceError for a wrong class or a name in use."""
    found: dict[str, Place] = {}
    for name, kind in _classes(module).items():
        line = inspect.getsourcelines(kind)[1]
        try:
            model = product_of(kind).model
            check_name(model, f"class {name}")
        except Exception as error:  # noqa: BLE001  # of figures that are no figures, e.g. axes = 5
            raise _error(shown, full, error, line) from None
        place = Place(f"{module.__name__}:{name}", f"{shown}:{line}")
        for other in _others(model, module, found):
            raise DeviceError(
                f"the model {model!r} is also in {other.where}: give one of them another name", file=shown, line=line
            )
        found[model] = place
    if not found:
        raise DeviceError(
            f"no class that derives from axistwin.devices.Device and has a model: expected e.g. {EXAMPLE}", file=shown
        )
    return found


def _others(model: str, module: ModuleType, found: Mapping[str, Place]) -> Iterator[Place]:
    if model in found:
        yield found[model]
    elif model in LOADED and not LOADED[model].object.startswith(f"{module.__name__}:"):
        yield LOADED[model]
