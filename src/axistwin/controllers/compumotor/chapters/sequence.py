"""Chapter Sequence buffers: commands 20h to 2Ch, 41h, 48h, 92h, D8h to DAh."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum, auto
from typing import TYPE_CHECKING, Any

from axistwin.controllers.compumotor.language import Accept, Opcode
from axistwin.sim.clock import Clock, Event, Procedure, Process, kill
from axistwin.units import MS

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board

EDGE_TRIGGERS = (1, 6)
LEVEL_RESPONSE_NS = 3 * MS
"""Triggers 2 to 5: "the worst case response to them is 3 milliseconds"."""


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
        self._buffers: dict[int, list[Stored]] = {}
        self._defining: int | None = None

    def __getitem__(self, number: int) -> list[Stored] | None:
        return self._buffers.get(number)

    def __iter__(self) -> Iterator[int]:
        """The numbers of those that have a definition, in order."""
        return iter(sorted(self._buffers))

    @property
    def defining(self) -> int | None:
        """The one into which commands are stored instead of being performed."""
        return self._defining

    @property
    def free(self) -> int:
        """Bytes of memory left.  A command takes as many as its string is long."""
        return self.memory - sum(len(stored.string) for buffer in self._buffers.values() for stored in buffer)

    def begin(self, number: int) -> None:
        """What comes now goes into this buffer; what was in it is gone."""
        self._defining = number
        self._buffers[number] = []

    def store(self, stored: Stored) -> None:
        """Into the buffer that is being defined; where there is no room it is lost."""
        assert self._defining is not None
        if len(stored.string) <= self.free:
            self._buffers[self._defining].append(stored)

    def finish(self) -> None:
        """The definition is over."""
        self._defining = None

    def delete(self, number: int) -> None:
        """There is no such sequence any more."""
        self._buffers.pop(number, None)

    def clear(self) -> None:
        """All are gone, as when a streaming mode is entered."""
        self._buffers.clear()
        self._defining = None


class Order(Enum):
    """What the sequencer is to do when the present command is finished."""

    GO_ON = auto()
    SUSPEND = auto()
    KILL = auto()  # and the present command ends before its time, if it is SINGULAR
    LEAVE = auto()


SUSPENDED = (Order.SUSPEND, Order.KILL)


@dataclass
class Loop:
    """Commands `first` to `last` of the buffer, `left` more times; None: until CONTINUE."""

    first: int
    last: int
    left: int | None


class Sequencer:
    """Performs a sequence, command after command."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.loop: Loop | None = None
        self.at = 0
        """The command being performed."""
        self.number = 0
        """The sequence it belongs to."""
        self.on_command: Callable[[int, int], None] = lambda number, at: None
        """Told of each command of a sequence when the processor turns to it."""
        self._order = Order.GO_ON
        self._waiting: Event | None = None
        self.process: Process | None = None
        """What performs it."""

    @property
    def running(self) -> bool:
        """Whether a sequence is being performed, or suspended."""
        return self.process is not None and self.process.is_alive

    def start(self, board: "Board", number: int, buffer: list[Stored]) -> None:
        """Perform a buffer from its beginning."""
        self.number, self.at = number, 0
        self.process = self.clock.process(self._perform(board, list(buffer)))

    def end(self) -> None:
        """At once."""
        if self.process is not None:
            kill(self.process)
        self.process, self._waiting = None, None

    def leave(self) -> None:
        """After the present command."""
        self._order = Order.LEAVE
        self._wake()

    def suspend(self) -> None:
        """After the present command, until CONTINUE.  Where CONTINUE is waited for already, that one is enough."""
        if self._order is Order.GO_ON and self._waiting is None:
            self._order = Order.SUSPEND

    def kill_and_suspend(self) -> None:
        """Until CONTINUE, whatever the present command waits for; if it is SINGULAR and yet to begin it does not."""
        if self._order is not Order.LEAVE:
            self._order = Order.KILL

    def go_on(self) -> None:
        """CONTINUE: what waits for it goes on; a loop that does is left at the end of this round."""
        if self._waiting is not None:
            self._wake()
        elif self._order in SUSPENDED:
            self._order = Order.GO_ON
        elif self.running and self.loop is not None and self.loop.left is None:
            self.loop.left = 1

    def wait(self) -> Procedure:
        """Until CONTINUE."""
        self._waiting = self.clock.event()
        try:
            yield self._waiting
        finally:
            self._waiting = None

    def _wake(self) -> None:
        if self._waiting is not None and not self._waiting.triggered:
            self._waiting.succeed()

    def _perform(self, board: "Board", buffer: list[Stored]) -> Procedure:
        self.at, self.loop, self._order = 0, None, Order.GO_ON
        board.refresh()
        try:
            while self.at < len(buffer):
                stored = buffer[self.at]
                self.on_command(self.number, self.at)
                yield self.clock.timeout(board.step_ns)
                if not self._killed(stored.command) and not board.excludes(stored.command):
                    yield from board.carry_out(stored.command, stored.values, board.sequence)
                if board.sequence.singular is not None:
                    yield board.sequence.singular
                if self._order in SUSPENDED:
                    yield from self.wait()
                    self._order = Order.LEAVE if self._leaving() else Order.GO_ON
                if self._leaving():
                    break
                self._advance(len(buffer))
        finally:
            self.process = None
            board.refresh()

    def _killed(self, command: Opcode) -> bool:
        return self._order is Order.KILL and Accept.SINGULAR in command.accepted

    def _leaving(self) -> bool:
        return self._order is Order.LEAVE

    def _advance(self, length: int) -> None:
        loop = self.loop
        if loop is None or self.at < min(loop.last, length - 1):
            self.at += 1
        elif loop.left is not None and loop.left <= 1:
            self.loop, self.at = None, self.at + 1
        else:
            loop.left = None if loop.left is None else loop.left - 1
            self.at = loop.first


