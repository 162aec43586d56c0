"""Controllers of a bench on real ports."""

from typing import Protocol

from axistwin.bench import Bench
from axistwin.links.pacing import Pacer
from axistwin.links.plug import Flow, Plug
from axistwin.links.urls import PortUrl


class OpenPort(Protocol):
    """A port that is open."""

    url: PortUrl
    """Where it really is: with the number that was given for port 0."""

    def close(self) -> None:
        """Close it."""


class Server:
    """Paces a bench and opens ports to its controllers.  Used within a running event loop.

    `speed`: times real time, None as fast as it goes.  `flow`: what holds back characters of the host on a transport
    that does not say so itself.  `reset`: whether a new client finds the controller just switched on.
    """

    def __init__(self, bench: Bench, *, speed: float | None = 1.0, flow: Flow = Flow.DTR, reset: bool = False) -> None:
        self.bench, self.pacer = bench, Pacer(bench.clock, speed)
        self.ports: list[tuple[str, PortUrl]] = []
        """Each open port, with its controller's name."""
        self._flow, self._reset = flow, reset
        self._plugs: dict[str, Plug] = {}
        self._open: list[OpenPort] = []

    async def open(self, name: str, url: PortUrl) -> PortUrl:
        """Open a port of the controller of this name.  Raises LinkError; UsageError if there is no such controller."""
        plug = self._plugs.get(name) or Plug(self.bench[name], self.pacer, flow=self._flow, reset=self._reset)
        self._plugs[name] = plug
        port = await _open(plug, url)
        self._open.append(port)
        self.ports.append((name, port.url))
        return port.url

    def start(self) -> None:
        """From now on virtual time passes."""
        self.pacer.start()

    def close(self) -> None:
        """Close every port and disconnect every client.  Virtual time stands still."""
        for plug in self._plugs.values():
            if plug.client is not None:
                plug.client.drop()
        while self._open:
            self._open.pop().close()
        self.pacer.stop()


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

            return await listen(url, lambda: ComPortClient(plug))
        case _:
            from axistwin.links.tcp import TcpClient, listen

            return await listen(url, lambda: TcpClient(plug))
