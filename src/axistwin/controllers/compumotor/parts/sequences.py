"""The sequence buffers, and the state of the sequence being performed."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from axistwin.controllers.compumotor.language import Opcode
from axistwin.sim.clock import Clock, Event, Procedure, Process, kill


@dataclass(frozen=True)
class Stored:
    """A command that is stored in a sequence buffer."""

    command: Opcode
    values: tuple[Any, ...]
    string: bytes


class Sequences:
    """The fifteen sequence buffers, which share one memory."""

    def __init__(self, memory: int) -> None:
        self.memory = memory
        self.defining: int | None = None  # Number of the sequence being defined, which stores the host's commands.
        self.buffers: dict[int, list[Stored]] = {}

    def __getitem__(self, number: int) -> list[Stored] | None:
        return self.buffers.get(number)

    def __iter__(self) -> Iterator[int]:
        return iter(sorted(self.buffers))

    @property
    def free(self) -> int:
        """Number of free bytes in the memory for sequences; each command takes the length of its string."""
        return self.memory - sum(len(stored.string) for buffer in self.buffers.values() for stored in buffer)

    def store(self, stored: Stored) -> None:
        """Store a command in the sequence that is being defined.  Without enough free memory, the command is lost."""
        assert self.defining is not None
        if len(stored.string) <= self.free:
            self.buffers[self.defining].append(stored)


class Order(Enum):
    """Next action of a sequence in progress: continuation, suspension or end."""

    CONTINUE = auto()  # Perform the next command of the sequence.
    SUSPEND = auto()  # Suspend the sequence after its present command.
    KILL = auto()  # Abort the present command of the sequence, e.g. a move, and suspend the sequence.
    LEAVE = auto()  # End the sequence after its present command.


SUSPENDED = (Order.SUSPEND, Order.KILL)


@dataclass
class Loop:
    """A loop over commands `first` to `last`, repeated `left` more times; `left` None: until CONTINUE."""

    first: int
    last: int
    left: int | None


class Sequencer:
    """State of the sequence that is being performed."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.loop: Loop | None = None
        self.at = 0
        self.number = 0
        self.on_command: Callable[[int, int], None] = lambda number, at: None
        """Function that is called with sequence number and index when a command of a sequence begins."""
        self.order = Order.CONTINUE
        self.waiting: Event | None = None
        self.trigger: tuple[int, bool] | None = None  # Trigger and level for which the sequence waits (2Ch).
        self.process: Process | None = None

    @property
    def running(self) -> bool:
        return self.process is not None and self.process.is_alive

    def start(self, number: int, procedure: Procedure) -> None:
        self.number, self.at = number, 0
        self.process = self.clock.process(procedure)

    def end(self) -> None:
        """End the sequence at once."""
        if self.process is not None:
            kill(self.process)
        self.process, self.waiting = None, None

    def wait(self) -> Procedure:
        """Pause the sequence until the command CONTINUE (48h)."""
        self.waiting = self.clock.event()
        try:
            yield self.waiting
        finally:
            self.waiting = None

    def wake(self) -> None:
        """Continue the sequence if the sequence is waiting for CONTINUE (48h)."""
        if self.waiting is not None and not self.waiting.triggered:
            self.waiting.succeed()

    def advance(self, length: int) -> None:
        """Go to the next of the sequence's `length` commands, or back to the first one of the present loop."""
        loop = self.loop
        if loop is None or self.at < min(loop.last, length - 1):
            self.at += 1
        elif loop.left is not None and loop.left <= 1:
            self.loop, self.at = None, self.at + 1
        else:
            loop.left = None if loop.left is None else loop.left - 1
            self.at = loop.first
