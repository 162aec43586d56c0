"""The connection of a terminal to a virtual controller, whose time is paced by the wall clock."""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from axistwin.bench.codec import codec_of, unpadded
from axistwin.bench.controller import on_a_bus
from axistwin.core.errors import UsageError
from axistwin.core.units import S
from axistwin.scenes.hosting import program_text
from axistwin.scenes.sessions.condition import condition
from axistwin.scenes.sessions.session import Session
from axistwin.sim.serial_port import Flow
from axistwin.ui.teaching.tutor import Tutor
from axistwin.ui.terminal.screen import Screen

T = TypeVar("T")
PATIENCE_NS = 60 * S  # Longest virtual time to wait until the controller is idle.


class VirtualEnd(ABC):
    """Connection of the terminal to the only controller of a session."""

    def __init__(self, session: Session) -> None:
        self.session, self.bench = session, session.bench
        (self.controller,) = session.bench.controllers.values()
        self.tutor = Tutor(self.controller)
        self._unsubscribe = self._subscribe()
        session.run()

    @abstractmethod
    def _subscribe(self) -> Callable[[], object]: ...

    @abstractmethod
    def send(self, data: bytes) -> None: ...

    def read(self, line: bytes) -> bytes:
        """Convert a typed line to the data to send.  Raises ProgramError for an unknown command."""
        return line

    def do(self, target: str, value: str) -> None:
        """Perform an action at the machine, e.g. drive an input high.  Raises AxistwinError."""
        self.session.do(self.controller.name, target, value)

    def load(self, file: str) -> None:
        """Switch the controller off and on, load a program, and start the program.  Raises AxistwinError."""
        if not file:
            raise UsageError("no program to load: expected a file, e.g. :load home.sms")
        self.session.load(self.controller.name, file, program_text(Path(file)))

    def store(self, text: str) -> None:
        """Load the text of a program into a SmartMotor, and start the program.  Raises AxistwinError."""
        if not text:
            raise UsageError("no program to store: expected a program after the command, e.g. :store RTEMP END")
        self.session.load(self.controller.name, "typed.sms", f"{text}\n")

    @property
    def status(self) -> str:
        return self.inspect(self._status)

    def inspect(self, read: Callable[[], T]) -> T:
        """Advance virtual time to now, and return the result of `read`, which reads the controller's state."""
        return self.session.pacer.inspect(read)

    def _status(self) -> str:
        axes = (f"{name} {axis.position}" for name, axis in self.controller.axes.items())
        return f"{self.session.seconds:.3f} s   {'  '.join(axes)}   {condition(self.session).words}"

    def set_speed(self, speed: float | None) -> None:
        """Set the speed of virtual time: 1 is real time, None is full speed."""
        self.session.speed = speed

    async def run_until_quiet(self) -> None:
        """Wait until the controller is idle.  The wait ends after `PATIENCE_NS` of virtual time at the latest."""
        until_ns = self.bench.now + PATIENCE_NS
        await self._advance(lambda: self.bench.clock.quiet or self.bench.now >= until_ns)

    async def wait(self, seconds: float) -> None:
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
        self.session.pause()
        self._unsubscribe()
        self.controller.power(False)


class SerialEnd(VirtualEnd):
    """Connection to a serial line: `receive` gets the data, `aside` the tutor's comments."""

    def __init__(
        self, session: Session, receive: Callable[[bytes], None], aside: Callable[..., None] = lambda *lines: None
    ) -> None:
        self._forward, self._aside = receive, aside
        super().__init__(session)
        self.do("flow", Flow.DTR.value)

    def _subscribe(self) -> Callable[[], object]:
        return self.controller.serial.subscribe_received(lambda byte, _: self._receive(bytes([byte])))

    def _receive(self, data: bytes) -> None:
        self._forward(data)
        if self.tutor.on:
            self._aside(*self.tutor.received(data))

    def send(self, data: bytes) -> None:
        """Send a typed line; baud rate and the controller's DTR limit the speed."""
        self.session.say(self.controller.name, data)


class BoardEnd(VirtualEnd):
    """Connection to a board: typed commands in hex or by name, messages in both forms."""

    def __init__(
        self, session: Session, print_line: Callable[[str], None], aside: Callable[..., None] = lambda *lines: None
    ) -> None:
        self._print_line, self._aside = print_line, aside
        super().__init__(session)
        self._codec = codec_of(self.controller.product)

    def _subscribe(self) -> Callable[[], object]:
        return self.controller.bus.subscribe_received(self._received)

    def read(self, line: bytes) -> bytes:
        """Convert a typed command, in hex or by name, to the bytes of the command."""
        text = line.decode("utf-8", "replace").partition(";")[0].strip()
        return self._codec.read(text) if text else b""

    def send(self, data: bytes) -> None:
        """Queue a command for the board.  Raises ProgramError for an unknown command."""
        if command := self.read(data):
            self.session.say(self.controller.name, command)

    def _received(self, message: bytes) -> None:
        shown = self._codec.show(unpadded(message))
        self._print_line(f"< {shown}   {self._codec.words(message, by_host=False)}")
        if self.tutor.on:
            self._aside(*self.tutor.received(message))


def virtual_end(session: Session, screen: Screen) -> VirtualEnd:
    if on_a_bus(next(iter(session.bench.controllers.values()))):
        return BoardEnd(session, screen.show, screen.aside)
    return SerialEnd(session, screen.show_received, screen.aside)
