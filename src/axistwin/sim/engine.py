"""SimPy, imported without `importlib.metadata`, which would take a sixth of the time to start a server.

SimPy needs that module only to read its own version.  Here `simpy.__version__` is read on first use instead.
"""

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

METADATA = "importlib.metadata"


@contextmanager
def _without_metadata() -> Iterator[None]:
    """Replace `importlib.metadata` by an empty module within a `with` block, unless SimPy or the module is imported."""
    if METADATA in sys.modules or "simpy" in sys.modules:
        yield
        return
    empty = ModuleType(METADATA)
    empty.__dict__.update(version=lambda name: "", PackageNotFoundError=LookupError)
    sys.modules[METADATA] = importlib.metadata = empty
    try:
        yield
    finally:
        del sys.modules[METADATA], importlib.metadata
        simpy = sys.modules["simpy"]
        del simpy.__version__
        simpy.__dict__["__getattr__"] = _version


def _version(name: str) -> str:
    """Return SimPy's version, as an attribute of the module."""
    if name != "__version__":
        raise AttributeError(f"module 'simpy' has no attribute {name!r}")
    from importlib.metadata import version  # lazy import: slow

    return version("simpy")


with _without_metadata():
    from simpy import Environment
    from simpy.events import NORMAL, URGENT, Event, Interruption, Process

__all__ = ["NORMAL", "URGENT", "Environment", "Event", "Interruption", "Process"]
