"""A simple reference receiver: it stores all signals of a wire and reads them bit by bit, in an exact fraction of a
nanosecond that divides all bits.

It is slow and simple; `axistwin.sim.serial` must give the same characters at the same nanoseconds.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import lcm

from axistwin.sim.frames import LineError


@dataclass(frozen=True)
class Sent:
    """Levels of equal bits from `start_ns` on, then mark; `own`: sent by the receiver's own transmitter."""

    start_ns: int
    levels: tuple[bool, ...]
    bit_ns: Fraction
    own: bool = False

    def spaces(self, per_ns, cut_ns=None):
        """Return the begin and end of each maximal run of low bits, in parts of a nanosecond."""
        bounds, begin, bit_time = [], None, int(self.bit_ns * per_ns)
        for bit, level in enumerate((*self.levels, True)):
            time = self.start_ns * per_ns + bit * bit_time
            if not level and begin is None:
                begin = time
            if level and begin is not None:
                bounds.append((begin, time))
                begin = None
        if cut_ns is not None:
            bounds = [(begin, min(end, cut_ns * per_ns)) for begin, end in bounds if begin < cut_ns * per_ns]
        return bounds


def character(start_ns, fmt, byte, *, flipped=0, own=False):
    """Return the signal of a character in this format; `flipped` data bits are inverted."""
    bits = [byte >> bit & 1 for bit in range(fmt.bytesize)]
    parity = {"N": [], "M": [1], "S": [0], "E": [sum(bits) % 2], "O": [1 - sum(bits) % 2]}[fmt.parity]
    seen = [bit ^ (flipped >> number & 1) for number, bit in enumerate(bits)]
    levels = tuple(bool(level) for level in (0, *seen, *parity))
    return Sent(start_ns, levels, Fraction(10**9, fmt.baudrate), own)


def held(start_ns, duration_ns, *, own=False):
    return Sent(start_ns, (False,), Fraction(duration_ns), own)


def receive(sent, fmt, cut_ns=None, *, resynchronises=False):
    """Return all (time in ns, byte, errors) that a receiver in this format finds; from `cut_ns` on the wire is open.

    `resynchronises`: after a framing error it looks for a start bit from the middle of the last data or parity bit on.
    """
    bit_ns = Fraction(10**9, fmt.baudrate)
    per_ns = 2 * lcm(bit_ns.denominator, *(one.bit_ns.denominator for one in sent))
    bit, found, idle_from = int(bit_ns * per_ns), [], 0
    of_each = [(one.own, one.spaces(per_ns, cut_ns)) for one in sent]
    spaces = [space for _, of_one in of_each for space in of_one]
    edges = sorted({begin for own, of_one in of_each if not own for begin, _ in of_one})
    falls = [edge for edge in edges if not any(begin < edge < end for begin, end in spaces)]

    def level(time):
        return not any(begin <= time < end for begin, end in spaces)

    for edge in falls:
        if edge < idle_from:
            continue
        if level(edge + bit // 2):
            idle_from = edge + bit // 2  # this was a false start
            continue
        count = 2 + fmt.bytesize + (fmt.parity != "N")
        levels = [level(edge + bit // 2 + number * bit) for number in range(count)]
        receive_ns = round(count * bit_ns)
        found.append((edge // per_ns + receive_ns, *decode(levels, fmt)))
        idle_from = edge + receive_ns * per_ns - bit // 2
        if resynchronises and LineError.FRAMING in found[-1][2]:
            idle_from -= bit
    return found


def decode(levels, fmt):
    bits = levels[1 : 1 + fmt.bytesize]
    errors, ones = LineError.NONE, sum(bits)
    right = {"E": ones % 2 == 1, "O": ones % 2 == 0, "M": True, "S": False}
    if fmt.parity != "N" and levels[1 + fmt.bytesize] is not right[fmt.parity]:
        errors |= LineError.PARITY
    if not levels[-1]:
        errors |= LineError.FRAMING | (LineError.NONE if any(levels) else LineError.BREAK)
    return sum(bit << number for number, bit in enumerate(bits)), errors
