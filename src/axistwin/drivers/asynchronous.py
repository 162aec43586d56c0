"""Drivers for asyncio: TCP ports are read by asyncio, all other ports by pyserial in a separate thread."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any, Protocol, Self

from axistwin.core.errors import cannot_open
from axistwin.drivers.arguments import number, positive
from axistwin.drivers.axis import Status
from axistwin.drivers.blocking import POLL_S, SerialPort, arrived, nothing, still_moving
from axistwin.drivers.core import AxisCore, Core, ScaledAxis
from axistwin.drivers.errors import PortError
from axistwin.drivers.models import make
from axistwin.drivers.steps import Clock, Pause, Procedure, Read, T, Write


async def connect_async(url: str, model: Any, *, baud: int | None = None, **options: Any) -> "AsyncController":
    """Open a port and return the controller at this port.  The arguments are those of `connect`."""
    controller = AsyncController(url, make(model, options), baud)
    try:
        await controller.run(nothing())
    except BaseException:
        await controller.close()
        raise
    return controller


class Port(Protocol):
    """Interface of a port for programs that use asyncio."""

    async def write(self, data: bytes) -> None: ...

    async def read(self, timeout: float) -> bytes:
        """Wait for bytes and return them; return b"" if no byte arrives within `timeout` seconds."""

    async def pause(self, seconds: float) -> None: ...

    def time(self) -> float:
        """Return the present time of the clock in seconds."""

    async def close(self) -> None: ...


class WallClock:
    """A clock in real time.  The ports to real controllers are subclasses of this class."""

    async def pause(self, seconds: float) -> None:
        await asyncio.sleep(seconds)

    def time(self) -> float:
        """Return the present time of the clock in seconds."""
        return time.monotonic()


class TcpPort(WallClock):
    """A TCP connection to a controller."""

    def __init__(self, url: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._url, self._reader, self._writer = url, reader, writer

    async def write(self, data: bytes) -> None:
        try:
            self._writer.write(data)
            await self._writer.drain()
        except OSError as error:
            raise self._lost(why=error) from None

    async def read(self, timeout: float) -> bytes:
        """Wait for bytes and return them; return b"" if no byte arrives within `timeout` seconds."""
        try:
            async with asyncio.timeout(timeout):
                data = await self._reader.read(4096)
        except TimeoutError:
            return b""
        except OSError as error:
            raise self._lost(why=error) from None
        if not data:
            raise PortError(
                f"the server at {self._url} has closed the connection: "
                "check that the server is still running, then try again"
            )
        return data

    def _lost(self, why: OSError) -> PortError:
        return PortError(f"{self._url} was disconnected ({why}): the driver opens the port again for the next command")

    async def close(self) -> None:
        self._writer.close()
        with suppress(OSError):  # Closing a broken connection raises OSError.
            await self._writer.wait_closed()


class ThreadPort(WallClock):
    """A pyserial port whose blocking calls run in a separate thread."""

    def __init__(self, port: SerialPort, thread: ThreadPoolExecutor) -> None:
        self._port, self._thread = port, thread

    async def write(self, data: bytes) -> None:
        await self._call(self._port.write, data)

    async def read(self, timeout: float) -> bytes:
        """Wait for bytes and return them; return b"" if no byte arrives within `timeout` seconds."""
        received: bytes = await self._call(self._port.read, timeout)
        return received

    async def close(self) -> None:
        await self._call(self._port.close)
        self._thread.shutdown(wait=False)

    async def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._thread, function, *arguments)


async def open_port(url: str, core: Core, baud: int | None) -> Port:
    """Open the port at a URL.  Raises PortError if the port cannot be opened."""
    scheme, _, rest = url.partition("://")
    if scheme in ("tcp", "socket", "bus"):
        host, _, number = rest.rpartition(":")
        try:
            return TcpPort(url, *await asyncio.open_connection(host.strip("[]"), int(number)))
        except (OSError, ValueError) as error:
            raise PortError(cannot_open(url, error)) from None
    thread = ThreadPoolExecutor(1, "axistwin-port")
    return ThreadPort(await asyncio.get_running_loop().run_in_executor(thread, SerialPort, url, core, baud), thread)


class AsyncController:
    """A controller at a port, for asyncio; public functions of the core are coroutines of this object.

    `opening`: returns another kind of port, opened; None: the port at the URL is opened.
    """

    def __init__(
        self, url: str, core: Core, baud: int | None = None, opening: Callable[[], Awaitable[Port]] | None = None
    ) -> None:
        self.url, self.core, self._baud, self._opening = url, core, baud, opening
        self.axes = {name: AsyncAxis(self, axis) for name, axis in core.axes.items()}
        self._lock = asyncio.Lock()
        self._port: Port | None = None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    def __getattr__(self, name: str) -> Callable[..., Coroutine[Any, Any, Any]]:
        function = getattr(self.core, name)
        return lambda *arguments, **keywords: self.run(function(*arguments, **keywords))

    async def close(self) -> None:
        """Close the port.  A motion in progress continues."""
        async with self._lock:
            await self._close()

    async def _close(self) -> None:
        port, self._port = self._port, None
        self.core.close()
        if port is not None:
            await port.close()

    async def run(self, procedure: Procedure[T]) -> T:
        """Execute a function of the protocol core at the port.  Raises DriverError if the function fails."""
        async with self._lock:
            if self._port is None:
                self._port = await (self._opening() if self._opening else open_port(self.url, self.core, self._baud))
            try:
                return await _drive(self.core.converse(procedure), self._port)
            except PortError:
                await self._close()
                raise

    @property
    def clock(self) -> WallClock | Port:
        """Clock of the controller's port, in real time or in virtual time."""
        return self._port or WallClock()


