"""The sequence buffers, and the state of the sequence being performed."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from axistwin.controllers.compumotor.language import Opcode
from axistwin.sim.clock import Clock, Event, Procedure, Process, kill


@dataclass(frozen=True)
class Stored:
    """A command in a buffer."""

    command: Opcode
    values: tuple[Any, ...]
    string: bytes


class Sequences:
    """Fifteen buffers in one memory."""

    def __init__(self, memory: int) -> None:
        self.memory = memory
        self.defining: int | None = None
        """Number of the sequence being defined, which stores the host's commands."""
        self._buffers: dict[int, list[Stored]] = {}

    def __getitem__(self, number: int) -> list[Stored] | None:
        return self._buffers.get(number)

    def __iter__(self) -> Iterator[int]:
        """The numbers of the defined sequences, in order."""
        return iter(sorted(self._buffers))

    @property
    def free(self) -> int:
        """Free bytes of memory. A command takes the length of its command string."""
        return self.memory - sum(len(stored.string) for buffer in self._buffers.values() for stored in buffer)

    def begin(self, number: int) -> None:
        """Clear this buffer, and store the commands that follow."""
        self.defining = number
        self._buffers[number] = []

    def store(self, stored: Stored) -> None:
        """Store a command in the buffer being defined; without enough memory the command is lost."""
        assert self.defining is not None
        if len(stored.string) <= self.free:
            self._buffers[self.defining].append(stored)

    def delete(self, number: int) -> None:
        """Delete a sequence if it is defined."""
        self._buffers.pop(number, None)

    def clear(self) -> None:
        """Delete all sequences, as at the entry to a streaming mode."""
        self._buffers.clear()
        self.defining = None


class Order(Enum):
    """The order to the sequencer for the end of the present command."""

    CONTINUE = auto()
    SUSPEND = auto()
    KILL = auto()  # SUSPEND, and a SINGULAR command that is discontinued
    LEAVE = auto()


SUSPENDED = (Order.SUSPEND, Order.KILL)


@dataclass
class Loop:
    """Commands `first` to `last` of the buffer, repeated `left` more times; None: until CONTINUE."""

    first: int
    last: int
    left: int | None


class Sequencer:
    """The sequence being performed."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.loop: Loop | None = None
        self.at = 0
        """Index of the command being performed."""
        self.number = 0
        """Number of the sequence."""
        self.on_command: Callable[[int, int], None] = lambda number, at: None
        """Called with the number and the index when the processor begins a command of a sequence."""
        self.order = Order.CONTINUE
        self._waiting: Event | None = None
        self.process: Process | None = None

    @property
    def running(self) -> bool:
        """True while a sequence is performed or suspended."""
        return self.process is not None and self.process.is_alive

    def start(self, number: int, procedure: Procedure) -> None:
        """Perform a sequence from its first command."""
        self.number, self.at = number, 0
        self.process = self.clock.process(procedure)

    def end(self) -> None:
        """End the sequence at once."""
        if self.process is not None:
            kill(self.process)
        self.process, self._waiting = None, None

    def leave(self) -> None:
        """End the sequence after the present command."""
        self.order = Order.LEAVE
        self._wake()

    def suspend(self) -> None:
        """Suspend the sequence after the present command.  During a wait for CONTINUE, one CONTINUE ends both."""
        if self.order is Order.CONTINUE and self._waiting is None:
            self.order = Order.SUSPEND

    def kill_and_suspend(self) -> None:
        """Suspend the sequence in the present command; a SINGULAR command that has not begun is skipped."""
        if self.order is not Order.LEAVE:
            self.order = Order.KILL

    def go_on(self) -> None:
        """CONTINUE: end a wait or suspension; otherwise end an endless loop after this round."""
        if self._waiting is not None:
            self._wake()
        elif self.order in SUSPENDED:
            self.order = Order.CONTINUE
        elif self.running and self.loop is not None and self.loop.left is None:
            self.loop.left = 1

    def wait(self) -> Procedure:
        """Wait for CONTINUE."""
        self._waiting = self.clock.event()
        try:
            yield self._waiting
        finally:
            self._waiting = None

    def _wake(self) -> None:
        if self._waiting is not None and not self._waiting.triggered:
            self._waiting.succeed()

    def advance(self, length: int) -> None:
        """Go to the next command of a buffer of this length, or back to the first command of the loop."""
        loop = self.loop
        if loop is None or self.at < min(loop.last, length - 1):
            self.at += 1
        elif loop.left is not None and loop.left <= 1:
            self.loop, self.at = None, self.at + 1
        else:
            loop.left = None if loop.left is None else loop.left - 1
            self.at = loop.first
