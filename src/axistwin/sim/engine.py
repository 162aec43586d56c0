"""The parts of SimPy that the clock uses, imported without the rest of SimPy.

SimPy's `__init__` imports `importlib.metadata`, only to read SimPy's own version, and all kinds of resources.  These
imports take more than half the time that a bare asyncio server needs to start.  Here `__init__` is executed when an
attribute of `simpy` is first used.
"""

import sys
from importlib.util import find_spec, module_from_spec
from typing import Any

NAME = "simpy"


def _postpone_init() -> None:
    """Delay the import of SimPy until the program first uses SimPy.  No effect if SimPy has been imported before."""
    if NAME in sys.modules:
        return
    spec = find_spec(NAME)
    assert spec is not None
    assert spec.loader is not None
    execute, package = spec.loader.exec_module, module_from_spec(spec)

    def attribute(name: str) -> Any:
        package.__dict__.pop("__getattr__", None)
        execute(package)
        return getattr(package, name)

    package.__dict__["__getattr__"] = attribute
    sys.modules[NAME] = package


_postpone_init()

from simpy.core import Environment  # noqa: E402
from simpy.events import NORMAL, URGENT, Event, Interruption, Process  # noqa: E402
from simpy.exceptions import Interrupt  # noqa: E402

__all__ = ["NORMAL", "URGENT", "Environment", "Event", "Interrupt", "Interruption", "Process"]
