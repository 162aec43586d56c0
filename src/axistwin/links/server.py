"""A server: the controllers of a bench on real ports."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from axistwin.bench import Bench
from axistwin.links.pacing import Pacer
from axistwin.links.plug import Plug
from axistwin.links.single_client import SingleClient
from axistwin.links.urls import PortUrl
from axistwin.sim.serial_port import Flow

if TYPE_CHECKING:
    from axistwin.links.bus import Slot


class OpenPort(Protocol):
    """An open port."""

    url: PortUrl
    """Actual address, with the number that the system has chosen for port 0."""

    def close(self) -> None:
        """Close the port."""


class Server:
    """Paces a bench and opens ports to its controllers.  Use within a running event loop.

    `speed`: times real time; None: as fast as possible.  `flow`: the host's flow control, on transports without one.
    `reset`: True power-cycles the controller for each new client; a function is called with its name instead.  `pacer`:
    replaces the default pacer.  `on_open` is called with a controller's name before its first port is opened.
    """

    def __init__(
        self,
        bench: Bench,
        *,
        speed: float | None = 1.0,
        flow: Flow = Flow.DTR,
        reset: bool | Callable[[str], object] = False,
        pacer: Pacer | None = None,
        on_open: Callable[[str], object] = lambda name: None,
    ) -> None:
        self.bench, self.pacer = bench, pacer or Pacer(bench.clock, speed)
        self.ports: list[tuple[str, PortUrl]] = []
        """Open ports, each with the name of its controller."""
        self._flow, self._on_open = flow, on_open
        self._reset = reset if callable(reset) else self._power_cycle if reset else lambda name: None
        self._muted = False
        self._plugs: dict[str, Plug] = {}
        self._slots: dict[str, Slot] = {}
        self._open: list[OpenPort] = []

    async def open(self, name: str, url: PortUrl) -> PortUrl:
        """Open a port to the endpoint of this name: a controller, a second channel, or a line of motors.

        Raises LinkError; UsageError for an unknown name.
        """
        port = await (_open_slot(self._slot(name), url) if url.scheme == "bus" else _open(self._plug(name), url))
        self._open.append(port)
        self.ports.append((name, port.url))
        return port.url

    def start(self) -> None:
        """Start virtual time."""
        self.pacer.start()

    def close(self) -> None:
        """Close all ports, disconnect all clients, and stop virtual time."""
        for endpoint in self._endpoints:
            if endpoint.client is not None:
                endpoint.client.drop()
        while self._open:
            self._open.pop().close()
        self.pacer.stop()

    def client(self, name: str) -> str:
        """Return the address of the client at this endpoint, such as `127.0.0.1:4711`; "" without a client."""
        return next((endpoint.client_name for endpoint in self._endpoints if endpoint.name == name), "")

    # Replaying a run on another bench

    @property
    def muted(self) -> bool:
        """True while no data passes between clients and the bench, and new clients are refused.

        A replay repeats what clients have already received.  Setting False updates the clients with all later changes.
        """
        return self._muted

    @muted.setter
    def muted(self, on: bool) -> None:
        if on is self._muted:
            return
        self._muted = on
        for endpoint in self._endpoints:
            endpoint.muted = on
        if not on:
            for endpoint in self._endpoints:
                endpoint.catch_up()
            self.pacer.work()

    def replace_bench(self, bench: Bench) -> None:
        """Serve another bench with the same names; clients stay connected.

        The ports of the new bench are not changed: a replay repeats there the acts of the hosts.  Not allowed while the
        bench is being advanced.  Raises UsageError, without any change, if a name is missing on the new bench.
        """
        ports, buses = {name: bench.port(name) for name in self._plugs}, {name: bench[name].bus for name in self._slots}
        muted, self.muted = self.muted, True
        self.bench = bench
        for name, port in ports.items():
            self._plugs[name].replace_port(port)
        for name, bus in buses.items():
            self._slots[name].replace_bus(bus)
        self.pacer.replace_clock(bench.clock)
        self.muted = muted

    @property
    def _endpoints(self) -> list[SingleClient[Any]]:
        return [*self._plugs.values(), *self._slots.values()]

    def _plug(self, name: str) -> Plug:
        if name not in self._plugs:
            port = self.bench.port(name)
            title = self.bench[name].product.model if name in self.bench.controllers else name
            self._on_open(name)
            self.pacer.sync()
            plug = Plug(name, port, self.pacer, title=title, flow=self._flow, reset=partial(self._reset, name))
            plug.muted = self._muted
            self._plugs[name] = plug
        return self._plugs[name]

    def _power_cycle(self, name: str) -> None:
        """Switch all controllers at this endpoint off and on."""
        line = self.bench.lines.get(name)
        for controller in (self.bench[name.removesuffix(".rs485")],) if line is None else line.motors:
            controller.power_cycle()

    def _slot(self, name: str) -> "Slot":
        from axistwin.links.bus import Slot

        if name not in self._slots:
            self._on_open(name)
            slot = Slot(name, self.bench[name].bus, self.pacer, reset=partial(self._reset, name))
            slot.muted = self._muted
            self._slots[name] = slot
        return self._slots[name]


async def _open(plug: Plug, url: PortUrl) -> OpenPort:
    """Open a serial port; each transport is imported on first use."""
    match url.scheme:
        case "pty":
            from axistwin.links.pty import PtyPort

            return PtyPort(plug, url)
        case "serial":
            from axistwin.links.serialdev import SerialDevice

            return SerialDevice(plug, url)
        case "rfc2217":
            from axistwin.links.rfc2217 import ComPortClient
            from axistwin.links.tcp import listen

            return await listen(url, lambda: ComPortClient(plug, url.cts))
        case _:
            from axistwin.links.tcp import TcpClient, listen

            return await listen(url, lambda: TcpClient(plug))


async def _open_slot(slot: "Slot", url: PortUrl) -> OpenPort:
    from axistwin.links.bus import Master
    from axistwin.links.tcp import listen

    return await listen(url, lambda: Master(slot))
