"""Controllers of a bench on real ports."""

from collections.abc import Callable
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
    that does not say so itself.  `reset`: whether a new client finds the controller just switched on; or what does that
    to whoever has a name, in place of a power cycle.  `pacer`: one that advances the bench in another way.  `opening`:
    told the name of each who is opened a port to, the first time, before anything is done there.
    """

    def __init__(
        self,
        bench: Bench,
        *,
        speed: float | None = 1.0,
        flow: Flow = Flow.DTR,
        reset: bool | Callable[[str], object] = False,
        pacer: Pacer | None = None,
        opening: Callable[[str], object] = lambda name: None,
    ) -> None:
        self.bench, self.pacer = bench, pacer or Pacer(bench.clock, speed)
        self.ports: list[tuple[str, PortUrl]] = []
        """Each open port, with its controller's name."""
        self._flow, self._opening = flow, opening
        self._reset = reset if callable(reset) else self._power_cycle if reset else lambda name: None
        self._deaf = False
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
        for place in self._places:
            if place.client is not None:
                place.client.drop()
        while self._open:
            self._open.pop().close()
        self.pacer.stop()

    def client(self, name: str) -> str:
        """Who is connected to whom a host reaches by this name, such as `127.0.0.1:4711`; "" if nobody is."""
        return next((place.who for place in self._places if place.name == name), "")

    # While a run is repeated, on another bench

    @property
    def deaf(self) -> bool:
        """While True nothing reaches the bench from outside: clients wait, new ones are refused.

        They are told nothing either: what is repeated they have heard.  Then what has been missed is made up for.
        """
        return self._deaf

    @deaf.setter
    def deaf(self, on: bool) -> None:
        if on is self._deaf:
            return
        self._deaf = on
        for place in self._places:
            place.deaf = on
        if not on:
            for place in self._places:
                place.make_up()
            self.pacer.work()

    def exchange(self, bench: Bench) -> None:
        """Another bench, with the same names, takes the place of this one; clients stay connected.

        Its ports are left as they are: who repeats a run does there what hosts have done.  Not while the bench is being
        advanced.  Raises UsageError if somebody is missing on it; then nothing has changed.
        """
        ports, buses = {name: bench.port(name) for name in self._plugs}, {name: bench[name].bus for name in self._slots}
        deaf, self.deaf = self.deaf, True
        self.bench = bench
        for name, port in ports.items():
            self._plugs[name].exchange(port)
        for name, bus in buses.items():
            self._slots[name].exchange(bus)
        self.pacer.exchange(bench.clock)
        self.deaf = deaf

    @property
    def _places(self) -> list[OneClient[Any]]:
        return [*self._plugs.values(), *self._slots.values()]

    def _plug(self, name: str) -> Plug:
        if name not in self._plugs:
            port = self.bench.port(name)
            title = self.bench[name].product.model if name in self.bench.controllers else name
            self._opening(name)
            self.pacer.sync()
            plug = Plug(name, port, self.pacer, title=title, flow=self._flow, reset=partial(self._reset, name))
            plug.deaf = self._deaf
            self._plugs[name] = plug
        return self._plugs[name]

    def _power_cycle(self, name: str) -> None:
        """Everybody who is reached by this name."""
        line = self.bench.lines.get(name)
        for controller in (self.bench[name.removesuffix(".rs485")],) if line is None else line.motors:
            controller.power_cycle()

    def _slot(self, name: str) -> "Slot":
        from axistwin.links.bus import Slot

        if name not in self._slots:
            self._opening(name)
            slot = Slot(name, self.bench[name].bus, self.pacer, reset=partial(self._reset, name))
            slot.deaf = self._deaf
            self._slots[name] = slot
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
