"""Base classes of the protocol cores."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from axistwin.drivers.axis import Scale, Status
from axistwin.drivers.errors import DriverError, SilentError, WrongAnswerError
from axistwin.drivers.steps import Procedure, Read, T

GAP_S = 0.1
"""Longest gap in seconds within an answer: one character at 110 baud."""
MOST_BYTES = 4096
"""Largest number of bytes in an answer; more bytes without an end come from another kind of device."""


@dataclass(frozen=True)
class Line:
    """Factory setting of a serial line: baud rate and frame."""

    baud: int
    stop_bits: int = 1


class Core(ABC):
    """Protocol of a controller, as generators that do no input or output."""

    line = Line(9600)
    check = "check the power, the cable and the line format"
    """What to do if there is no answer."""

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        """Longest wait for the next byte of an answer, in seconds."""
        self.axes: dict[str, AxisCore] = {}
        self._received = bytearray()
        self._in_step = False

    def converse(self, procedure: Procedure[T]) -> Procedure[T]:
        """Execute a procedure; first synchronise with the controller again if the last procedure failed."""
        if not self._in_step:
            yield from self.synchronise()
        self._in_step = False
        try:
            result = yield from procedure
        except DriverError as error:
            self._in_step = error.in_step
            raise
        self._in_step = True
        return result

    def close(self) -> None:
        """Discard the received bytes after the port has been closed."""
        self._received.clear()
        self._in_step = False

    @abstractmethod
    def synchronise(self) -> Procedure[None]:
        """Find the controller and prepare it; earlier bytes do not matter."""

    def statuses(self) -> Procedure[dict[str, Status]]:
        """Return the state of each axis, in counts."""
        found = {}
        for name, axis in self.axes.items():
            found[name] = yield from axis.status()
        return found

    # Bytes

    def _until(self, end: bytes, what: str) -> Procedure[bytes]:
        """Receive up to `end`; return the bytes before `end`."""
        while end not in self._received:
            yield from self._more(what)
        found, _, rest = bytes(self._received).partition(end)
        self._received[:] = rest
        return found

    def _take(self, count: int, what: str) -> Procedure[bytes]:
        """Receive `count` bytes."""
        while len(self._received) < count:
            yield from self._more(what)
        found = bytes(self._received[:count])
        del self._received[:count]
        return found

    def _more(self, what: str) -> Procedure[None]:
        data: bytes = yield Read(self.timeout)
        if not data:
            part = f", only {shown(self._received)}" if self._received else ""
            raise SilentError(f"no answer to {what} within {self.timeout:g} s{part}: {self.check}")
        self._received += data
        if len(self._received) > MOST_BYTES:
            raise WrongAnswerError(f"no end in the answer to {what}: {shown(self._received)}: is it the right port?")

    def _discard(self, first: float) -> Procedure[bytes]:
        """Wait up to `first` seconds for bytes, receive until a gap of 0.1 s, and return all received bytes."""
        found = bytes(self._received)
        self._received.clear()
        wait = first
        while len(found) <= MOST_BYTES and (data := (yield Read(wait))):
            found += data
            wait = min(GAP_S, first)
        return found


class AxisCore(ABC):
    """An axis of a protocol core; positions and velocities are in counts."""

    def __init__(self, name: str, velocity: float, acceleration: float, *, exact: bool = True) -> None:
        self.name, self.velocity, self.acceleration = name, velocity, acceleration
        self.max_velocity = velocity
        self.max_position = 2**31 - 1
        """Largest distance of a position from 0, in counts."""
        self.scale = Scale()
        self.setpoint = 0
        self.exact = exact
        """True if the position read in motion is exact."""

    @abstractmethod
    def move_to(self, target: int) -> Procedure[None]:
        """Begin a move to a position."""

    @abstractmethod
    def move_by(self, distance: int) -> Procedure[None]:
        """Begin a move relative to the last target."""

    @abstractmethod
    def move_at(self, velocity: float) -> Procedure[None]:
        """Run at a signed velocity."""

    @abstractmethod
    def stop(self) -> Procedure[None]:
        """Decelerate to a standstill."""

    @abstractmethod
    def abort(self) -> Procedure[None]:
        """Stop as fast as the controller can."""

    @abstractmethod
    def home(self, direction: int) -> Procedure[None]:
        """Begin a search for the home position."""

    @abstractmethod
    def status(self) -> Procedure[Status]:
        """Return the state of the axis."""

    @abstractmethod
    def set_position(self, position: int) -> Procedure[None]:
        """Define the present position."""

    @abstractmethod
    def clear_faults(self) -> Procedure[None]:
        """Clear the faults whose cause has gone."""


def shown(data: bytes | bytearray) -> str:
    """Return received bytes as short text for an error message."""
    text = repr(bytes(data[:40]))[1:]
    return f"{text}…" if len(data) > 40 else text


class ScaledAxis:
    """An axis of a protocol core for users, in the unit of the axis."""

    def __init__(self, core: AxisCore) -> None:
        self.core, self.name = core, core.name

    @property
    def scale(self) -> Scale:
        """Unit of the axis, as a number of counts."""
        return self.core.scale

    @scale.setter
    def scale(self, scale: Scale) -> None:
        self.core.scale = scale
