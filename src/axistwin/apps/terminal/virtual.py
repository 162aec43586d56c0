"""A controller in this process at the other end of a terminal, paced to the wall clock."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import ExitStack

from axistwin.apps.conversations.host import host_of
from axistwin.apps.conversations.visible import codec_of
from axistwin.bench import Bench, Controller
from axistwin.links.pacing import Pacer
from axistwin.links.plug import Plug
from axistwin.sim.frames import LineError
from axistwin.sim.serial_port import Flow
from axistwin.units import S

PATIENCE_NS = 60 * S
"""So long it is given to come to rest."""


class VirtualEnd(ABC):
    """A controller in this process, paced to the wall clock."""

    def __init__(self, bench: Bench, controller: Controller, speed: float | None) -> None:
        self.bench, self.controller = bench, controller
        self._pacer = Pacer(bench.clock, speed)

    @abstractmethod
    def send(self, data: bytes) -> None:
        """Transmit what has been typed."""

    def change(self, action: Callable[[], object]) -> None:
        """Somebody at the machine does something."""
        self._pacer.sync()
        action()
        self._pacer.work()

    def set_speed(self, speed: float | None) -> None:
        """Virtual time passes so many times as fast as the wall clock's; None: as fast as it goes."""
        self._pacer.stop()
        self._pacer.speed = speed
        self._pacer.start()

    async def settle(self) -> None:
        """Wait until nothing more happens by itself."""
        until_ns = self.bench.now + PATIENCE_NS
        await self._advance(lambda: self.bench.clock.quiet or self.bench.now >= until_ns)

    async def wait(self, seconds: float) -> None:
        """Let virtual time pass."""
        if self._pacer.speed is None:
            self.change(lambda: self.bench.run(seconds))
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
        self._pacer.stop()
        self.controller.power(False)


class SerialEnd(VirtualEnd):
    """A controller with a serial plug."""

    name = "the terminal"
    flow: Flow | None = None

    def __init__(
        self, bench: Bench, controller: Controller, speed: float | None, hear: Callable[[bytes], None]
    ) -> None:
        super().__init__(bench, controller, speed)
        self._hear = hear
        self._plug = Plug(controller.name, controller.serial, self._pacer, flow=Flow.DTR)
        self._plug.connect(self)
        self._pacer.start()

    def send(self, data: bytes) -> None:
        """Transmit, as fast as the line and the controller's DTR allow."""
        self._plug.send(data)

    def close(self) -> None:
        """Pull the plug and switch it off."""
        self._plug.disconnect(self)
        super().close()

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


class BoardEnd(VirtualEnd):
    """A board on a bus: a line is a command in hex or by its name, messages are shown in hex and in words."""

    def __init__(self, bench: Bench, controller: Controller, speed: float | None, tell: Callable[[str], None]) -> None:
        super().__init__(bench, controller, speed)
        self._tell, self._codec = tell, codec_of(controller.product)
        self._stack = ExitStack()
        self._host = self._stack.enter_context(host_of(controller))
        self._host.hear(self._heard)
        self._pacer.start()

    def send(self, data: bytes) -> None:
        """Hand over a command as soon as the board takes it.  Raises ProgramError if it is none."""
        if text := data.decode("utf-8", "replace").partition(";")[0].strip():
            command = self._codec.read(text)
            self.change(lambda: self._host.write(command))

    def close(self) -> None:
        """Leave the registers alone and switch it off."""
        self._stack.close()
        super().close()

    def _heard(self, message: bytes) -> None:
        shown = self._codec.show(message.rstrip(b"\0") or message[:1])
        self._tell(f"< {shown}   {self._codec.words(message, by_host=False)}")
