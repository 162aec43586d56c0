"""The stations of a scene, whose virtual controllers run inside, or of one port."""

import asyncio
from collections.abc import Mapping, Sequence
from contextlib import AsyncExitStack
from functools import partial
from typing import Any, Self

from axistwin.bench import Bench, endpoints, product
from axistwin.controllers.product import Product
from axistwin.core.errors import LinkError, UsageError, reason
from axistwin.drivers.asynchronous import AsyncController, Port, TcpPort
from axistwin.drivers.blocking import nothing
from axistwin.drivers.core import Core
from axistwin.drivers.errors import DriverError, PortError
from axistwin.drivers.models import make
from axistwin.links.server import Server
from axistwin.plant.axes import Axis
from axistwin.plant.machine_units import MachineUnits
from axistwin.real.hosts.inner_port import InnerPort
from axistwin.real.integrations.paced_port import PacedPort
from axistwin.real.integrations.station import Station

Units = Mapping[str, MachineUnits]  # Units by axis: `X`, or in a scene `if1.X`.


class Machine:
    """A group of controllers with their drivers.  Use within a running event loop: `async with machine`."""

    def __init__(self, stations: Sequence[Station], period_s: float = 0.1, server: Server | None = None) -> None:
        self.stations = list(stations)
        self._period_s, self._server = period_s, server
        self._open = AsyncExitStack()

    async def __aenter__(self) -> Self:
        try:
            for station in self.stations:
                self._open.push_async_callback(station.close)
            await asyncio.gather(*(_connect(station) for station in self.stations))
        except BaseException:
            await self._open.aclose()
            raise
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._open.aclose()
        if self._server is not None:
            self._server.pacer.sync()
            self._server.close()
            for controller in self._server.bench.controllers.values():
                controller.power(False)  # the last attempt to write the data kept without power

    @property
    def memory_lost(self) -> bool:
        """True if data that virtual controllers keep without power could not be written."""
        return self._server is not None and any(one.store.lost for one in self._server.bench.controllers.values())

    async def run(self) -> None:
        async with asyncio.TaskGroup() as group:
            for station in self.stations:
                group.create_task(station.poll_forever(self._period_s))


def tell_failure(task: asyncio.Task[Any]) -> None:
    """Pass the error of a task that has ended to the exception handler of the event loop, without waiting for others.

    A callback of the tasks that poll and serve: without the polls, clients would see an axis that never changes.
    """
    if not task.cancelled() and (error := task.exception()) is not None:
        task.get_loop().call_exception_handler({"message": "a part of the server has ended", "exception": error})


async def _connect(station: Station) -> None:
    try:
        await station.driver.run(nothing())
        await station.poll()
    except DriverError as error:
        name, reason = station.name, error
        raise LinkError(f"no connection to the controller {name}: {reason}") from None


def at_port(
    url: str, model: str, options: Mapping[str, Any], *, baud: int | None = None, units: Units | None = None,
    registers: Sequence[str] = (), period_s: float = 0.1,
) -> Machine:  # fmt: skip
    """Return a `Machine` of the controller at `url`.  Raises UsageError for an invalid choice or name."""
    driver = AsyncController(url, core_of(model, options), baud)
    units = units or {}
    for axis in units:
        if axis not in driver.axes:
            raise UsageError(f"no axis {axis!r}: expected one of {', '.join(driver.axes)}")
    return Machine([Station(model, model, driver, units, tuple(registers))], period_s)


async def of_scene(
    bench: Bench, options: Mapping[str, Mapping[str, Any]], *, speed: float | None = 1.0,
    without: frozenset[str] = frozenset(), units: Units | None = None, registers: Sequence[str] = (),
    period_s: float = 0.1,
) -> Machine:  # fmt: skip
    """Start the controllers of a scene, and return a machine with these controllers.

    `options`: options of drivers by controller; `without`: endpoints that have other hosts.  Raises UsageError.
    """
    names = [name for name in endpoints.names(bench) if name not in without and not name.endswith(".rs485")]
    for name in options:
        if name not in names:
            raise UsageError(f"no controller {name!r}: expected one of {', '.join(names)}")
    server = Server(bench, speed=speed)
    stations = []
    try:
        for name in names:
            made, given, own = of_bench(bench, name)
            core = core_of(made, {**given, **options.get(name, {})})
            driver = AsyncController(f"inside:{name}", core, opening=partial(_open_inside, server, name))
            station = Station(name, made.model, driver, own | _after(name, units or {}), _registers(name, registers))
            for axis, shaft in _shafts(bench, name).items():
                station.axes[axis].shaft = shaft
            stations.append(station)
        _check_names(stations, [*(units or {}), *registers])
    except BaseException:
        server.close()
        raise
    server.start()
    return Machine(stations, period_s, server)


