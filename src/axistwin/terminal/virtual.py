"""A virtual controller at the other end of a terminal: a session paced to the wall clock."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable

from axistwin.bench.codec import codec_of
from axistwin.sessions.session import Session
from axistwin.sim.serial_port import Flow
from axistwin.units import S

PATIENCE_NS = 60 * S
"""Longest virtual time to wait for an idle controller."""


class VirtualEnd(ABC):
    """The only controller of a session."""

    def __init__(self, session: Session) -> None:
        self.session, self.bench = session, session.bench
        (self.controller,) = session.bench.controllers.values()
        self._unsubscribe = self._subscribe()
        session.run()

    @abstractmethod
    def _subscribe(self) -> Callable[[], object]:
        """Subscribe to the controller's data.  Return an unsubscribe function."""

    @abstractmethod
    def send(self, data: bytes) -> None:
        """Transmit a typed line."""

    def do(self, target: str, value: str) -> None:
        """Perform an action at the machine.  Raises AxistwinError."""
        self.session.do(self.controller.name, target, value)

    def set_speed(self, speed: float | None) -> None:
        """Set the ratio of virtual time to wall-clock time; None: as fast as possible."""
        self.session.speed = speed

    async def run_until_quiet(self) -> None:
        """Wait until no event is due."""
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
        unsubscribe = self.session.pacer.subscribe(advanced.set)
        while not until():
            advanced.clear()
            await advanced.wait()
        unsubscribe()

    def close(self) -> None:
        """Switch the controller off and unsubscribe."""
        self.session.pause()
        self._unsubscribe()
        self.controller.power(False)


class SerialEnd(VirtualEnd):
    """A controller with a serial port.  `receive` gets the data."""

    def __init__(self, session: Session, receive: Callable[[bytes], None]) -> None:
        self._receive = receive
        super().__init__(session)
        self.do("flow", Flow.DTR.value)

    def _subscribe(self) -> Callable[[], object]:
        return self.controller.serial.subscribe_received(lambda byte, _: self._receive(bytes([byte])))

    def send(self, data: bytes) -> None:
        """Transmit, as fast as the line and the controller's DTR allow."""
        self.session.say(self.controller.name, data)


class BoardEnd(VirtualEnd):
    """A board on a bus: a line is a command in hex or by name; messages are shown in hex and by name."""

    def __init__(self, session: Session, print_line: Callable[[str], None]) -> None:
        self._print_line = print_line
        super().__init__(session)
        self._codec = codec_of(self.controller.product)

    def _subscribe(self) -> Callable[[], object]:
        return self.controller.bus.subscribe_received(self._received)

    def send(self, data: bytes) -> None:
        """Queue a command for the board.  Raises ProgramError for an unknown command."""
        if text := data.decode("utf-8", "replace").partition(";")[0].strip():
            self.session.say(self.controller.name, self._codec.read(text))

    def _received(self, message: bytes) -> None:
        shown = self._codec.show(message.rstrip(b"\0") or message[:1])
        self._print_line(f"< {shown}   {self._codec.words(message, by_host=False)}")
