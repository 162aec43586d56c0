"""A port of a virtual controller whose time is slower than real time, because of `--speed` or of a busy computer."""

import asyncio

from axistwin.core.units import to_ns, to_seconds
from axistwin.drivers.asynchronous import Port
from axistwin.links.pacing import Pacer


class PacedPort:
    """A port whose clock is the controller's: time-outs and pauses of a driver are in virtual time."""

    def __init__(self, port: Port, pacer: Pacer) -> None:
        self._port, self._pacer = port, pacer

    async def write(self, data: bytes) -> None:
        await self._port.write(data)

    async def read(self, timeout: float) -> bytes:
        """Wait for bytes and return them; return b"" if no byte arrives within `timeout` seconds of virtual time."""
        end_ns, over = self._now_ns() + to_ns(timeout), False
        while not (data := await self._port.read(self._left(end_ns))) and not over:
            over = self._now_ns() >= end_ns  # then look once more: virtual time may just have caught up
        return data

    async def pause(self, seconds: float) -> None:
        end_ns = self._now_ns() + to_ns(seconds)
        while self._now_ns() < end_ns:
            await asyncio.sleep(self._left(end_ns))

    def time(self) -> float:
        """Return the virtual time in seconds."""
        return to_seconds(self._now_ns())

    async def close(self) -> None:
        await self._port.close()

    def _now_ns(self) -> int:
        self._pacer.work()
        return self._pacer.clock.now

    def _left(self, end_ns: int) -> float:
        """Return the real time until the virtual time `end_ns`, and at least 1 ms."""
        return max(to_seconds(end_ns - self._now_ns()) / (self._pacer.speed or 1), 0.001)
