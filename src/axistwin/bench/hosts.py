"""A simulated host that sends and receives data at a controller's serial port or bus.

To observe the data of other hosts, use `bench/events.py`.
"""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass

from axistwin.bench import endpoints
from axistwin.bench.bench import Bench
from axistwin.bench.controller import Controller
from axistwin.controllers.product import BusHost
from axistwin.core.units import MS
from axistwin.sim.serial_port import SerialPort


@dataclass(frozen=True)
class Host:
    """Interface of a simulated host, which sends and receives data."""

    write: Callable[[bytes], None]  # Function that sends data as soon as possible.
    subscribe_received: Callable[[Callable[[bytes], None]], Callable[[], None]]
    """Function that subscribes to received data and returns an unsubscribe function."""
    _port: SerialPort | BusHost

    @property
    def pending(self) -> int:
        """Number of bytes that the host has not sent yet.  On a bus: number of commands."""
        return self._port.pending

    @property
    def sending(self) -> bool:
        return self._port.sending if isinstance(self._port, SerialPort) else bool(self._port.pending)

    @property
    def pause_ns(self) -> int:
        """Length in ns of the pause that marks the end of a message."""
        return 3 * self._port.host.format.frame_ns if isinstance(self._port, SerialPort) else 20 * MS


def _at_port(port: SerialPort) -> Host:
    return Host(port.write, lambda callback: port.subscribe_received(lambda byte, _: callback(bytes([byte]))), port)


@contextmanager
def host_of(controller: Controller) -> Iterator[Host]:
    attend = controller.product.attend
    if attend is None:
        yield _at_port(controller.serial)
        return
    with closing(attend(controller.bus)) as attendant:
        yield Host(attendant.write, attendant.subscribe_received, attendant)


@contextmanager
def host_at(bench: Bench, name: str) -> Iterator[Host]:
    """Yield a host for an endpoint: a controller, its second channel, or a shared line."""
    if endpoints.at_a_bus(bench, name):
        with host_of(bench[name]) as host:
            yield host
    else:
        yield _at_port(bench.port(name))
