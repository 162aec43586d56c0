"""How the ends of serial lines are connected: two to each other, in a ring, or all to one pair of wires.

How the host's end is wired is told by a `Wiring`: `direct` to a device, through a `daisy_chain`, to a `shared_pair`.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

from axistwin.sim.frames import Break, UartFormat
from axistwin.sim.serial import Line, Uart

Wiring = Callable[[Uart], tuple[Line, Line]]
"""Connects a host's end; returns the line that leads away from it and the one that comes to it."""


def wire(sender: Uart, receiver: Uart, instant: bool) -> Line:
    """Connect a transmitter to a receiver."""
    line = Line(sender.clock, receiver, instant)
    sender.line, receiver.peers = line, (sender,)
    return line


def join(first: Uart, second: Uart, *, instant: bool = False) -> None:
    """Connect two ends, transmitter to receiver both ways."""
    wire(first, second, instant)
    wire(second, first, instant)


class Pair:
    """One pair of wires that several ends share, as in RS-485: everybody hears everybody else.

    The wire is at space when anybody says so; who speaks while another does garbles both.  Nobody hears itself.
    """

    def __init__(self, ends: Sequence[Uart], instant: bool = False) -> None:
        self.lines = tuple(Line(end.clock, end, instant) for end in ends)
        """What arrives at each end, in their order."""
        for end in ends:
            end.line = _Tap(self.lines, end)
            end.peers = tuple(other for other in ends if other is not end)


class _Tap:
    """Where one end's transmitter is connected to the pair."""

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
    """To one device, both ways."""
    return daisy_chain([device], instant=instant)


def daisy_chain(devices: Sequence[Uart], *, instant: bool = False) -> Wiring:
    """Host to the first device, each device's transmitter to the next one's receiver, the last one's to the host."""

    def connect(host: Uart) -> tuple[Line, Line]:
        ends = (host, *devices, host)
        lines = [wire(sender, receiver, instant) for sender, receiver in pairwise(ends)]
        return lines[0], lines[-1]

    return connect


def shared_pair(devices: Sequence[Uart], *, instant: bool = False) -> Wiring:
    """Host and devices on one pair; the lines are the first device's and the host's."""

    def connect(host: Uart) -> tuple[Line, Line]:
        pair = Pair((host, *devices), instant)
        return pair.lines[1], pair.lines[0]

    return connect
