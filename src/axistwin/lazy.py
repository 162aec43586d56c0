"""Lazy exports: a package imports its modules only when their names are first used."""

from collections.abc import Callable
from importlib import import_module
from typing import Any


def lazy(package: str, **names: str) -> Callable[[str], Any]:
    """Return the `__getattr__` of a package: `reading="Trace read"` exports these names of the module `reading`."""
    modules = {name: f"{package}.{module}" for module, listed in names.items() for name in listed.split()}

    def attribute(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(modules[name]), name)

    return attribute
