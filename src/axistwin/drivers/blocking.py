"""Drivers for synchronous programs, on the ports that pyserial can open."""

import threading
import time
from collections.abc import Callable, Generator
from typing import TYPE_CHECKING, Any, Self

from axistwin.core.errors import cannot_open
from axistwin.drivers.arguments import number, positive
from axistwin.drivers.axis import Status
from axistwin.drivers.core import AxisCore, Core, ScaledAxis
from axistwin.drivers.errors import PortError, SilentError, StoppedError
from axistwin.drivers.models import make
from axistwin.drivers.steps import Clock, Pause, Procedure, Read, T, Write

if TYPE_CHECKING:
    import serial

POLL_S = 0.02


def connect(url: str, model: Any, *, baud: int | None = None, **options: Any) -> "Controller":
    """Open a port and return the controller at this port.

    `url`: a URL of pyserial (`socket://`, `rfc2217://`), `COM3`, a device, or the `tcp://` and `bus://` that
    `axistwin serve` prints.  `model`: a name, the class of a device, or a `TextDriver`.  `baud`: None means the model's
    factory setting.  `options`: options of the model, e.g. `timeout`.  Raises DriverError.
    """
    controller = Controller(url, make(model, options), baud)
    try:
        controller.run(nothing())
    except BaseException:
        controller.close()
        raise
    return controller


def open_serial(url: str, **settings: Any) -> "serial.Serial":
    """Open a device, a URL of pyserial, or the `tcp://` or `bus://` of `axistwin serve`.  Raises PortError."""
    import serial  # lazy import: asyncio programs with TCP connections do not need pyserial

    scheme, separator, rest = url.partition("://")
    try:
        return serial.serial_for_url(f"socket://{rest}" if separator and scheme in ("tcp", "bus") else url, **settings)
    except (OSError, ValueError) as error:
        raise PortError(cannot_open(url, error)) from None


class SerialPort:
    """A port that pyserial can open."""

    def __init__(self, url: str, core: Core, baud: int | None) -> None:
        self._port = open_serial(url, baudrate=baud or core.line.baud, stopbits=core.line.stop_bits, timeout=0)
        self._url = url

    def write(self, data: bytes) -> None:
        self._guard(lambda: self._port.write(data))

    def read(self, timeout: float) -> bytes:
        """Wait for bytes and return them; return b"" if no byte arrives within `timeout` seconds."""
        return self._guard(lambda: self._read(timeout))

    def _read(self, timeout: float) -> bytes:
        # Do not set an unchanged timeout: setting a timeout takes 0.2 s at a serial port in the network (RFC 2217).
        if timeout != self._port.timeout:
            self._port.timeout = timeout
        first: bytes = self._port.read(1)
        if not first:
            return b""
        waiting = self._port.in_waiting
        return first + (bytes(self._port.read(waiting)) if waiting else b"")

    def _guard(self, act: Callable[[], T]) -> T:
        try:
            return act()
        except (OSError, ValueError, TypeError) as error:  # The library pyserial raises TypeError for a closed port.
            raise PortError(
                f"{self._url} was disconnected ({error}): the driver opens the port again for the next command"
            ) from None

    def close(self) -> None:
        self._port.close()


class Controller:
    """A controller at a port.  Public functions of the protocol core, e.g. `outputs`, are functions of this object."""

    def __init__(self, url: str, core: Core, baud: int | None = None) -> None:
        self.url, self.core, self._baud = url, core, baud
        self.axes = {name: BlockingAxis(self, axis) for name, axis in core.axes.items()}
        self._lock = threading.Lock()
        self._port: SerialPort | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __getattr__(self, name: str) -> Callable[..., Any]:
        function = getattr(self.core, name)
        return lambda *arguments, **keywords: self.run(function(*arguments, **keywords))

    def close(self) -> None:
        """Close the port.  A motion in progress continues."""
        with self._lock:
            self._close()

    def _close(self) -> None:
        if self._port is not None:
            self._port.close()
        self._port = None
        self.core.close()

    def run(self, procedure: Procedure[T]) -> T:
        """Execute a function of the protocol core at the port.  Raises DriverError if the function fails."""
        with self._lock:
            if self._port is None:
                self._port = SerialPort(self.url, self.core, self._baud)
            try:
                return _drive(self.core.converse(procedure), self._port)
            except PortError:
                self._close()
                raise


def _drive(steps: Procedure[T], port: SerialPort) -> T:
    result: Any = None
    try:
        while True:
            match steps.send(result):
                case Write(data):
                    port.write(data)
                case Read(timeout):
                    result = port.read(timeout)
                case Pause(seconds):
                    time.sleep(seconds)
                case Clock():
                    result = time.monotonic()
    except StopIteration as end:
        value: T = end.value
        return value
    finally:
        steps.close()


class BlockingAxis(ScaledAxis):
    """An axis whose functions block until the controller has answered."""

    def __init__(self, controller: Controller, core: AxisCore) -> None:
        super().__init__(core)
        self._controller = controller

    def move_to(self, position: float) -> None:
        """Begin a move to a position."""
        self._controller.run(self.core.move_to(self._counts("position", position)))

    def move_by(self, distance: float) -> None:
        """Begin a relative move: the new target is the last target plus `distance`."""
        self._controller.run(self.core.move_by(self._counts("distance", distance)))

    def move_at(self, velocity: float) -> None:
        """Run the axis at a signed velocity until `stop` is called."""
        self._controller.run(self.core.move_at(self._velocity(velocity)))

    def stop(self) -> None:
        """Decelerate the axis to a standstill."""
        self._controller.run(self.core.stop())

    def abort(self) -> None:
        """Stop the axis as fast as the controller can."""
        self._controller.run(self.core.abort())

    def home(self, direction: int) -> None:
        """Begin a search for the home position in direction 1 (positive) or -1 (negative)."""
        self._controller.run(self.core.home(self._direction(direction)))

    def status(self) -> Status:
        """Return the state of the axis; positions are in the unit of the axis."""
        return self.scale.status(self._controller.run(self.core.status()))

    def position(self) -> float:
        """Return the position of the axis.  Raises PositionLostError if the position is not known."""
        return self.status().known_position()

    def set_position(self, position: float) -> None:
        """Set the present position to a new value without a move; the axis must be at rest."""
        self._controller.run(self.core.set_position(self._counts("position", position)))

    def clear_faults(self) -> None:
        """Clear the faults whose cause no longer exists."""
        self._controller.run(self.core.clear_faults())

    def wait(self, timeout: float, poll: float = POLL_S) -> Status:
        """Wait until the axis has arrived, and return its status.

        A move arrives at its target, a search for home at home; a run, `stop` and `abort` end at rest.  Raises
        SilentError if the axis is still moving after `timeout` seconds, and StoppedError if it stops elsewhere.
        """
        end, poll = time.monotonic() + number("timeout", timeout, finite=False), positive("poll", poll)
        while (status := self.status()).moving:
            if time.monotonic() > end:
                raise still_moving(name=self.name, timeout=timeout)
            time.sleep(poll)
        return arrived(self.name, status)


def arrived(name: str, status: Status) -> Status:
    """Return the status of an axis at rest.  Raises StoppedError if the axis has not arrived."""
    if status.missed:
        raise StoppedError(name, status)
    return status


def still_moving(name: str, timeout: float) -> SilentError:
    return SilentError(f"axis {name} is still moving after {timeout:g} s: stop it, or wait longer")


def nothing() -> Generator[Any, Any, None]:
    """Do nothing; used to synchronise with the controller only."""
    yield from ()
