"""What is imported only when it is first used: the modules of a package, NumPy, pyarrow and pyserial."""

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    import pyarrow as pa
    import pyarrow.compute as pc
    import pyarrow.parquet as pq
    import serial
    from numpy.typing import NDArray

__all__ = ["NDArray", "lazy", "np", "pa", "pc", "pq", "serial"]


class _Module:
    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        found = getattr(import_module(self._name), attribute)
        setattr(self, attribute, found)  # The next use of the attribute is as fast as that of a module.
        return found


if not TYPE_CHECKING:
    np, NDArray = _Module("numpy"), Any
    pa, pc, pq = _Module("pyarrow"), _Module("pyarrow.compute"), _Module("pyarrow.parquet")
    serial = _Module("serial")


def lazy(package: str, **names: str) -> Callable[[str], Any]:
    """Return the `__getattr__` of a package: `reading="Trace read"` exports these names of the module `reading`."""
    modules = {name: f"{package}.{module}" for module, listed in names.items() for name in listed.split()}

    def attribute(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(modules[name]), name)

    return attribute
