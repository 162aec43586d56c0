"""Cases of a probe: the requests, the section of the manual, and a mark for cases that can move a motor."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module

from axistwin.bench import Controller
from axistwin.controllers.product import Product
from axistwin.controllers.registry import OURS
from axistwin.core.errors import UsageError
from axistwin.real.hosts.end import End


@dataclass(frozen=True)
class Case:
    """One comparison of a probe: requests that are sent in order, whose answers are compared with those of a twin."""

    name: str
    section: str
    says: tuple[bytes, ...]
    moves: bool = False  # True if the case can change a motor's position, an output or a position counter.
    writes: bool = False  # True if the case changes a setting.
    depends: bool = field(default=False, compare=False)
    """True if the answer depends on the machine or on earlier settings; its value is then not compared.

    Within the case, requests to which the twin gives the same answer must still have the same answer.
    """
    form: bool = False  # True if only the form of the answer is compared, because its value changes without a command.
    wait_s: float = 0.0  # Seconds to wait for the effect of each request.
    timed: bool = True  # False if the time of the answer depends on the machine.
    stores: bool = False  # True if it needs programs or data in nonvolatile memory, which the probe restores.
    bare: bool = False  # True if it needs a controller without machine: it follows inputs, or changes brakes.
    plug: bool = False  # True if the case needs the test plug, which connects outputs to inputs.
    waits: tuple[tuple[int, float], ...] = ()  # By number of the request from 0: seconds to wait, not `wait_s`.

    def wait(self, number: int, otherwise: float) -> float:
        return dict(self.waits).get(number, otherwise)


@dataclass
class Condition:
    """State at the start.  `no_writes`, `no_motion`, `no_memory`, `machine`: why some cases are impossible."""

    facts: dict[str, str] = field(default_factory=dict)  # Facts for the report: firmware, part number.
    no_writes: str = ""  # Reason why the probe must not change settings; "" if the probe may change settings.
    no_motion: str = ""  # Reason why the probe must not move the motors; "" if motion is possible.
    no_memory: str = ""  # Reason why the probe must not write nonvolatile memory; "" if it may write and restore it.
    machine: str = ""  # Reason why neither motion nor programs are possible, except with `as_new`.
    saved: list[bytes] = field(default_factory=list)  # Requests that restore what the probe has saved.


@dataclass(frozen=True)
class Dialect:
    """Functions and data with which `axistwin probe` tests one family."""

    cases: Callable[[Product, Mapping[str, str]], list[Case]]
    """Function that returns the cases for a product; its second argument is the facts of the controller and `line`."""
    examine: Callable[[End, Product], Condition]  # Sets a known state without motion.  Raises LinkError if silent.
    first: Callable[[Mapping[str, str]], bytes]  # A request by the facts, to see if the port keeps real time.
    answer_form: Callable[[bytes, bytes], bytes]  # The form of an answer to a request, without its values.
    equip: Callable[[Controller, Mapping[str, str]], None] = lambda controller, facts: None
    """Function that gives a new twin the wiring that the facts of the controller show."""
    save: Callable[[End, Condition], None] = lambda end, condition: None  # Before the cases, into `condition.saved`.
    restore: Callable[[End, Condition], str] = lambda end, condition: ""  # Of what `save` has read; an error, or "".
    initialise: Callable[[End, Mapping[str, str]], None] = lambda end, facts: None
    """Function that brings a new twin into the state in which it answers in the controller's data format."""
    patience_s: float = 0.0  # Longest time for which the controller can hold back an answer.
    definitions: tuple[int, ...] = ()  # First bytes of answers that exist only if moves or sequences are defined.
    candidates: Callable[[Mapping[str, bytes]], dict[str, list[object]]] = lambda answers: {}
    """Function that returns the values of options that the answers suggest; the answers of each case are joined."""


def connect(controller: Controller, output: str, *inputs: str) -> None:
    pins = controller.pins
    source = pins[output]

    def follow(_: object) -> None:
        for name in inputs:
            pins[name].drive(source.level)

    source.subscribe(follow)
    follow(source)


def dialect(product: Product) -> Dialect:
    if product.model not in OURS:
        raise UsageError(
            f"there are no cases for {product.model}: expected one of {', '.join(OURS)}; "
            "compare it by `axistwin record` and `axistwin replay`"
        )
    found: Dialect = import_module(f"axistwin.real.probing.{product.family}").DIALECT
    return found


def around(low: int | None, high: int | None) -> dict[str, int]:
    """Return test values by description: both ends of a range, and the values just inside and outside."""
    found: dict[str, int] = {}
    if low is not None:
        found |= {"lowest": low, "below the lowest": low - 1}
    if high is not None:
        found |= {"highest": high, "above the highest": high + 1}
    return found