# Flow of a sequence


def repeat(board: "Board", count: int, times: int | None = None) -> None:
    """Commands 20h and 21h: repeat the next 1 to 255 commands 1 to 65,535 times, or until CONTINUE.

    Ignored inside another loop.
    """
    sequencer = board.sequencer
    if sequencer.loop is None:
        sequencer.loop = Loop(sequencer.at + 1, sequencer.at + count, times)


def wait_for_continue(board: "Board", message: bool) -> Procedure:
    """Command 28h: wait for CONTINUE, with a message if wished."""
    if message:
        board.send(0x28, b"")
    yield from board.sequencer.wait()


def wait(unit_ns: int, board: "Board", count: int) -> Procedure:
    """Commands 29h, 2Ah, 2Bh: wait so many milliseconds, seconds or minutes; 0 is ignored."""
    yield board.clock.timeout(count * unit_ns)


def wait_for_trigger(board: "Board", trigger: int, high: bool) -> Procedure:
    """Command 2Ch: wait for trigger 1 to 6: a rising edge of 1 and 6, a level of 2 to 5 that stays."""
    if trigger in EDGE_TRIGGERS:
        yield board.triggers.edge(trigger)
        return
    pin = board.pins[f"trigger{trigger}"]
    while True:
        while pin.level is not high:
            yield pin.changed()
        steady = board.clock.timeout(LEVEL_RESPONSE_NS)
        yield steady | pin.changed()
        if steady.processed:
            return


def go_on(board: "Board") -> None:
    """Command 48h, CONTINUE.  Ignored if nothing waits for it."""
    board.sequencer.go_on()


# Definition


def begin(board: "Board", number: int) -> None:
    """Command D9h: commands from now on go into sequence 1 to 15, until D8h; those that may not are ignored."""
    board.sequences.begin(number)


def finish(board: "Board") -> None:
    """Command D8h: the definition ends."""
    board.sequences.finish()


def delete(board: "Board", number: int) -> None:
    """Command DAh: delete sequence 1 to 15; its memory is free again."""
    board.sequences.delete(number)


def perform(board: "Board", number: int) -> None:
    """Command 41h: perform sequence 1 to 15.  Ignored if it is not defined, or one is being performed."""
    buffer = board.sequences[number]
    if buffer and not board.sequencer.running:
        board.sequencer.start(board, number, buffer)


def list_commands(board: "Board", number: int) -> Procedure | None:
    """Command 92h: a message for each command of sequence 1 to 15, and one with the null command.

    Messages that the host has not read are lost.  What finds the message queue full follows as the host reads; until
    then 92h is in progress.
    """
    board.handshake.forget_messages()
    left = deque([*(stored.string for stored in board.sequences[number] or ()), b""])
    _list_while_there_is_room(board, left)
    return _list_the_rest(board, left) if left else None


def _list_the_rest(board: "Board", left: deque[bytes]) -> Procedure:
    while left:
        yield board.handshake.taken()
        _list_while_there_is_room(board, left)


def _list_while_there_is_room(board: "Board", left: deque[bytes]) -> None:
    while left and not board.handshake.full:
        board.send(0x92, left.popleft())
