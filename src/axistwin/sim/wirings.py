"""Connections between the ends of serial lines: two ends, several ends in a ring, or several ends on one pair of wires.

A `Wiring` connects the host's end to devices: `direct`, as a `daisy_chain` or as a `shared_pair`.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

from axistwin.sim.frames import Break, UartFormat
from axistwin.sim.serial import Line, Uart

Wiring = Callable[[Uart], tuple[Line, Line]]  # Connects the host; returns the lines from and to it.


def wire(sender: Uart, receiver: Uart, instant: bool) -> Line:
    line = Line(sender.clock, receiver, instant)
    sender.line, receiver.peers = line, (sender,)
    return line


def join(first: Uart, second: Uart, *, instant: bool = False) -> None:
    wire(first, second, instant)
    wire(second, first, instant)


class Pair:
    """A pair of wires that several serial ports share, as in RS-485.

    Each end receives the signals of all other ends.  The wire is at space when any end sends space; two simultaneous
    senders garble each other.  No end receives its own characters.
    """

    def __init__(self, ends: Sequence[Uart], instant: bool = False) -> None:
        self.lines = tuple(Line(end.clock, end, instant) for end in ends)
        """One line per end, in the order of the ends: the signals that the end receives."""
        for end in ends:
            end.line = _Tap(self.lines, end)
            end.peers = tuple(other for other in ends if other is not end)


class _Tap:
    def __init__(self, lines: Sequence[Line], sender: Uart) -> None:
        self._others = [line for line in lines if line.receiver is not sender]
        self._own = next(line for line in lines if line.receiver is sender)

    @property
    def instant(self) -> bool:
        return self._own.instant

    @property
    def ready(self) -> bool:
        return all(line.ready for line in self._others)

    def carry(self, sent: UartFormat, item: int | Break) -> int:
        self._own.occupy(sent, item)
        return max(line.carry(sent, item) for line in self._others)


def direct(device: Uart, *, instant: bool = False) -> Wiring:
    return daisy_chain([device], instant=instant)


def daisy_chain(devices: Sequence[Uart], *, instant: bool = False) -> Wiring:
    """Return a ring: host to first device, each device's transmitter to the next receiver, the last one to the host."""

    def connect(host: Uart) -> tuple[Line, Line]:
        lines = [wire(sender, receiver, instant) for sender, receiver in pairwise((host, *devices, host))]
        return lines[0], lines[-1]

    return connect


def shared_pair(devices: Sequence[Uart], *, instant: bool = False) -> Wiring:
    """Return a wiring of host and devices on one pair; its lines are the first device's and the host's."""

    def connect(host: Uart) -> tuple[Line, Line]:
        pair = Pair((host, *devices), instant)
        return pair.lines[1], pair.lines[0]

    return connect
