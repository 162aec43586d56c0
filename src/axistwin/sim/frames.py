"""Characters as frames of bits: a format, and what a receiver in that format makes of the levels on the wire.

idle ──┐     ┌──┬──┬──┬──┬──┬──┬──┬──┬──┐╌╌╌ idle or next start bit
       │start│b0│b1│b2│b3│b4│b5│b6│b7│par│stop
       └─────┴──┴──┴──┴──┴──┴──┴──┴──┴──┘
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Flag
from fractions import Fraction
from functools import cached_property
from typing import Literal

from axistwin.units import S

Parity = Literal["N", "E", "O", "M", "S"]
MARK, SPACE = True, False


class LineError(Flag):
    """What a receiver finds wrong with a character."""

    NONE = 0
    PARITY = 1
    FRAMING = 2
    BREAK = 4


SOUND = LineError.NONE
"""Said of every character that comes through; looking it up in the enumeration takes longer than the rest."""


@dataclass(frozen=True)
class UartFormat:
    """How characters are framed.  Parity in pyserial's letters: none, even, odd, mark, space."""

    baudrate: int = 9600
    bytesize: int = 8
    parity: Parity = "N"
    stopbits: float = 1

    def __str__(self) -> str:
        return f"{self.baudrate} {self.bytesize}{self.parity}{self.stopbits:g}"

    @cached_property
    def bit_ns(self) -> Fraction:
        """One bit, exactly."""
        return Fraction(S, self.baudrate)

    @cached_property
    def frame_ns(self) -> int:
        """A whole character, from start bit to last stop bit."""
        return round((1 + self.bytesize + (self.parity != "N") + Fraction(self.stopbits)) * self.bit_ns)

    @cached_property
    def receive_ns(self) -> int:
        """From the falling edge of the start bit to the end of the first stop bit."""
        return round((2 + self.bytesize + (self.parity != "N")) * self.bit_ns)

    @cached_property
    def shape(self) -> tuple[int, int, str]:
        """What both ends must have in common to understand each other."""
        return self.baudrate, self.bytesize, self.parity

    def parity_bit(self, byte: int) -> bool:
        """The level of the parity bit of `byte`."""
        if self.parity in "MS":
            return self.parity == "M"
        odd = byte.bit_count() % 2 == 1
        return odd if self.parity == "E" else not odd

    def frame(self, byte: int, flipped: int = 0) -> tuple[bool, ...]:
        """Levels of start, data and parity bits; `flipped` data bits are disturbed on the way, after the parity."""
        byte &= (1 << self.bytesize) - 1
        data = tuple(bool((byte ^ flipped) >> bit & 1) for bit in range(self.bytesize))
        return (SPACE, *data) if self.parity == "N" else (SPACE, *data, self.parity_bit(byte))

    def decode(self, level_at: Callable[[Fraction], bool]) -> tuple[int, LineError] | None:
        """What a receiver in this format reads; `level_at(time since the falling edge)`.  None: a false start."""
        middles = [(bit + Fraction(1, 2)) * self.bit_ns for bit in range(3 + self.bytesize)]
        if level_at(middles[0]) is MARK:
            return None
        byte = sum(level_at(middles[1 + bit]) << bit for bit in range(self.bytesize))
        errors = LineError.NONE
        stop = middles[1 + self.bytesize]
        if self.parity != "N":
            if level_at(stop) is not self.parity_bit(byte):
                errors |= LineError.PARITY
            stop = middles[2 + self.bytesize]
        if level_at(stop) is SPACE:
            errors |= LineError.FRAMING
            if byte == 0 and not any(level_at(middle) for middle in middles if middle <= stop):
                errors |= LineError.BREAK
        return byte, errors


@dataclass
class Frame:
    """Something on the wire from `start_ns` on: the levels of equal bits, then mark."""

    start_ns: int
    bits: tuple[bool, ...]
    bit_ns: Fraction
    cut_ns: int | None = None  # from here on the wire is open and reads as mark
    intact: tuple[UartFormat, int] | None = None  # what was sent, while nothing has disturbed it
    own: bool = False  # the receiver's own transmitter sends it, on a pair that both share

    @property
    def end_ns(self) -> Fraction:
        """From here on it leaves the wire at mark."""
        return self.start_ns + len(self.bits) * self.bit_ns

    def level(self, time_ns: Fraction) -> bool:
        """What is on the wire at this time."""
        if time_ns < self.start_ns or (self.cut_ns is not None and time_ns >= self.cut_ns):
            return MARK
        bit = int((time_ns - self.start_ns) / self.bit_ns)
        return self.bits[bit] if bit < len(self.bits) else MARK

    def edges(self) -> Iterator[tuple[Fraction, bool]]:
        """Each change of level in the frame: when, and to what."""
        before = MARK
        for bit, level in enumerate((*self.bits, MARK)):
            time_ns = self.start_ns + bit * self.bit_ns
            if self.cut_ns is not None and time_ns >= self.cut_ns:
                if before is SPACE:
                    yield Fraction(self.cut_ns), MARK
                return
            if level is not before:
                yield time_ns, level
                before = level


@dataclass(frozen=True)
class Break:
    """Space for longer than a character."""

    duration_ns: int
