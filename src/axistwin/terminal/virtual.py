"""A controller in this process at the other end of a terminal: a session, paced to the wall clock."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable

from axistwin.bench.codec import codec_of
from axistwin.sessions.session import Session
from axistwin.sim.serial_port import Flow
from axistwin.units import S

PATIENCE_NS = 60 * S
"""So long it is given to come to rest."""


class VirtualEnd(ABC):
    """The only controller of a session."""

    def __init__(self, session: Session) -> None:
        self.session, self.bench = session, session.bench
        (self.controller,) = session.bench.controllers.values()
        self._unhear = self._listen()
        session.run()

    @abstractmethod
    def _listen(self) -> Callable[[], object]:
        """Hear what the controller says from now on.  Returns what ends it."""

    @abstractmethod
    def send(self, data: bytes) -> None:
        """Transmit what has been typed."""

    def do(self, target: str, value: str) -> None:
        """A person at the machine does something.  Raises AxistwinError."""
        self.session.do(self.controller.name, target, value)

    def set_speed(self, speed: float | None) -> None:
        """Virtual time passes so many times as fast as the wall clock's; None: as fast as it goes."""
        self.session.speed = speed

    async def run_until_quiet(self) -> None:
        """Wait until nothing more happens by itself."""
        until_ns = self.bench.now + PATIENCE_NS
        await self._advance(lambda: self.bench.clock.quiet or self.bench.now >= until_ns)

    async def wait(self, seconds: float) -> None:
        """Let virtual time pass."""
        pacer = self.session.pacer
        if pacer.speed is None:
            pacer.sync()
            self.bench.run(seconds)
            pacer.work()
        else:
            await asyncio.sleep(seconds / pacer.speed)

    async def _advance(self, until: Callable[[], bool]) -> None:
        advanced = asyncio.Event()
        unwatch = self.session.pacer.watch(advanced.set)
        while not until():
            advanced.clear()
            await advanced.wait()
        unwatch()

    def close(self) -> None:
        """Switch it off, and hear no more."""
        self.session.pause()
        self._unhear()
        self.controller.power(False)


class SerialEnd(VirtualEnd):
    """A controller with a serial plug.  `hear` is given what it says."""

    def __init__(self, session: Session, hear: Callable[[bytes], None]) -> None:
        self._hear = hear
        super().__init__(session)
        self.do("flow", Flow.DTR.value)

    def _listen(self) -> Callable[[], object]:
        return self.controller.serial.hear(lambda byte, _: self._hear(bytes([byte])))

    def send(self, data: bytes) -> None:
        """Transmit, as fast as the line and the controller's DTR allow."""
        self.session.say(self.controller.name, data)


class BoardEnd(VirtualEnd):
    """A board on a bus: a line is a command in hex or by its name, messages are told in hex and in words."""

    def __init__(self, session: Session, tell: Callable[[str], None]) -> None:
        self._tell = tell
        super().__init__(session)
        self._codec = codec_of(self.controller.product)

    def _listen(self) -> Callable[[], object]:
        return self.controller.bus.hear(self._heard)

    def send(self, data: bytes) -> None:
        """Hand over a command as soon as the board takes it.  Raises ProgramError if it is none."""
        if text := data.decode("utf-8", "replace").partition(";")[0].strip():
            self.session.say(self.controller.name, self._codec.read(text))

    def _heard(self, message: bytes) -> None:
        shown = self._codec.show(message.rstrip(b"\0") or message[:1])
        self._tell(f"< {shown}   {self._codec.words(message, by_host=False)}")