async def _drive(steps: Procedure[T], port: Port) -> T:
    result: Any = None
    try:
        while True:
            match steps.send(result):
                case Write(data):
                    await port.write(data)
                case Read(timeout):
                    result = await port.read(timeout)
                case Pause(seconds):
                    await port.pause(seconds)
                case Clock():
                    result = port.time()
    except StopIteration as end:
        value: T = end.value
        return value
    finally:
        steps.close()


class AsyncAxis(ScaledAxis):
    """An axis for programs with asyncio; its functions are coroutines."""

    def __init__(self, controller: AsyncController, core: AxisCore) -> None:
        super().__init__(core)
        self.controller = controller

    async def move_to(self, position: float) -> None:
        """Begin a move to a position."""
        await self.controller.run(self.core.move_to(self._counts("position", position)))

    async def move_by(self, distance: float) -> None:
        """Begin a relative move: the new target is the last target plus `distance`."""
        await self.controller.run(self.core.move_by(self._counts("distance", distance)))

    async def move_at(self, velocity: float) -> None:
        """Run the axis at a signed velocity until `stop` is called."""
        await self.controller.run(self.core.move_at(self._velocity(velocity)))

    async def stop(self) -> None:
        """Decelerate the axis to a standstill."""
        await self.controller.run(self.core.stop())

    async def abort(self) -> None:
        """Stop the axis as fast as the controller can."""
        await self.controller.run(self.core.abort())

    async def home(self, direction: int) -> None:
        """Begin a search for the home position in direction 1 (positive) or -1 (negative)."""
        await self.controller.run(self.core.home(self._direction(direction)))

    async def status(self) -> Status:
        """Return the state of the axis; positions are in the unit of the axis."""
        return self.scale.status(await self.controller.run(self.core.status()))

    async def position(self) -> float:
        """Return the position of the axis.  Raises PositionLostError if the position is not known."""
        return (await self.status()).known_position()

    async def set_position(self, position: float) -> None:
        """Set the present position to a new value without a move; the axis must be at rest."""
        await self.controller.run(self.core.set_position(self._counts("position", position)))

    async def clear_faults(self) -> None:
        """Clear the faults whose cause no longer exists."""
        await self.controller.run(self.core.clear_faults())

    async def wait(self, timeout: float, poll: float = POLL_S) -> Status:
        """Wait until the axis has arrived, and return its status.

        A move arrives at its target, a search for home at home; a run, `stop` and `abort` end at rest.  Raises
        SilentError if the axis is still moving after `timeout` seconds, and StoppedError if it stops elsewhere.
        """
        end, poll = self.controller.clock.time() + number("timeout", timeout, finite=False), positive("poll", poll)
        while (status := await self.status()).moving:
            if self.controller.clock.time() > end:
                raise still_moving(name=self.name, timeout=timeout)
            await self.controller.clock.pause(poll)
        return arrived(self.name, status)
