"""Chapter Stop, discontinue, suspend, kill: commands 70h to 7Fh and ACh, by command and by trigger 1 or 6.

STOP ramps down; KILL of motion ends the pulses at once.  A SINGULAR command that is ended before its time leaves the
motor at the velocity of that instant.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from axistwin.controllers.compumotor.chapters.profiles import stopping
from axistwin.sim.clock import Clock, Event
from axistwin.sim.pins import Pin
from axistwin.units import MS

if TYPE_CHECKING:
    from axistwin.controllers.compumotor.board import Board

LOW_BEFORE_NS = 2 * MS
"""A trigger must have been low for so long before an edge counts."""
INTERRUPT_ON_TRIGGER = 0xAC


# By command


def stop_motion(board: "Board") -> None:
    """Commands 70h, 74h: ramp to zero velocity at the most recent acceleration; while streaming, as 78h.

    Where a stream has left the motor at a velocity, the ramp is that of the last move, or as the option
    `stop_after_stream` says; without any move since reset there is no ramp.
    """
    pulses, speed = board.pulses, board.motion.speed
    if board.motion.streamed and not board.streaming and board.options.stop_after_stream == "ignored":
        return
    board.motion.stopped = True
    if board.streaming or board.loop.correcting or speed is None:
        kill_motion(board)
    elif not pulses.ending:
        pulses.change(stopping(pulses.rate, speed))


def discontinue_sequence(board: "Board") -> None:
    """Commands 71h, 75h: the sequence ends when its present command is finished; its contents are kept."""
    board.sequencer.leave()


def suspend_sequence(board: "Board") -> None:
    """Commands 72h, 76h: the sequence waits for CONTINUE when its present command is finished."""
    board.sequencer.suspend()


def discontinue_singular(board: "Board") -> None:
    """Commands 73h, 77h: end any SINGULAR command, of the host or the sequence; a moving motor keeps its velocity."""
    board.host.end()
    board.sequence.end()


def kill_motion(board: "Board") -> None:
    """Commands 78h, 7Ch: no more pulses, at once, as at a limit."""
    board.motion.stopped = True
    board.stream.end()
    board.pulses.kill()


def kill_sequence(board: "Board") -> None:
    """Commands 79h, 7Dh: the sequence ends, and its SINGULAR command with it; the host's goes on.

    Ignored without a sequence.
    """
    if board.sequencer.running:
        board.sequencer.end()
        board.sequence.end()


def kill_and_suspend(board: "Board") -> None:
    """Commands 7Ah, 7Eh: the sequence's SINGULAR command ends, the host's goes on; the sequence waits for CONTINUE.

    Ignored without a sequence.
    """
    if board.sequencer.running:
        board.sequencer.kill_and_suspend()
        board.sequence.end()


# By trigger


@dataclass(frozen=True)
class Function:
    """What a trigger does."""

    opcode: int
    action: Callable[["Board"], None] | None
    message: bool


class Triggers:
    """Trigger inputs 1 and 6, which interrupt the processor on a rising edge."""

    def __init__(self, board: "Board", clock: Clock, pins: dict[int, Pin], response_ns: dict[int, int]) -> None:
        """`response_ns`: from the edge to what the trigger does, with the input high all the time."""
        self._board, self.clock, self._pins, self._response_ns = board, clock, pins, response_ns
        self._functions: dict[int, Function] = {}
        self._fell_ns = dict.fromkeys(pins, -LOW_BEFORE_NS)
        self._edges: dict[int, Event] = {}
        self._unwatch = [pin.subscribe(partial(self._look, number)) for number, pin in pins.items()]

    def close(self) -> None:
        """The power is gone."""
        for unwatch in self._unwatch:
            unwatch()
        self._functions.clear()

    def give(self, trigger: int, function: Function, on: bool) -> None:
        """Switch a function of a trigger on or off.  A trigger has one at a time; another is refused until then."""
        present = self._functions.get(trigger)
        if present is not None and present.opcode != function.opcode:
            return
        if on:
            self._functions[trigger] = function
        else:
            self._functions.pop(trigger, None)

    def drop(self, opcode: int) -> None:
        """No trigger has this function any more."""
        self._functions = {t: f for t, f in self._functions.items() if f.opcode != opcode}

    def edge(self, trigger: int) -> Event:
        """An event that happens when the trigger goes active next."""
        if trigger not in self._edges:
            self._edges[trigger] = self.clock.event()
        return self._edges[trigger]

    def _look(self, trigger: int, pin: Pin) -> None:
        now_ns = self.clock.now
        if not pin.level:
            self._fell_ns[trigger] = now_ns
        elif now_ns - self._fell_ns[trigger] >= LOW_BEFORE_NS:
            fell_ns = self._fell_ns[trigger]
            self.clock.call_later(self._response_ns[trigger], lambda: self._respond(trigger, fell_ns))

    def _respond(self, trigger: int, fell_ns: int) -> None:
        if self._fell_ns[trigger] != fell_ns or not self._board.alive:
            return  # too short a pulse, or nobody there
        if (waiting := self._edges.pop(trigger, None)) is not None:
            waiting.succeed()
        if (function := self._functions.get(trigger)) is not None:
            if function.message:
                self._board.send(function.opcode, bytes([trigger]))
            if function.action is not None:
                function.action(self._board)


def on_trigger(
    opcode: int, action: Callable[["Board"], None], board: "Board", trigger: int, on: bool, message: bool
) -> None:
    """Commands 74h to 7Fh with trigger 1 or 6: the same when the trigger goes active, with a message if wished."""
    board.triggers.give(trigger, Function(opcode, action, message), on)


def interrupt_on_trigger(board: "Board", trigger: int, on: bool) -> None:
    """Command ACh: a message when trigger 1 or 6 goes active.  It is that trigger's one function."""
    board.triggers.give(trigger, Function(INTERRUPT_ON_TRIGGER, None, message=True), on)
