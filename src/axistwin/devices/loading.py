"""Load devices from Python files: for this process, and as texts for the processes that it starts."""

import inspect
import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from axistwin.controllers.files import error_in, executed, source_of
from axistwin.controllers.registry import FILES, LOADED, Place, check_name
from axistwin.core.errors import DeviceError
from axistwin.devices.device import Device
from axistwin.devices.making import product_of


def load(path: str | Path) -> tuple[type[Device], ...]:
    """Load the devices of a Python file: the classes in it that derive from `Device` and have a `model`.

    Then their models have names, as ours have.  The file may import modules beside it.  A file that has changed is
    loaded again.  Raises DeviceError with file and line.
    """
    return load_text(path, source_of(path))


def load_text(path: str | Path, text: str) -> tuple[type[Device], ...]:
    """Load the devices of a Python file from its text; the file need not exist here."""
    for name, (_, there) in FILES.items():
        if there == text:  # The same file, or a copy of it, e.g. in an FMU.
            return tuple(_classes(sys.modules[name]))
    with executed(path, text) as module:
        own = {name for name, place in LOADED.items() if place.object.startswith(f"{module.__name__}:")}
        found = _places(str(path), module, {name: LOADED[name] for name in LOADED if name not in own})
    for name in own:
        del LOADED[name]
    LOADED.update(found)
    FILES[module.__name__] = str(module.__file__), text
    return tuple(_classes(module))


def load_texts(texts: Mapping[str, str]) -> None:
    for path, text in texts.items():
        load_text(path, text)


def _classes(module: ModuleType) -> dict[Any, str]:
    return {
        each: name
        for name, each in vars(module).items()
        if isinstance(each, type) and issubclass(each, Device)
        and each.__module__ == module.__name__ and "model" in vars(each)
    }  # fmt: skip


def _places(shown: str, module: ModuleType, others: Mapping[str, Place]) -> dict[str, Place]:
    """Return the places of the models of a file.  Raises DeviceError for a wrong class or a name of others."""
    found: dict[str, Place] = {}
    for kind, name in _classes(module).items():
        line = inspect.getsourcelines(kind)[1]
        try:
            model = product_of(kind).model
            check_name(model, f"class {name}")
        except Exception as error:  # noqa: BLE001  # of figures that are no figures, e.g. axes = 5
            raise error_in(module, shown, error, line) from None
        if other := {**others, **found}.get(model):
            raise DeviceError(
                f"the model {model!r} is also in {other.where}: give one of them another name", file=shown, line=line
            )
        found[model] = Place(f"{module.__name__}:{name}", f"{shown}:{line}")
    if not found:
        what = "no class that derives from axistwin.devices.Device and has a model"
        raise DeviceError(f'{what}: expected e.g. class Stage(Device): model = "stage"', file=shown)
    return found
