"""The base class of a controller of one's own."""

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from axistwin.controllers.front import Status
from axistwin.controllers.patterns import Refused
from axistwin.controllers.product import Awaited
from axistwin.core.units import to_ns, to_seconds
from axistwin.devices.framing import Framing, Lines, Request
from axistwin.plant.positioner import Positioner
from axistwin.sim.clock import Clock, Event, Procedure, Process, kill


@dataclass(frozen=True)
class Input:
    """A digital input; `level` without anything connected."""

    level: bool = False


@dataclass(frozen=True)
class Output:
    """A digital output; `level` at power-on and without power."""

    level: bool = False


def register(bits: Mapping[int, str] | None = None, *, section: str = "", restless: bool = False) -> Any:
    """Make a method a register: a number or text that can be read without effect, traced and shown on the panel.

    `bits`: what each bit means.  `restless`: the value also changes between events, as a position does in motion.
    """

    def mark(method: Callable[..., Any]) -> Callable[..., Any]:
        text = method.__annotations__.get("return") in (str, "str")
        method.__dict__["status"] = Status(bits or {}, section, restless, text)
        return method

    return mark


class Device:
    """A controller of one's own: a subclass has its figures as class attributes and its commands as methods.

    An object of it exists while the power is on, so what `start` and the handlers assign is lost without power; only
    `memory`, as last saved, is kept.  Do not override `__init__`.
    """

    model: ClassVar[str]  #: The name for `Bench.add`, scenes and the command line.
    title: ClassVar[str] = ""  #: What lists and the panel call it.
    line: ClassVar[str] = "9600 8N1"  #: The usual format of the serial line.
    framing: ClassVar[Framing] = Lines()  #: Lines or Datagrams.
    axes: Mapping[str, Positioner] = {}  #: By name; the objects of one class share nothing.
    pins: Mapping[str, Any] = {}  #: In the class Input and Output by name, in an object the terminals themselves.
    options: Mapping[str, Any] = {}  #: In the class Option by name, in an object the values.
    memory: dict[str, Any] = {}  # noqa: RUF012
    """In the class the factory settings, in an object what was saved."""
    faults: ClassVar[tuple[str, ...]] = ()  #: Names of the faults that `fault` reports.
    driver: ClassVar[Any] = None  #: How a host moves and asks: an `axistwin.drivers.TextDriver`, or a protocol core.
    answer_after: ClassVar[float] = 0.0  #: Seconds from the end of a request to its answer.

    clock: Clock
    send: Callable[[Any], None]
    """Send at once what no request has asked for: text or a number with its terminator, bytes, fields of a datagram."""
    save: Callable[[], None]
    """Store `memory`, which then survives a loss of power.  Numbers, texts, lists and dictionaries can be stored."""
    fault: Callable[[str], None]
    """Report a fault by its name in `faults` to whoever observes the controller."""
    begin: Callable[[Generator[Event, Any, Any]], Process]
    """Begin a procedure that runs beside everything else, until it ends, `end` is called with it, or the power ends."""
    end: Callable[[Process], None] = staticmethod(kill)
    awaited: Awaited | None = None

    def start(self) -> Any:
        """Do what the device does at power-on; a generator takes time, and no request is read before its end."""

    def answer(self, result: Any, request: Request) -> Any:  # noqa: ARG002
        """Return what is sent for the result of a handler, e.g. the fields of a datagram; None: nothing."""
        return result

    def refused(self, reason: Refused, data: bytes) -> Any:  # noqa: ARG002
        """Return the answer to a request that is not carried out; by default there is none, and nothing happens."""
        return None

    def pin_changed(self, name: str, level: bool) -> Any:
        """Act on a change of an input; a generator is begun as a procedure."""

    def limit_reached(self, axis: str, side: int) -> Any:
        """Act, as `pin_changed`, on a stop by a limit switch, `side` -1 or +1, or by the following error, 0."""

    def hint(self) -> str:
        """Return why nothing moves, and the remedy; "" if it can."""
        for name, axis in self.axes.items():
            if axis.stopped_by in ("minus limit", "plus limit"):
                back = "plus" if axis.stopped_by == "minus limit" else "minus"
                return f"axis {name} stands at its {axis.stopped_by}: move it in the {back} direction"
        return ""

    @property
    def now(self) -> float:
        """Seconds of virtual time."""
        return to_seconds(self.clock.now)

    def after(self, seconds: float) -> Event:
        """Return the event of a time from now on, for `yield`."""
        return self.clock.timeout(to_ns(max(seconds, 0.0)))

    def until(self, pin: str, level: bool = True) -> Procedure:
        """Wait for the level of an input, for `yield from`; the panel says what the device waits for."""
        while self.pins[pin].level is not level:
            self.awaited = Awaited("the procedure", pin, "high" if level else "low")
            yield self.pins[pin].changed()
        self.awaited = None
