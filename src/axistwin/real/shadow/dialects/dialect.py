"""What a family's commands and answers mean: the part of the shadow that differs between controllers."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

from axistwin.real.shadow.talk import Command
from axistwin.real.shadow.twin import Twin


class Reading(NamedTuple):
    """What an answer says.  `fixed` must be equal; `busy` and `position` depend on the time at which they were read."""

    fixed: object = None
    busy: bool | None = None
    position: int | None = None
    grain: float = 0.0  # Deviation of a position that is always permitted.
    moving_grain: float = 0.0  # The same during motion.
    ahead: bool = False  # True for a position that is counted in the direction of the motion.
    encoder: bool = False  # True for a position that is not counted in the steps of the motor.
    soft: bool = False  # True if `fixed` may change by itself while something moves.


class Taken(NamedTuple):
    """What the twin has taken over from the machine; `fault` if it is a fault of the machine."""

    text: str
    subject: str
    fault: bool = False
    stops: bool = False  # True if it explains that the motion ended early.


class Dialect(ABC):
    """The language of one family, for one twin."""

    message_size = 0  # Size of each message; 0: messages end in a terminator.
    terminators = b"\r\n"
    stop = b""  # Command that ends a motion at once, without an answer.
    causes: tuple[str, ...] = ()  # Requests that tell the cause of an unexplained answer.
    unread: tuple[str, ...] = ()  # Subjects of faults that stay until the host reads them.
    needs_joining = False  # True if a twin must be told how to answer before the first request.

    def __init__(self, twin: Twin) -> None:
        self.twin = twin
        self.machine_positions = False  # True while a person or another machine moves the axes.

    def halt(self) -> None:
        """End the twin's motion."""
        self.twin.write(self.stop)

    def show(self, data: bytes) -> str:
        """Return an answer for users."""
        return repr(data[:40])[2:-1]

    @abstractmethod
    def commands(self, data: bytes) -> Iterator[Command]:
        """Cut the host's data into commands."""

    @abstractmethod
    def read(self, command: Command | None, data: bytes) -> Reading: ...

    def take(self, command: Command, machine: bytes, twin: bytes) -> list[Taken]:  # noqa: ARG002
        """Take over what only the machine knows; return it in words.  An empty list: nothing explains the answer."""
        return []

    def unexplained(self, command: Command, machine: bytes) -> bool:  # noqa: ARG002
        """Return True for an answer whose cause another request will tell."""
        return False

    def tells(self, host: bytes, machine: bytes) -> bool:  # noqa: ARG002
        """Return True if this exchange tells how the machine answers."""
        return True

    def join(self, host: bytes, machine: bytes) -> bool:  # noqa: ARG002
        """Bring the twin into the machine's state of communication.  Return True if it has just been switched on."""
        return False

    @property
    def echo(self) -> bool:
        """True while the controller echoes."""
        return False

    def restarted(self, host: bytes, machine: bytes) -> bool:  # noqa: ARG002
        """Return True if this exchange shows that the machine has been switched off and on."""
        return False

    def clear(self) -> None:  # noqa: B027  # a command of a board is always whole
        """Forget a half command."""

    def axis_of(self, command: Command) -> str:  # noqa: ARG002
        """Return the axis whose position an answer tells."""
        return self.twin.busiest()[0]

    def set_position(self, command: Command, position: int) -> bool:  # noqa: ARG002
        """Let the twin stand where the machine stands.  Return False if the family has no way to do so."""
        return False


def number(data: bytes) -> int | None:
    """Return the decimal number in an answer; None if it is no number."""
    text = bytes(byte & 0x7F for byte in data).strip()
    return int(text) if text.removeprefix(b"-").isdigit() and len(text) < 20 else None


def dialect_for(twin: Twin) -> Dialect:
    family = twin.controller.product.family
    if family == "digiplan":
        from axistwin.real.shadow.dialects.digiplan import Digiplan

        return Digiplan(twin)
    if family == "compumotor":
        from axistwin.real.shadow.dialects.compumotor import Compumotor

        return Compumotor(twin)
    if family == "smartmotor":
        from axistwin.real.shadow.dialects.smartmotor import SmartMotor

        return SmartMotor(twin)
    from axistwin.real.shadow.dialects.devices import Table

    return Table(twin)