async def _open_inside(server: Server, name: str) -> Port:
    try:
        port = TcpPort(f"inside:{name}", *await asyncio.open_connection(sock=await server.connect(name)))
    except OSError as error:
        raise PortError(
            f"cannot connect to {name} ({reason(error)}): raise the limit of open files, e.g. ulimit -n 4096"
        ) from None
    speed = server.pacer.speed
    if speed is None or speed > 1:
        return port  # its time-outs are in real time, because the way through the socket is
    return PacedPort(port, server.pacer)


def driver_inside(bench: Bench, name: str, **options: Any) -> AsyncController:
    """Return an `AsyncController` of the controller `name` in this process, without a port.

    `options`: those of the driver.  Raises UsageError for an unknown name or an invalid option.
    """
    names = [one for one in endpoints.names(bench) if not one.endswith(".rs485")]
    if name not in names:
        raise UsageError(f"no controller {name!r}: expected one of {', '.join(names)}")
    made, given, _ = of_bench(bench, name)

    async def open_port() -> InnerPort:
        return InnerPort(bench, name)

    return AsyncController(f"inside:{name}", core_of(made, {**given, **options}), opening=open_port)


def core_of(model: str | Product, options: Mapping[str, Any]) -> Core:
    """Return a controller's protocol, without a port.  Raises UsageError for an unknown model or option."""
    made = product(model)
    try:
        return make(made.driver or made.model, dict(options))
    except DriverError as reason:
        raise UsageError(f"cannot create a driver for {made.model}: {reason}") from None


def of_bench(bench: Bench, name: str) -> tuple[Product, dict[str, Any], dict[str, MachineUnits]]:
    """Return model, driver options, and units of the axes that have one, of an emulated controller."""
    made, shafts = product("smartmotor"), _shafts(bench, name)
    given: dict[str, Any] = {}
    if name in bench.lines:
        given = {"addresses": tuple(range(1, len(shafts) + 1)), "rs485": bench.lines[name].channel == "rs485"}
    else:
        made = bench[name].product
        framing: Any = getattr(made.driver, "framing", None)
        if getattr(framing, "terminator", b"") and framing.address:
            usual = {option: found.usual for option, found in made.driver.options.items()}
            given["address"] = framing.address.format(**{**usual, **bench[name].given})
    if made.model == "smartmotor" and any(axis.limits for axis in shafts.values()):
        given["limits"] = True
    return made, given, {axis: found.units for axis, found in shafts.items() if found.units}


def _shafts(bench: Bench, name: str) -> dict[str, Axis]:
    if name in bench.lines:
        return {f"shaft{number}": motor.axes["shaft"] for number, motor in enumerate(bench.lines[name].motors, 1)}
    return dict(bench[name].axes)


def _after(name: str, units: Units) -> dict[str, MachineUnits]:
    return {axis.removeprefix(f"{name}."): found for axis, found in units.items() if axis.startswith(f"{name}.")}


def _registers(name: str, given: Sequence[str]) -> tuple[str, ...]:
    return tuple(one.removeprefix(f"{name}.") for one in given if one.startswith(f"{name}."))


def _check_names(stations: list[Station], given: Sequence[str]) -> None:
    known = {f"{station.name}.{axis}" for station in stations for axis in station.axes}
    for name in given:
        if name not in known and name.partition(".")[0] not in {station.name for station in stations}:
            raise UsageError(f"unknown axis or register {name!r}: expected e.g. {min(known)}")
