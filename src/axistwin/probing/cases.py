"""Cases of a probe: what is sent, the section of the manual, and if the case can move something."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module

from axistwin.bench import FAMILIES
from axistwin.controllers.product import Product
from axistwin.probing.ends import End


@dataclass(frozen=True)
class Case:
    """One case: requests that are sent one after the other; their answers together are compared."""

    name: str
    section: str
    says: tuple[bytes, ...]
    moves: bool = False
    """True if the case can move something: a motor, an output, a position counter."""
    writes: bool = False
    """True if the case changes a setting."""
    depends: bool = False
    """True if the answer depends on the machine or on earlier settings; then a different value is no difference."""
    wait_s: float = 0.0
    """Time for the effect of each request."""
    timed: bool = True
    """False if the time of the answer depends on the machine."""


@dataclass
class Condition:
    """Condition of the controller at the beginning."""

    facts: dict[str, str] = field(default_factory=dict)
    """Facts for the report: firmware, part number."""
    no_writes: str = ""
    """Reason why settings must not be changed; empty: they can be changed."""
    no_motion: str = ""
    """Reason why nothing may be moved; empty: motion is possible."""


@dataclass(frozen=True)
class Dialect:
    """The family's part of a probe."""

    cases: Callable[[Product, str], list[Case]]
    """Returns the cases; the text is `Condition.facts["terminator"]`, or empty."""
    examine: Callable[[End, Product], Condition]
    """Brings the controller into a known state without motion.  Raises LinkError if it does not answer."""
    first: bytes
    """Request whose answer shows if the port keeps real time."""
    answer_form: Callable[[bytes], bytes]
    """Returns an answer without its values."""
    initialise: Callable[[End], None] = lambda end: None
    """Brings a new twin into the state in which it answers."""
    patience_s: float = 0.0
    """Longest time for which the controller can hold back an answer."""
    definitions: tuple[int, ...] = ()
    """First bytes of answers that exist only if something has been defined."""
    candidates: Callable[[Mapping[str, bytes]], dict[str, list[object]]] = lambda answers: {}
    """Returns values of options that the answers suggest."""


def dialect(product: Product) -> Dialect:
    """Return the family's part of a probe."""
    found: Dialect = import_module(f"axistwin.probing.{FAMILIES[product.model]}").DIALECT
    return found


def around(low: int | None, high: int | None) -> dict[str, int]:
    """Return the values at the ends of a range, and the values next to them."""
    found: dict[str, int] = {}
    if low is not None:
        found |= {"lowest": low, "below the lowest": low - 1}
    if high is not None:
        found |= {"highest": high, "above the highest": high + 1}
    return found
