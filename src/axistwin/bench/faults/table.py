"""Types for the table of faults: kinds, affected parts, and parameters with units and ranges."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from axistwin.bench.faults.places import Spot
from axistwin.core.errors import UsageError
from axistwin.core.numbers import NumberError, real, shortened, whole
from axistwin.sim.clock import Clock

LEVELS = {"high": True, "on": True, "low": False, "off": False}


class On(Enum):
    """The type of part that a fault affects; the value of each member has examples of names."""

    LINE = "if1.serial, motor.rs485, chain"
    PIN = "if1.input1"
    AXIS = "if1.X"
    CONTROLLER = "if1"


class Sort(Enum):
    """Data type of a parameter of a fault, e.g. a whole number."""

    WHOLE = "a whole number"
    NUMBER = "a number"
    LEVEL = "high or low"
    WORD = "a word"


@dataclass(frozen=True)
class Parameter:
    """A parameter of a fault; the user must give one that has no `default` and is not `optional`."""

    name: str
    sort: Sort
    doc: str
    unit: str = ""
    default: Any = None
    optional: bool = False
    low: float | None = None
    high: float | None = None
    words: tuple[str, ...] = ()

    def read(self, value: object) -> Any:
        """Convert a value to the parameter's type.  Raises UsageError, which gives the valid values."""
        found = self._read(value.strip() if isinstance(value, str) else value)
        if found is None or not self._within(found):
            given = shortened(value) if isinstance(value, str) else repr(value)
            raise UsageError(f"invalid value {self.name}={given}: expected {self.wanted}")
        return found

    @property
    def wanted(self) -> str:
        if self.words:
            return " or ".join(self.words)
        what = self.sort.value + (f" of {self.unit}" if self.unit else "")
        if self.low is not None and self.high is not None:
            return f"{what} from {self.low:g} to {self.high:g}"
        return what if self.low is None else f"{what}, {self.low:g} or more"

    def _read(self, value: object) -> Any:
        match self.sort:
            case Sort.LEVEL:
                return LEVELS.get(value) if isinstance(value, str) else value if isinstance(value, bool) else None
            case Sort.WORD:
                return value if value in self.words else None
            case Sort.WHOLE:
                return _whole(value)
        return _number(value)

    def _within(self, value: Any) -> bool:
        if self.low is not None and not value >= self.low:
            return False
        return self.high is None or bool(value <= self.high)


def _whole(value: object) -> int | None:
    if isinstance(value, str):
        try:
            return whole(value, base=0)
        except NumberError:
            return None
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        number = real(value) if isinstance(value, str) else float(value)
    except (NumberError, OverflowError):
        return None
    return number if abs(number) < float("inf") else None


_MASK = (1 << 64) - 1
_STEP = 0x9E3779B97F4A7C15


class Chance:
    """Reproducible pseudo-random numbers by the algorithm splitmix64; the seed, 0 or more, determines the sequence."""

    def __init__(self, seed: int) -> None:
        self._state = seed & _MASK

    def bits(self) -> int:
        self._state = (self._state + _STEP) & _MASK
        mixed = self._state
        mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9 & _MASK
        mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EB & _MASK
        return mixed ^ (mixed >> 31)

    def unit(self) -> float:
        """Return a random number, at least 0 and less than 1."""
        return (self.bits() >> 11) / (1 << 53)

    def below(self, most: int) -> int:
        """Return a random integer from 0 to `most` - 1."""
        return self.bits() % most


@dataclass(frozen=True)
class Case:
    """Arguments of the function that begins a fault; the fault calls `over` to report its end."""

    clock: Clock
    spot: Spot
    values: Mapping[str, Any]
    chance: Chance | None
    lasts: bool  # True if the fault has a duration.
    over: Callable[[], None]
    others: Callable[[], Iterable[tuple[str, Mapping[str, Any]]]]
    """Returns the kinds and values of all other active faults on the same part of the bench."""

    def luck(self, random_effect: str) -> Chance:
        """Return the random number generator of the fault.  Raises UsageError for a fault without a seed."""
        if self.chance is None:
            raise UsageError(f"{random_effect} is random: expected a seed, e.g. seed=1")
        return self.chance


Mend = Callable[[], None]  # Ends a fault.


def ended() -> None:
    """Do nothing at the end of a fault that has only a momentary effect, e.g. `push`."""


def all_of(ends: Iterable[Mend]) -> Mend:
    """Return a function that ends all effects of a fault.  `ends`: functions that end one effect each."""

    def mend() -> None:
        for end in ends:
            end()

    return mend


@dataclass(frozen=True)
class Kind:
    """One kind of fault.  `begin` starts the fault and returns a function that ends it; `at_once`: it ends at once."""

    name: str
    on: On
    doc: str
    begin: Callable[[Case], Mend]
    parameters: tuple[Parameter, ...] = ()
    at_once: bool = False
    check: Callable[[Spot], None] = lambda spot: None  # Raises UsageError if the fault cannot affect a part.

    def read(self, given: Mapping[str, object]) -> dict[str, Any]:
        """Return the values of a fault's parameters.  Raises UsageError for a wrong name or value."""
        known = {parameter.name: parameter for parameter in self.parameters}
        for name in given:
            if name not in known:
                parameters = " or ".join(known) or "no parameters"
                raise UsageError(f"fault {self.name} has no parameter {name!r}: expected {parameters}")
        for parameter in self.parameters:
            if parameter.default is None and not parameter.optional and parameter.name not in given:
                raise UsageError(f"fault {self.name} needs the parameter {parameter.name}: expected {parameter.wanted}")
        return {name: p.read(given[name]) if name in given else p.default for name, p in known.items()}
