"""Base classes of the protocol cores."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

from axistwin.drivers.arguments import number, positive
from axistwin.drivers.axis import Fault, Scale, Status
from axistwin.drivers.errors import DriverError, RefusedError, SilentError, WrongAnswerError
from axistwin.drivers.steps import Procedure, Read, T

GAP_S = 0.1
"""Longest gap in seconds within an answer: one character at 110 baud."""
MAX_ACCELERATION = 2.0**31
MOST_BYTES = 4096
"""Largest number of bytes in an answer; more bytes without an end come from another kind of device."""


BOTH_LIMITS = "both limits are active: check the limit switches and their wiring, then call clear_faults"


@dataclass(frozen=True)
class Line:
    """Factory settings of a controller's serial line: the baud rate and the number of stop bits."""

    baud: int
    stop_bits: int = 1


class Core(ABC):
    """Protocol of a controller, as generators that do no input or output."""

    line = Line(9600)
    remedy = "check the power, the cable and the line format"
    """What to do if there is no answer."""

    def __init__(self, timeout: float) -> None:
        self.timeout = positive("timeout", timeout)
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
        """Discard all received bytes, because the port has been closed."""
        self._received.clear()
        self._in_step = False

    @abstractmethod
    def synchronise(self) -> Procedure[None]:
        """Check that the controller answers, and prepare the controller for commands."""

    def statuses(self) -> Procedure[dict[str, Status]]:
        """Return the state of each axis; positions are in counts."""
        found = {}
        for name, axis in self.axes.items():
            found[name] = yield from axis.status()
        return found

    # Bytes

    def _until(self, end: bytes, request: str) -> Procedure[bytes]:
        while end not in self._received:
            yield from self._more(request)
        found, _, rest = bytes(self._received).partition(end)
        self._received[:] = rest
        return found

    def _take(self, count: int, request: str) -> Procedure[bytes]:
        while len(self._received) < count:
            yield from self._more(request)
        found = bytes(self._received[:count])
        del self._received[:count]
        return found

    def _more(self, request: str) -> Procedure[None]:
        data: bytes = yield Read(self.timeout)
        if not data:
            if self._received:
                raise SilentError(f"incomplete answer {shown(self._received)} to {request}: {self.remedy}")
            raise SilentError(f"no answer to {request} within {self.timeout:g} s: {self.remedy}")
        self._received += data
        if len(self._received) > MOST_BYTES:
            raise WrongAnswerError(
                f"the answer to {request} is too long (it begins with {shown(self._received)}): "
                "check that the controller is connected to this port"
            )

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
    """An axis of a controller, with positions and velocities in counts."""

    def __init__(self, name: str, velocity: float, acceleration: float, *, exact: bool = True) -> None:
        self.name, self.velocity, self.acceleration = name, velocity, acceleration
        self.max_velocity = velocity
        self.max_position = 2**31 - 1
        """Largest distance of a position from 0, in counts."""
        self.scale = Scale()
        self.setpoint = 0
        self.target: int | None = None
        """End of the last move; None after a run, a search for home, a stop or a new definition of the position."""
        self._seeking = False
        """True from the beginning of a search for home until home is found."""
        self._old_faults: tuple[Fault, ...] = ()
        self.exact = exact
        """True if the position read in motion is exact."""

    def _aim(self, target: int | None, *, seeking: bool = False, faults: tuple[Fault, ...] = ()) -> None:
        """Note what a motion is to reach; `faults`: the faults before it."""
        self.target, self._seeking, self._old_faults = target, seeking, faults

    def _judged(self, status: Status, *, off: float | None = None) -> Status:
        """Add to the status of an axis at rest the reason why the axis has not arrived.

        `off`: distance from the target in counts; None: that of the position.
        """
        if status.moving or (self.target is None and not self._seeking):
            return status
        if off is None and self.target is not None:
            off = status.position - self.target
        new = [fault for fault in status.faults if fault not in self._old_faults]
        if not off and not new and not status.lost and not self._seeking:
            return status
        aim = (
            "home was not found" if self._seeking else "the target was not reached" if off else "a fault at the target"
        )
        return replace(status, missed=f"{aim} ({_cause(status, new)})")

    @abstractmethod
    def move_to(self, target: int) -> Procedure[None]: ...

    @abstractmethod
    def move_by(self, distance: int) -> Procedure[None]:
        """Begin a relative move: the new target is the last target plus `distance`."""

    @abstractmethod
    def move_at(self, velocity: float) -> Procedure[None]:
        """Run the axis at a signed velocity until `stop` is called."""

    @abstractmethod
    def stop(self) -> Procedure[None]: ...

    @abstractmethod
    def abort(self) -> Procedure[None]:
        """Stop the axis as fast as the controller can."""

    @abstractmethod
    def home(self, direction: int) -> Procedure[None]: ...

    @abstractmethod
    def status(self) -> Procedure[Status]: ...

    @abstractmethod
    def set_position(self, position: int) -> Procedure[None]: ...

    @abstractmethod
    def clear_faults(self) -> Procedure[None]:
        """Clear the faults whose cause no longer exists."""


def _cause(status: Status, new: Sequence[Fault]) -> str:
    if status.lost:
        return f"{status.lost}: home the axis, or call set_position"
    if faults := new or status.faults:
        return "; ".join(map(str, faults))
    if status.limit_plus or status.limit_minus:
        sign = "+" if status.limit_plus else "-"
        return f"the {sign} limit is active: move in the other direction"
    return "another host or program stopped it: begin the motion again"


def shown(data: bytes | bytearray) -> str:
    text = repr(bytes(data[:40]))[1:]
    return f"{text}…" if len(data) > 40 else text


class ScaledAxis:
    """An axis with positions and velocities in the user's unit, e.g. mm."""

    def __init__(self, core: AxisCore) -> None:
        self.core, self.name = core, core.name

    @property
    def scale(self) -> Scale:
        """The user's unit of the axis, e.g. mm, and the number of counts per unit."""
        return self.core.scale

    @scale.setter
    def scale(self, scale: Scale) -> None:
        self.core.scale = scale

    def set_profile(self, velocity: float | None = None, acceleration: float | None = None) -> None:
        """Set the velocity and acceleration of the next moves.  Raises RefusedError for a value that no axis has."""
        given = {"velocity": (velocity, self.core.max_velocity), "acceleration": (acceleration, MAX_ACCELERATION)}
        rates = {what: self._rate(what, value, most) for what, (value, most) in given.items() if value is not None}
        for what, rate in rates.items():
            setattr(self.core, what, rate)

    def _rate(self, what: str, value: float, most: float) -> float:
        rate, k = self.scale.rate(positive(what, value)), self.scale.rate(1)
        if rate > most:
            raise RefusedError(f"invalid {what} {value:g}: expected a number above 0, and at most {most / k:g}")
        return rate

    def _counts(self, what: str, value: float) -> int:
        k, most = self.scale.counts_per_unit, self.core.max_position
        if abs(number(what, value)) > most / abs(k):
            raise RefusedError(f"invalid {what} {value:g}: expected at most {most / abs(k):.12g} in either direction")
        return self.scale.counts(value)

    def _velocity(self, value: float) -> float:
        return number("velocity", value) * self.scale.counts_per_unit

    def _direction(self, value: int) -> int:
        if number("direction", value) not in (1, -1):
            raise RefusedError(f"invalid direction {value!r}: expected 1 or -1")
        return int(value) if self.scale.counts_per_unit > 0 else -int(value)
