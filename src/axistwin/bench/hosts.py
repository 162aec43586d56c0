"""A host at the other end of a controller's port, of either kind: it sends data and receives data.

To observe the data of other hosts, use `bench/events.py`.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from axistwin.bench import endpoints
from axistwin.bench.bench import Bench
from axistwin.bench.controller import Controller
from axistwin.controllers.product import BusHost
from axistwin.sim.serial_port import SerialPort
from axistwin.units import MS


class Host(Protocol):
    """Sends and receives data."""

    @property
    def pending(self) -> int:
        """Amount of data that has not been sent yet."""

    @property
    def pause_ns(self) -> int:
        """Silence after which the received data are complete."""

    def write(self, data: bytes) -> None:
        """Send data as soon as possible."""

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `callback` with received data.  Return an unsubscribe function."""


@contextmanager
def host_of(controller: Controller) -> Iterator[Host]:
    """Yield a host for this controller.  On a bus the host serves the registers until the context ends."""
    attend = controller.product.attend
    if attend is None:
        yield _Serial(controller.serial)
        return
    attendant = attend(controller.bus)
    try:
        yield _Bus(attendant)
    finally:
        attendant.close()


@contextmanager
def host_at(bench: Bench, name: str) -> Iterator[Host]:
    """Yield a host for an endpoint: a controller, its second channel, or a shared line."""
    if endpoints.at_a_bus(bench, name):
        with host_of(bench[name]) as host:
            yield host
    else:
        yield _Serial(bench.port(name))


class _Serial:
    def __init__(self, port: SerialPort) -> None:
        self._port = port

    @property
    def pending(self) -> int:
        return self._port.pending

    @property
    def pause_ns(self) -> int:
        return 3 * self._port.host.format.frame_ns

    def write(self, data: bytes) -> None:
        self._port.write(data)

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        return self._port.subscribe_received(lambda byte, _: callback(bytes([byte])))


class _Bus:
    pause_ns = 20 * MS

    def __init__(self, attendant: BusHost) -> None:
        self._attendant = attendant

    @property
    def pending(self) -> int:
        return self._attendant.pending

    def write(self, data: bytes) -> None:
        self._attendant.write(data)

    def subscribe_received(self, callback: Callable[[bytes], None]) -> Callable[[], None]:
        return self._attendant.subscribe_received(callback)
