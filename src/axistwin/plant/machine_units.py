"""Units of the machine: positions of an axis in millimetres, degrees or revolutions.

The position of an axis is always a whole number of motor pulses or encoder counts.  A position in another unit is
rounded to the nearest count once, when it is read; the number of counts per unit is an exact fraction.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, log10
from typing import Any, Self

from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, decimal, shortened, whole

EXAMPLE = '{ per = 80, of = "mm" }'
_PER = re.compile(r"([0-9.]+(?:e[-+]?[0-9]+)?)(?:/([0-9.]+))?")
_OF = re.compile(r"[^\W\d_]{1,12}|°")
_RESERVED = ("up", "down")  # Words that follow a position in the sentences of triggers.
_QUANTITY = re.compile(r"\s*(?P<number>-?[0-9.]+)\s*(?P<of>[^\W\d_]+|°)?(?P<per_second>/s)?\s*")
_LEAST, _MOST = Fraction(1, 10**9), Fraction(10**12)
MOST_DECIMALS = 9
MOST_POSITION = 1 << 53  # Maximum distance of a switch or a trigger from position 0, in pulses or counts.


@dataclass(frozen=True)
class MachineUnits:
    """The unit of an axis: `per` pulses or counts are one unit `of`."""

    per: Fraction
    of: str

    @classmethod
    def given(cls, table: Any) -> Self:
        """Read `{ per = 80, of = "mm" }`: 80 pulses per mm.  Raises UsageError for an invalid table."""
        if not isinstance(table, Mapping) or set(table) != {"per", "of"}:
            raise UsageError(
                f"invalid units {table!r}: expected a table with the keys `per` and `of`, "
                f"e.g. {EXAMPLE} for 80 counts per mm"
            )
        return cls(check_per(table["per"]), check_of(table["of"]))

    @classmethod
    def written(cls, text: str) -> Self:
        """Parse the text form of units, e.g. `80 per mm`.  Raises UsageError for an invalid text."""
        per, _, of = text.partition(" per ")
        return cls(check_per(per), check_of(of))

    def __str__(self) -> str:
        return f"{self.per} per {self.of}"

    def value(self, counts: float) -> float:
        return float(Fraction(counts) / self.per)

    def shown(self, counts: float) -> str:
        """Convert counts to text in the axis's unit, with as many decimals as one count needs."""
        return f"{self.value(counts):.{self.decimals}f}"

    @property
    def decimals(self) -> int:
        """Number of decimals that is needed to distinguish two neighbouring positions, at most `MOST_DECIMALS`."""
        return min(max(ceil(log10(self.per)), 0), MOST_DECIMALS)


def check_per(given: Any) -> Fraction:
    """Parse a number of counts per unit, e.g. 80, 6.4 or "6400/360".  Raises UsageError if the number is invalid."""
    parts = _PER.fullmatch(str(given)) if type(given) in (int, float, str) else None
    try:
        if parts is not None and decimal(parts[1]) > 0 and decimal(parts[2] or "1") > 0:
            per = Fraction(decimal(parts[1])) / Fraction(decimal(parts[2] or "1"))
            if _LEAST <= per <= _MOST:
                return per
    except NumberError:
        pass
    raise UsageError('invalid number of pulses or counts per unit: expected e.g. 80, 6.4 or "6400/360"')


def check_of(given: Any) -> str:
    """Check the name of a unit, e.g. "mm", and return this name.  Raises UsageError if the name is invalid."""
    if not isinstance(given, str) or not _OF.fullmatch(given) or given in _RESERVED:
        raise UsageError('invalid name of a unit: expected 1 to 12 letters (not "up" or "down"), e.g. "mm"')
    return given


def position(given: int | str, units: MachineUnits | None) -> int:
    """Convert a position, e.g. 1000 or "12.5 mm", to counts.  Raises UsageError."""
    if type(given) is int:
        return given
    found = _QUANTITY.fullmatch(given) if isinstance(given, str) and len(given) < 100 else None
    if found is None or found["per_second"]:
        raise UsageError(f"{shortened(str(given))} is not a position: expected e.g. {_example_position(units)}")
    if found["of"] is None:
        try:
            return whole(found["number"], -MOST_POSITION, MOST_POSITION)
        except NumberError:
            raise UsageError(f"invalid number of counts {given!r}: expected e.g. {_example_position(units)}") from None
    counts = round(_quantity(found["number"], found["of"], units))
    if abs(counts) > MOST_POSITION:
        raise UsageError(f"position {given} is out of range: expected {-MOST_POSITION} to {MOST_POSITION} counts")
    return counts


def rate(given: float | str, units: MachineUnits | None) -> float:
    """Convert a velocity, e.g. 2000 (counts/s) or "50 mm/s", to counts/s."""
    if isinstance(given, int | float):
        return float(given)
    found = _QUANTITY.fullmatch(given) if len(given) < 100 else None
    if found is None or not found["of"] or not found["per_second"]:
        unit = units.of if units else "mm"
        raise UsageError(
            f"{shortened(given)} is not a velocity: expected a number of counts/s, or a text, e.g. '50 {unit}/s'"
        )
    return float(_quantity(found["number"], found["of"], units))


def _quantity(number: str, unit: str, units: MachineUnits | None) -> Fraction:
    given_unit = shortened(unit)
    if units is None:
        of = unit if _OF.fullmatch(unit) else "mm"
        raise UsageError(
            f"unknown unit {given_unit}: use counts, or define the unit of the axis, "
            f'e.g. units = {{ per = 80, of = "{of}" }}'
        )
    if unit != (axis_unit := units.of):
        raise UsageError(f"{given_unit} is not the unit of the axis: expected {axis_unit}")
    try:
        return Fraction(decimal(number)) * units.per
    except NumberError:
        raise UsageError(
            f"invalid number {shortened(number)}: expected a decimal number below 1e30, e.g. 12.5"
        ) from None


def _example_position(units: MachineUnits | None) -> str:
    return f"1000 or '12.5 {units.of}'" if units is not None else "1000"
