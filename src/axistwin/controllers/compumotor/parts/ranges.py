"""Velocity and acceleration ranges (command C8h) and base clocks (command 51h), as exact fractions.

Every clock printed in the manual is 13,107,200/3 Hz divided by a power of 10 or 16 (docs/fidelity.md).
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

CRYSTAL = Fraction(13_107_200, 3)
BASE_CLOCKS = {
    1: CRYSTAL, 2: CRYSTAL / 10, 3: CRYSTAL / 100, 4: CRYSTAL / 1000, 5: CRYSTAL / 10_000,
    6: CRYSTAL / 16, 7: CRYSTAL / 256, 8: CRYSTAL / 4096, 9: CRYSTAL / 65_536,
}  # fmt: skip
"""Base clocks in Hz, by the code that 51h to 53h use."""

FULL = 65_536  # Streamed velocity number that would equal the effective clock; the highest velocity is half the clock.


@dataclass(frozen=True)
class VelocityRange:
    """A velocity range.  `unit`: pulses/s for velocity number 1; `clock`: the effective clock in Hz."""

    unit: Fraction
    clock: Fraction

    @cached_property
    def resolution(self) -> Fraction:
        """Smallest difference between two step rates of this velocity range, in pulses/s."""
        return self.clock / FULL

    @cached_property
    def maximum(self) -> Fraction:
        """Maximum step rate of the velocity range in pulses/s."""
        return self.clock / 2

    def rate(self, number: int) -> Fraction | None:
        """Return the pulse rate of a velocity number, rounded to the resolution; None beyond the range."""
        if number > self.highest:
            return None
        return ((2 * number * self.unit + self.resolution) // (2 * self.resolution)) * self.resolution

    @cached_property
    def highest(self) -> int:
        """Highest velocity number, which is the maximum rounded: 1,092,267 for 1,092,266.67."""
        return self.number(self.maximum)

    def number(self, rate: Fraction) -> int:
        """Return the velocity number nearest to a rate in pulses/s."""
        return round(rate / self.unit)


VELOCITY_RANGES = (
    VelocityRange(Fraction(1), BASE_CLOCKS[1] / 4),
    VelocityRange(Fraction(1, 10), BASE_CLOCKS[2] / 4),
    VelocityRange(Fraction(1, 100), BASE_CLOCKS[3] / 4),
    VelocityRange(Fraction(1, 1000), BASE_CLOCKS[4] / 4),
    VelocityRange(Fraction(1, 60), BASE_CLOCKS[6] / 15),
    VelocityRange(Fraction(1), BASE_CLOCKS[1] / 2),
)
ACCELERATION_RANGES = (Fraction(1), Fraction(1, 10), Fraction(1, 100))  # Velocity units/s for the number 1.


def acceleration(ranges: tuple[int, int], number: int) -> Fraction:
    """Return the acceleration in pulses/s² for an acceleration number."""
    velocity, per_second = ranges
    return number * VELOCITY_RANGES[velocity].unit * ACCELERATION_RANGES[per_second]
