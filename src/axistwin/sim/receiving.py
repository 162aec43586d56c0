"""A character that a receiver is receiving: intact, or sampled bit by bit."""

from axistwin.core.units import S
from axistwin.sim.frames import UartFormat
from axistwin.sim.levels import Levels, Space


class Whole:
    """A character received as a whole; another signal on the wire makes its bits be sampled."""

    __slots__ = ("byte", "end_ns", "sampled", "sent", "start_ns")

    def __init__(self, sent: UartFormat, byte: int, start_ns: int) -> None:
        self.sent, self.byte, self.start_ns = sent, byte, start_ns
        self.end_ns = start_ns + sent.receive_ns  # The end of the first stop bit.
        self.sampled: Reading | None = None  # The same character after sampling has begun.


class Reading:
    """State of a serial receiver during the reception of one character.

    The receiver samples the middle of each bit.  Instants are whole numbers of 1/`per` ns.  The falling edge of the
    start bit is at `edge/edge_per` ns.
    """

    __slots__ = ("edge_ns", "end_ns", "fmt", "idle", "left", "levels", "next", "per", "space", "step", "taken")

    def __init__(self, fmt: UartFormat, edge: int, edge_per: int, space: Space | None = None) -> None:
        half_bit = S * edge_per
        self.fmt, self.per = fmt, 2 * fmt.baudrate * edge_per
        begin = 2 * fmt.baudrate * edge
        self.next, self.step = begin + half_bit, 2 * half_bit
        self.levels, self.taken, self.left = 0, 0, fmt.samples
        self.idle = begin + fmt.receive_ns * self.per - half_bit
        """The instant from which the receiver searches for a start bit: the middle of the stop bit, as in a real UART.
        """
        self.edge_ns = edge // edge_per
        self.end_ns = self.edge_ns + fmt.receive_ns  # The end of the first stop bit.
        self.space = space  # The space that the falling edge begins; None if sampling began within a character.

    def read(self, wire: Levels, before_ns: int | None = None) -> int:
        """Sample the levels before this time, or all; stop at a false start.  Return the number of samples."""
        count = self.left
        if before_ns is not None:
            missing = before_ns * self.per - self.next
            if missing <= 0 or not count:
                return 0
            count = min(count, -(-missing // self.step))
        if not self.taken and not wire.low(self.next, self.per):
            count, self.levels = 1, 1
        else:
            self.levels |= wire.sample(self.next, self.step, self.per, count) << self.taken
        self.taken += count
        self.left -= count
        self.next += count * self.step
        return count

    @property
    def false_start(self) -> bool:
        """True if the start bit ends before its middle."""
        return self.levels & 1 == 1
