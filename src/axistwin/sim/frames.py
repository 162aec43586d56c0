"""Characters as frames of bits: formats, and decoding of sampled levels in a format.

idle ──┐     ┌──┬──┬──┬──┬──┬──┬──┬──┬──┐╌╌╌ idle or next start bit
       │start│b0│b1│b2│b3│b4│b5│b6│b7│par│stop
       └─────┴──┴──┴──┴──┴──┴──┴──┴──┴──┘
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Flag
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise, product
from typing import Literal, NamedTuple, get_args

from axistwin.core.errors import UsageError
from axistwin.core.units import S

Parity = Literal["N", "E", "O", "M", "S"]
BITS = 5, 6, 7, 8
STOP_BITS = 1, 1.5, 2
FASTEST_BAUD = 12_000_000  # The highest valid baud rate: that of the UARTs in USB adapters.
MARK, SPACE = True, False


class LineError(Flag):
    """Errors that a receiver detects in a character."""

    NONE = 0
    PARITY = 1
    FRAMING = 2
    BREAK = 4


SOUND = LineError.NONE  # Constant for no error, because access to the enumeration is slow in an inner loop.


@dataclass(frozen=True)
class UartFormat:
    """The format of a character on the wire.  Parity as a letter: N(one), E(ven), O(dd), M(ark), S(pace).

    Raises UsageError for an invalid format.  Valid are 1 to 12,000,000 baud, 5 to 8 data bits, 1, 1.5 or 2 stop bits.
    """

    baudrate: int = 9600
    bytesize: int = 8
    parity: Parity = "N"
    stopbits: float = 1

    def __post_init__(self) -> None:
        if type(self.baudrate) is not int or not 1 <= self.baudrate <= FASTEST_BAUD:
            raise _invalid(
                what="baud rate", given=self.baudrate, expected=f"a whole number from 1 to {FASTEST_BAUD}, e.g. 9600"
            )
        if type(self.bytesize) is not int or self.bytesize not in BITS:
            raise _invalid(what="number of data bits", given=self.bytesize, expected="5, 6, 7 or 8")
        if self.parity not in get_args(Parity):
            raise _invalid(what="parity", given=self.parity, expected="one of N, E, O, M, S")
        if self.stopbits not in STOP_BITS:
            raise _invalid(what="number of stop bits", given=self.stopbits, expected="1, 1.5 or 2")

    def __str__(self) -> str:
        return f"{self.baudrate} {self.bytesize}{self.parity}{self.stopbits:g}"

    @cached_property
    def bit_ns(self) -> Fraction:
        """Exact duration of one bit in ns."""
        return Fraction(S, self.baudrate)

    @cached_property
    def frame_ns(self) -> int:
        """Duration of a whole character, from start bit to last stop bit."""
        return round((1 + self.bytesize + (self.parity != "N") + Fraction(self.stopbits)) * self.bit_ns)

    @cached_property
    def receive_ns(self) -> int:
        """Time from the falling edge of the start bit to the end of the first stop bit."""
        return round((2 + self.bytesize + (self.parity != "N")) * self.bit_ns)

    @cached_property
    def shape(self) -> tuple[int, int, str]:
        """Baud rate, number of data bits and parity.  Sender and receiver must use the same values."""
        return self.baudrate, self.bytesize, self.parity

    def parity_bit(self, byte: int) -> bool:
        if self.parity in "MS":
            return self.parity == "M"
        odd = byte.bit_count() % 2 == 1
        return odd if self.parity == "E" else not odd

    def frame(self, byte: int, flipped: int = 0) -> tuple[bool, ...]:
        """Return the levels of start, data and parity bits; data bits in `flipped` are inverted, the parity is not."""
        byte &= (1 << self.bytesize) - 1
        data = tuple(bool((byte ^ flipped) >> bit & 1) for bit in range(self.bytesize))
        return (SPACE, *data) if self.parity == "N" else (SPACE, *data, self.parity_bit(byte))

    def spaces(self, byte: int, flipped: int = 0) -> tuple[tuple[int, int], ...]:
        """Return the runs of space in the frame of `byte`: first bit of each run, and first bit after the run."""
        return _spaces(self.bytesize, self.parity, byte, flipped)

    @cached_property
    def samples(self) -> int:
        """Number of bits that a receiver reads in each character: start bit, data bits, parity bit, first stop bit."""
        return 2 + self.bytesize + (self.parity != "N")

    def decode(self, level_at: Callable[[Fraction], bool]) -> tuple[int, LineError] | None:
        """Return byte and errors as received; None: a false start.  `level_at`: level in ns after the falling edge."""
        middles = [(bit + Fraction(1, 2)) * self.bit_ns for bit in range(self.samples)]
        if level_at(middles[0]) is MARK:
            return None
        return self.read(sum(level_at(middle) << bit for bit, middle in enumerate(middles)))

    def read(self, levels: int) -> tuple[int, LineError]:
        """Return byte and errors.  `levels`: one sample in the middle of each bit, the start bit as bit 0."""
        byte = levels >> 1 & ((1 << self.bytesize) - 1)
        wrong_parity = self.parity != "N" and bool(levels >> 1 + self.bytesize & 1) is not self.parity_bit(byte)
        no_stop_bit = not levels >> self.samples - 1
        return byte, _FOUND[wrong_parity, no_stop_bit, not levels]


_FOUND = {
    (parity, framing, low): LineError(parity | framing << 1 | low << 2)
    for parity, framing, low in product((False, True), repeat=3)
}
"""Line errors by (parity, framing, break); a table, because combining flags is slow in the inner loop."""


def _invalid(what: str, given: object, expected: str) -> UsageError:
    huge = isinstance(given, int) and given.bit_length() > 64
    shown = "of more than 64 binary digits" if huge else repr(given)[:40]
    return UsageError(f"invalid {what} {shown}: expected {expected}")


@lru_cache(maxsize=4096)
def _spaces(bytesize: int, parity: Parity, byte: int, flipped: int) -> tuple[tuple[int, int], ...]:
    levels = (MARK, *UartFormat(bytesize=bytesize, parity=parity).frame(byte, flipped), MARK)
    edges = [bit for bit, (before, level) in enumerate(pairwise(levels)) if level is not before]
    return tuple(zip(edges[::2], edges[1::2], strict=True))


@dataclass(slots=True)
class Frame:
    """A signal on a wire from `start_ns` on: spaces between bits of `bit/per` ns; otherwise the wire is at mark."""

    start_ns: int
    spaces: tuple[tuple[int, int], ...]
    bit: int
    per: int
    sent: tuple[UartFormat, int] | None = None  # An undisturbed character; None for any other signal.
    own: bool = False  # True for a frame of the receiver's own transmitter on a pair, which it ignores.

    @classmethod
    def of(cls, start_ns: int, sent: UartFormat, byte: int, flipped: int = 0, *, own: bool = False) -> "Frame":
        """Return the frame of a character; `flipped` data bits are inverted."""
        intact = None if flipped else (sent, byte & (1 << sent.bytesize) - 1)
        return cls(start_ns, sent.spaces(byte, flipped), S, sent.baudrate, intact, own)

    @classmethod
    def held(cls, start_ns: int, duration_ns: int, *, own: bool = False) -> "Frame":
        """Return a signal that holds the wire low (space, logic 0) for `duration_ns`."""
        return cls(start_ns, ((0, 1),), duration_ns, 1, own=own)

    @property
    def end(self) -> int:
        """End of the frame's last space, in units of 1/`per` ns."""
        return self.start_ns * self.per + self.spaces[-1][1] * self.bit


class Break(NamedTuple):
    """A break: the wire is low (space, logic 0) for longer than a character."""

    duration_ns: int
