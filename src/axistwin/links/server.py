"""A server: the controllers of a bench on real ports."""

import sys
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from axistwin.bench import Bench, endpoints
from axistwin.core.errors import LinkError, UsageError
from axistwin.links.pacing import Pacer
from axistwin.links.plug import HostPort, Plug
from axistwin.links.single_client import Gate, SingleClient
from axistwin.links.urls import PortUrl
from axistwin.sim.serial_port import Flow

if TYPE_CHECKING:
    import socket

    from axistwin.links.bus import Registers, Slot
    from axistwin.links.sharing import Hub


class OpenPort(Protocol):
    """Interface of a port that is open for clients."""

    url: PortUrl  # Actual address of the port; for port 0, with the number that the system has chosen.

    def close(self) -> None: ...


class Ports(Protocol):
    """Interface to find serial ports and board registers by name.  Raises UsageError for an unknown name."""

    def serial(self, name: str) -> HostPort: ...

    def bus(self, name: str) -> "Registers": ...


class Server:
    """Paces a bench and opens ports to its controllers.  Use within a running event loop.

    `speed`: times real time; None: as fast as possible.  `flow`: the host's flow control, on transports without one.
    `reset`: True power-cycles the controller for each new client; a function is called with its name instead.  `pacer`:
    replaces the default pacer.  `access`: returns the ports for clients; None: the ports of the bench itself.
    `share`: a TCP port has several clients.
    """

    def __init__(
        self, bench: Bench, *, speed: float | None = 1.0, flow: Flow = Flow.DTR,
        reset: bool | Callable[[str], object] = False, pacer: Pacer | None = None, access: Ports | None = None,
        share: bool = False,
    ) -> None:  # fmt: skip
        self.bench, self.pacer = bench, pacer or Pacer(bench.clock, speed)
        self.ports: list[tuple[str, PortUrl]] = []
        self.gate = Gate()
        self._flow, self._access, self._share = flow, access, share
        self._reset = reset if callable(reset) else self._power_cycle if reset else lambda name: None
        self._plugs: dict[str, Plug] = {}
        self._slots: dict[str, Slot] = {}
        self._hubs: dict[str, Hub] = {}
        self._open: list[OpenPort] = []

    async def open(self, name: str, url: PortUrl) -> PortUrl:
        """Open a port to a controller, a second channel or a line of motors.  Raises LinkError, UsageError."""
        port: OpenPort
        if self._share:
            if url.scheme != "tcp":
                raise UsageError(
                    f"several clients cannot share the port {url}: expected a raw TCP port, e.g. tcp://127.0.0.1:5001"
                )
            port = await _open_shared(self._hub(name), url)
        elif url.scheme == "bus":
            port = await _open_slot(self._slot(name), url)
        else:
            port = await _open(self._plug(name), url)
        self._open.append(port)
        self.ports.append((name, port.url))
        return port.url

    async def connect(self, name: str) -> "socket.socket":
        """Connect a client in this process to a controller, and return its socket.  No port is opened for others."""
        from axistwin.links.bus import Master
        from axistwin.links.tcp import TcpClient, connected

        if endpoints.at_a_bus(self.bench, name):
            return await connected(lambda: Master(self._slot(name)))
        return await connected(lambda: TcpClient(self._plug(name)))

    def start(self) -> None:
        self.pacer.start()

    def start_on_connection(self) -> None:
        def start() -> None:
            unsubscribe()
            self.start()

        unsubscribe = self.gate.admitted.subscribe(start)

    def close(self) -> None:
        for endpoint in self._endpoints:
            if endpoint.client is not None:
                endpoint.client.drop()
        while self._open:
            self._open.pop().close()
        self.pacer.stop()

    def client(self, name: str) -> str:
        """Return the client's address at an endpoint, e.g. `127.0.0.1:4711`; "" without a client."""
        return next((endpoint.client_name for endpoint in self._endpoints if endpoint.name == name), "")

    @property
    def heard_ns(self) -> int:
        """Virtual time at which a client has last sent data, in ns; -1 if none has."""
        return max((endpoint.heard_ns for endpoint in self._endpoints), default=-1)

    @property
    def _endpoints(self) -> list[SingleClient[Any]]:
        return [*self._plugs.values(), *self._slots.values()]

    def _plug(self, name: str) -> Plug:
        if name not in self._plugs:
            port: HostPort = self._access.serial(name) if self._access else self.bench.port(name)
            title = self.bench[name].product.model if name in self.bench.controllers else name
            self.pacer.sync()
            reset = partial(self._reset, name)
            self._plugs[name] = Plug(name, port, self.pacer, title=title, flow=self._flow, reset=reset, gate=self.gate)
        return self._plugs[name]

    def _hub(self, name: str) -> "Hub":
        from axistwin.links.sharing import Hub

        if name not in self._hubs:
            made = self.bench.controllers.get(name)
            family = "smartmotor" if made is None else made.product.family  # Only SmartMotors share a line.
            plain = family not in ("digiplan", "smartmotor")
            self._hubs[name] = Hub(self._plug(name), motors=family == "smartmotor", plain=plain)
        return self._hubs[name]

    def _power_cycle(self, name: str) -> None:
        line = self.bench.lines.get(name)
        for controller in (self.bench[name.removesuffix(".rs485")],) if line is None else line.motors:
            controller.power_cycle()

    def _slot(self, name: str) -> "Slot":
        from axistwin.links.bus import Slot

        if name not in self._slots:
            bus: Registers = self._access.bus(name) if self._access else self.bench[name].bus
            self._slots[name] = Slot(name, bus, self.pacer, reset=partial(self._reset, name), gate=self.gate)
        return self._slots[name]


async def _open(plug: Plug, url: PortUrl) -> OpenPort:
    match url.scheme:
        case "pty":
            if sys.platform != "linux":
                raise LinkError(
                    "a pty needs Linux: expected a TCP port or a serial device, "
                    "e.g. rfc2217://127.0.0.1:2217 or serial://COM5"
                )
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


async def _open_shared(hub: "Hub", url: PortUrl) -> OpenPort:
    from axistwin.links.tcp import listen

    return await listen(url, hub.seat)


async def _open_slot(slot: "Slot", url: PortUrl) -> OpenPort:
    from axistwin.links.bus import Master
    from axistwin.links.tcp import listen

    return await listen(url, lambda: Master(slot))
