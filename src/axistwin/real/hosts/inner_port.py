"""A driver at a controller of a bench, without a port: virtual time passes only while the driver waits.

The bench runs as fast as the computer can: a wait for an answer, a pause and the interval between two polls advance
virtual time, and nothing else does.  So a program with this driver has the same result in each run.
"""

import asyncio
from collections.abc import Callable

from axistwin.bench import Bench, endpoints
from axistwin.core.units import to_ns, to_seconds
from axistwin.links.bus import Master, Slot
from axistwin.links.manual_pacer import ManualPacer
from axistwin.links.plug import Plug
from axistwin.sim.frames import LineError
from axistwin.sim.serial_port import Flow


class InnerPort:
    """A driver's connection to an emulated controller; virtual time advances while it waits."""

    def __init__(self, bench: Bench, name: str) -> None:
        self._pacer = ManualPacer(bench)
        self._received = bytearray()
        self._send, self._disconnect = _connect(bench, name, self._pacer, self._received)

    async def write(self, data: bytes) -> None:
        self._send(data)
        self._pacer.work()

    async def read(self, timeout: float) -> bytes:
        """Return at least one byte, or b"" if none arrives in `timeout` seconds of virtual time."""
        clock = self._pacer.clock
        end_ns = clock.later(to_ns(timeout))
        while not self._received and clock.now < end_ns:
            self._pacer.advance(end_ns)
        await asyncio.sleep(0)  # other tasks run
        data = bytes(self._received)
        self._received.clear()
        return data

    async def pause(self, seconds: float) -> None:
        end_ns = self._pacer.clock.later(to_ns(seconds))
        while self._pacer.clock.now < end_ns:
            self._pacer.advance(end_ns)
        await asyncio.sleep(0)  # other tasks run

    def time(self) -> float:
        """Return the virtual time in seconds."""
        return to_seconds(self._pacer.clock.now)

    async def close(self) -> None:
        self._disconnect()


def _connect(
    bench: Bench, name: str, pacer: ManualPacer, received: bytearray
) -> tuple[Callable[[bytes], None], Callable[[], None]]:
    if endpoints.at_a_bus(bench, name):
        slot = Slot(name, bench[name].bus, pacer)
        master = _InnerMaster(slot, received)
        slot.connect(master)
        return master.received, master.close
    plug = Plug(name, bench.port(name), pacer, flow=Flow.DTR)
    client = _InnerClient(received)
    plug.connect(client)
    return plug.send, lambda: plug.disconnect(client)


class _InnerClient:
    name = "a driver"
    flow: Flow | None = None

    def __init__(self, received: bytearray) -> None:
        self._received = received

    def deliver(self, data: bytes, errors: LineError) -> None:  # noqa: ARG002  # as on a TCP connection
        self._received += data

    def hung_up(self) -> bool:
        return False

    def drop(self) -> None: ...

    def pause(self) -> None: ...

    def resume(self) -> None: ...


class _InnerMaster(Master):
    def __init__(self, slot: Slot, received: bytearray) -> None:
        super().__init__(slot)
        self.name, self._received = "a driver", received

    def _write(self, line: str) -> None:
        self._received += line.encode() + b"\n"

    def close(self) -> None:
        self._end_subscription()
        self.slot.disconnect(self)
