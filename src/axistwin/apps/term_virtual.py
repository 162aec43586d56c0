"""A controller in this process at the other end of a terminal, paced to the wall clock."""

import asyncio
from collections.abc import Callable

from axistwin.bench import Bench, Controller
from axistwin.links.pacing import Pacer
from axistwin.links.plug import Flow, Plug
from axistwin.sim.serial import LineError
from axistwin.units import S

PATIENCE_NS = 60 * S
"""So long it is given to come to rest."""


class VirtualEnd:
    """A controller in this process, paced to the wall clock."""

    name = "the terminal"
    flow: Flow | None = None

    def __init__(
        self, bench: Bench, controller: Controller, speed: float | None, hear: Callable[[bytes], None]
    ) -> None:
        self.bench, self.controller, self._hear = bench, controller, hear
        self._pacer = Pacer(bench.clock, speed)
        self._plug = Plug(controller, self._pacer, flow=Flow.DTR)
        self._plug.connect(self)
        self._pacer.start()

    def send(self, data: bytes) -> None:
        """Transmit, as fast as the line and the controller's DTR allow."""
        self._plug.send(data)

    def change(self, action: Callable[[], object]) -> None:
        """Somebody at the machine does something."""
        self._plug.change(action)

    def set_speed(self, speed: float | None) -> None:
        """Virtual time passes so many times as fast as the wall clock's; None: as fast as it goes."""
        self._pacer.stop()
        self._pacer.speed = speed
        self._pacer.start()

    async def settle(self) -> None:
        """Wait until nothing more happens by itself."""
        until_ns = self.bench.now + PATIENCE_NS
        await self._advance(lambda: self.bench.clock.next_event_ns() is None or self.bench.now >= until_ns)

    async def wait(self, seconds: float) -> None:
        """Let virtual time pass."""
        if self._pacer.speed is None:
            self._plug.change(lambda: self.bench.run(seconds))
        else:
            await asyncio.sleep(seconds / self._pacer.speed)

    async def _advance(self, until: Callable[[], bool]) -> None:
        advanced = asyncio.Event()
        unwatch = self._pacer.watch(advanced.set)
        while not until():
            advanced.clear()
            await advanced.wait()
        unwatch()

    def close(self) -> None:
        """Switch it off."""
        self._plug.disconnect(self)
        self._pacer.stop()
        self.controller.power(False)

    # What the plug calls

    def deliver(self, data: bytes, errors: LineError) -> None:  # noqa: ARG002
        """Characters from the controller."""
        self._hear(data)

    def hung_up(self) -> bool:
        """Nobody else can come."""
        return False

    def drop(self) -> None:
        """Nobody else can come."""

    def pause(self) -> None:
        """What has been typed waits."""

    def resume(self) -> None:
        """What has been typed goes on."""
