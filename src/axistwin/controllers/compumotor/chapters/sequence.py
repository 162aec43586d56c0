"""Chapter Sequence buffers: commands 20h to 2Ch, 41h, 48h, 92h, D8h to DAh."""

from collections import deque

from axistwin.controllers.compumotor.language import Accept
from axistwin.controllers.compumotor.parts.sequences import SUSPENDED, Loop, Order, Stored
from axistwin.controllers.compumotor.state import State
from axistwin.core.units import MS
from axistwin.sim.clock import Procedure

EDGE_TRIGGERS = (1, 6)
LEVEL_RESPONSE_NS = 3 * MS  # Triggers 2 to 5: "the worst case response to them is 3 milliseconds".


def repeat(board: State, count: int, times: int | None = None) -> None:
    """Commands 20h, 21h: repeat 1 to 255 commands, 1 to 65,535 times or until CONTINUE.  Ignored in a loop."""
    sequencer = board.sequencer
    if sequencer.loop is None:
        sequencer.loop = Loop(sequencer.at + 1, sequencer.at + count, times)


def wait_for_continue(board: State, message: bool) -> Procedure:
    """Command 28h: wait for CONTINUE (48h); send a message first if `message` is True."""
    if message:
        board.send(0x28, b"")
    yield from board.sequencer.wait()


def wait(unit_ns: int, board: State, count: int) -> Procedure:
    """Commands 29h, 2Ah, 2Bh: wait for `count` milliseconds, seconds or minutes.  A count of 0 has no effect."""
    yield board.clock.timeout(count * unit_ns)


def wait_for_trigger(board: State, trigger: int, high: bool) -> Procedure:
    """Command 2Ch: wait for a rising edge of trigger 1 or 6, or for a steady level of triggers 2 to 5."""
    board.sequencer.trigger = trigger, high or trigger in EDGE_TRIGGERS
    try:
        if trigger in EDGE_TRIGGERS:
            yield board.triggers.edge(trigger)
        else:
            yield from _wait_for_level(board, trigger, high)
    finally:
        board.sequencer.trigger = None


def _wait_for_level(board: State, trigger: int, high: bool) -> Procedure:
    pin = board.pins[f"trigger{trigger}"]
    while True:
        while pin.level is not high:
            yield pin.changed()
        steady = board.clock.timeout(LEVEL_RESPONSE_NS)
        yield steady | pin.changed()
        if steady.processed:
            return


def go_on(board: State) -> None:
    """Command 48h, CONTINUE: continue a sequence that is waiting or suspended.

    Otherwise end an endless loop of the sequence after its present pass.  Ignored if there is no wait, no suspension
    and no endless loop.
    """
    sequencer = board.sequencer
    if sequencer.waiting is not None:
        sequencer.wake()
    elif sequencer.order in SUSPENDED:
        sequencer.order = Order.CONTINUE
    elif sequencer.running and sequencer.loop is not None and sequencer.loop.left is None:
        sequencer.loop.left = 1


def begin(board: State, number: int) -> None:
    """Command D9h: store the commands up to D8h in sequence 1 to 15; only SEQUENCE commands are stored."""
    board.sequences.defining, board.sequences.buffers[number] = number, []


def finish(board: State) -> None:
    """Command D8h: end the definition of a sequence."""
    board.sequences.defining = None


def delete(board: State, number: int) -> None:
    """Command DAh: delete the sequence with the given number (1 to 15), and free its memory."""
    board.sequences.buffers.pop(number, None)


def perform(board: State, number: int) -> str | None:
    """Command 41h: perform the sequence with the given number (1 to 15).

    The command is ignored while a sequence is performed, or if this sequence is undefined.
    """
    buffer = board.sequences[number]
    if not buffer:
        return ""
    if not board.sequencer.running:
        board.sequencer.start(number, _perform(board, list(buffer)))
    return None


def _perform(board: State, buffer: list[Stored]) -> Procedure:
    sequencer = board.sequencer
    sequencer.at, sequencer.loop, sequencer.order = 0, None, Order.CONTINUE
    board.refresh()
    try:
        while sequencer.at < len(buffer):
            stored = buffer[sequencer.at]
            sequencer.on_command(sequencer.number, sequencer.at)
            yield board.clock.timeout(board.step_ns)
            killed = sequencer.order is Order.KILL and Accept.SINGULAR in stored.command.accepted
            if not killed and not board.excludes(stored.command):
                yield from board.carry_out(stored.command, stored.values, board.sequence)
            if board.sequence.singular is not None:
                yield board.sequence.singular
            if sequencer.order in SUSPENDED:
                yield from sequencer.wait()
                sequencer.order = Order.LEAVE if sequencer.order is Order.LEAVE else Order.CONTINUE
            if sequencer.order is Order.LEAVE:
                break
            sequencer.advance(len(buffer))
    finally:
        sequencer.process = None
        board.refresh()


def list_commands(board: State, number: int) -> Procedure | None:
    """Command 92h: send a message for each command of sequence 1 to 15, and one with the null command.

    Messages that the host has not read are lost.  While the message queue is full, 92h remains in progress.
    """
    board.handshake.forget_messages()
    left = deque([*(stored.string for stored in board.sequences[number] or ()), b""])
    _fill_queue(board, left)
    return _list_remaining(board, left) if left else None


def _list_remaining(board: State, left: deque[bytes]) -> Procedure:
    while left:
        yield board.handshake.taken()
        _fill_queue(board, left)


def _fill_queue(board: State, left: deque[bytes]) -> None:
    while left and not board.handshake.full:
        board.send(0x92, left.popleft())
