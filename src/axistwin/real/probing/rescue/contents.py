"""The contents of a controller as read at its port, and the family's part of a rescue."""

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from axistwin.bench import Bench, product
from axistwin.controllers.registry import OURS
from axistwin.core.errors import UsageError
from axistwin.real.hosts.exchange import Exchange


@dataclass
class Contents:
    """The programs and data of a controller, as the controller reports them through its port."""

    values: dict[str, str] = field(default_factory=dict)  # All answers by the name of the value or the request.
    depends: set[str] = field(default_factory=set)  # Depend on the machine or on earlier motion; a twin may differ.
    program: str = ""  # Source of the program of a SmartMotor.
    missing: list[str] = field(default_factory=list)  # Not reported; each with the place where it is found.

    def differences(self, twin: "Contents") -> dict[str, tuple[str, str]]:
        """Return the values that differ from the twin's, by name, without those of the machine."""
        found = {
            name: (value, twin.values.get(name, ""))
            for name, value in self.values.items()
            if name not in self.depends and value != twin.values.get(name, "")
        }
        if self.program != twin.program:
            found["program"] = (f"{len(self.program)} characters", f"{len(twin.program)} other characters")
        return found


@dataclass
class Restoring:
    """Saved data of a real controller, converted to settings, actions and files for a simulated controller."""

    controller: dict[str, Any] = field(default_factory=dict)  # Keys of the controller's table.
    actions: list[str] = field(default_factory=list)  # Actions at power-up, in the syntax of a script.
    files: dict[str, str] = field(default_factory=dict)  # Texts of the files that the scene names.


@dataclass(frozen=True)
class Reader:
    """The family's part of a rescue."""

    read: Callable[[Exchange], Contents]  # Without motion.  Raises LinkError if silent or moving.
    restore: Callable[[Contents, Contents], Restoring]
    """Returns what gives a new controller the contents; the second argument is the contents of a new controller."""
    start: Callable[[Bench, Contents], None] = lambda bench, contents: None
    """Brings a twin of a new scene into the state in which it answers."""


def reader(model: str) -> Reader:
    made = product(model)
    if made.model not in OURS:
        raise UsageError(f"{made.model} cannot be rescued: expected one of {', '.join(OURS)}")
    found: Reader = import_module(f"{__package__}.{made.family}").READER
    return found
