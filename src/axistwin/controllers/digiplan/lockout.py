"""Chapters Communication lockout commands and Using the battery backup (IF2 only)."""

import json
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

from axistwin.controllers.digiplan.serial_data import Frame
from axistwin.controllers.digiplan.step import Parameters
from axistwin.controllers.product import Store
from axistwin.errors import UsageError

if TYPE_CHECKING:
    from axistwin.controllers.digiplan.interface import Interface


@dataclass(frozen=True)
class Retained:
    """What the battery keeps while the interface is locked; unlocked, nothing is kept."""

    locked: bool = False
    baudrate: int = 9600
    frame: Frame = field(default_factory=Frame)
    parameters: Parameters = field(default_factory=Parameters)
    sequence: str = ""

    def save(self, store: Store) -> None:
        """Keep it, readable for people."""
        store.save(json.dumps(asdict(self), indent=1).encode())

    @classmethod
    def recall(cls, store: Store) -> "Retained":
        """What was kept, or the defaults."""
        contents = store.load()
        if contents is None:
            return cls()
        try:
            kept = json.loads(contents)
            frame, parameters = Frame(**kept.pop("frame")), Parameters(**kept.pop("parameters"))
            return cls(frame=frame, parameters=parameters, **kept)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise UsageError(f"the battery-backed memory cannot be read ({error}): delete its file") from None


def lock(interface: "Interface") -> None:
    """Command [: from now on only status requests and `]` are obeyed; communication is not checked.

    In an IF2 parameters, sequence, baud rate and data format now survive power-off.
    Chapters Communication lockout commands, Storing a sequence in the IF2.
    """
    interface.set_locked(True)


def unlock(interface: "Interface") -> None:
    """Command ]: all commands are obeyed again.  Chapter Communication lockout commands."""
    interface.set_locked(False)
