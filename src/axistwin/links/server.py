"""Controllers of a bench on real ports."""

from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from axistwin.bench import Bench
from axistwin.links.one import OneClient
from axistwin.links.pacing import Pacer
from axistwin.links.plug import Plug
from axistwin.links.urls import PortUrl
from axistwin.sim.serial_port import Flow

if TYPE_CHECKING:
    from axistwin.links.bus import Slot


class OpenPort(Protocol):
    """A port that is open."""

    url: PortUrl
    """Where it really is: with the number that was given for port 0."""

    def close(self) -> None:
        """Close it."""


class Server:
    """Paces a bench and opens ports to its controllers.  Used within a running event loop.

    `speed`: times real time, None as fast as it goes.  `flow`: what holds back characters of the host on a transport
    that does not say so itself.  `reset`: whether a new client finds the controller just switched on.  `pacer`: one
    that advances the bench in another way.
    """

    def __init__(
        self,
        bench: Bench,
        *,
        speed: float | None = 1.0,
        flow: Flow = Flow.DTR,
        reset: bool = False,
        pacer: Pacer | None = None,
    ) -> None:
        self.bench, self.pacer = bench, pacer or Pacer(bench.clock, speed)
        self.ports: list[tuple[str, PortUrl]] = []
        """Each open port, with its controller's name."""
        self._flow, self._reset = flow, reset
        self._plugs: dict[str, Plug] = {}
        self._slots: dict[str, Slot] = {}
        self._open: list[OpenPort] = []

    async def open(self, name: str, url: PortUrl) -> PortUrl:
        """Open a port to whom a host reaches by this name: a controller, its second channel, a line of motors.

        Raises LinkError; UsageError if there is nothing of this name.
        """
        port = await (_open_slot(self._slot(name), url) if url.scheme == "bus" else _open(self._plug(name), url))
        self._open.append(port)
        self.ports.append((name, port.url))
        return port.url

    def start(self) -> None:
        """From now on virtual time passes."""
        self.pacer.start()

    def close(self) -> None:
        """Close every port and disconnect every client.  Virtual time stands still."""
        places: list[OneClient[Any]] = [*self._plugs.values(), *self._slots.values()]
        for place in places:
            if place.client is not None:
                place.client.drop()
        while self._open:
            self._open.pop().close()
        self.pacer.stop()

    def _plug(self, name: str) -> Plug:
        if name not in self._plugs:
            reset = partial(self._power_cycle, name) if self._reset else lambda: None
            title = self.bench[name].product.model if name in self.bench.controllers else name
            self._plugs[name] = Plug(name, self.bench.port(name), self.pacer, title=title, flow=self._flow, reset=reset)
        return self._plugs[name]

    def _power_cycle(self, name: str) -> None:
        """Everybody who is reached by this name."""
        line = self.bench.lines.get(name)
        for controller in (self.bench[name.removesuffix(".rs485")],) if line is None else line.motors:
            controller.power_cycle()

    def _slot(self, name: str) -> "Slot":
        from axistwin.links.bus import Slot

        if name not in self._slots:
            self._slots[name] = Slot(self.bench[name], self.pacer, reset=self._reset)
        return self._slots[name]


async def _open(plug: Plug, url: PortUrl) -> OpenPort:
    """Each transport is imported when it is asked for."""
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
