"""The fault injector: adds faults to a bench, begins and ends them.

    bench.faults.add("lose", "if1.serial", count=3, at=1.5)
    bench.faults.add("jam", "table.X", when="table.X passes 1000", duration=0.25)
    bench.faults.mend("jam")

Module `kinds` has the kinds of faults; module `triggers` has the events that can start a fault.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import count
from typing import Any

from axistwin.bench.faults import places, triggers
from axistwin.bench.faults.kinds import PLACES, THINGS, kind_of
from axistwin.bench.faults.places import Spot, World
from axistwin.bench.faults.table import Case, Chance, Kind, Mend, On
from axistwin.core.errors import UsageError, with_article
from axistwin.core.units import to_ns, to_seconds
from axistwin.sim.manual_actions import by_itself
from axistwin.sim.signal import Signal

Listener = Callable[["Fault", str], None]  # Function that is called with a fault, and with "begins" or "ends".


class State(Enum):
    """State of a fault: waiting, active or finished."""

    WAITING = "waiting"
    ON = "on"
    OVER = "over"


@dataclass(frozen=True)
class Terms:
    """Properties that all faults have: name, begin, end and seed."""

    name: str | None = None
    at: float | None = None
    when: str | None = None
    nth: int = 1
    duration: float | None = None
    seed: int | None = None
    here: str = ""

    def __post_init__(self) -> None:
        for key, given in (("at", self.at), ("duration", self.duration)):
            if given is not None:
                _check_seconds(key, given)
        if type(self.nth) is not int or self.nth < 1:
            raise UsageError(
                f"invalid nth={self.nth!r}: expected a whole number of 1 or more, e.g. nth=3 for the third event"
            )
        if self.seed is not None and type(self.seed) is not int:
            raise UsageError(f"invalid seed={self.seed!r}: expected a whole number, e.g. 1")


class Fault:
    """One fault on a bench.  By default, a fault has the name of its kind."""

    def __init__(
        self, faults: "Faults", name: str, kind: Kind, spot: Spot, values: Mapping[str, Any], seed: int | None
    ) -> None:
        self.name, self.kind, self.spot, self.values, self.seed = name, kind, spot, values, seed
        self.state = State.WAITING
        self.began_ns: int | None = None  # Time at which the fault began; None if it has not begun.
        self._faults = faults
        self._mend: Mend | None = None
        self._unsubscribe: Callable[[], object] | None = None

    def __repr__(self) -> str:
        return f"<Fault {self.name}: {self.kind.name} of {self.spot.name}, {self.state.value}>"

    @property
    def on(self) -> bool:
        """True while the fault is active."""
        return self.state is State.ON

    def mend(self) -> None:
        """End the fault, or cancel a fault that has not begun.  A finished fault stays finished."""
        self._stop_waiting()
        if self.state is State.ON:
            if self._mend is None:  # End the fault only after the start of the fault is complete.
                self._faults.world.clock.soon(self.mend)
                return
            with by_itself(self._faults.world.clock):
                self._mend()
            self._faults.changes.emit(self, "ends")
        self.state = State.OVER

    def _begin(self, duration_ns: int | None) -> None:
        if self.state is not State.WAITING:
            return
        self._stop_waiting()
        clock = self._faults.world.clock
        chance = None if self.seed is None else Chance(self.seed)
        self.state, self.began_ns = State.ON, clock.now
        self._faults.changes.emit(self, "begins")
        lasts = duration_ns is not None
        with by_itself(clock):
            self._mend = self.kind.begin(Case(clock, self.spot, self.values, chance, lasts, self._over, self._others))
        if self.kind.at_once:
            self._over()
        elif duration_ns is not None:
            clock.call_later(duration_ns, self._elapsed)

    def _others(self) -> list[tuple[str, Mapping[str, Any]]]:
        there = (fault for fault in self._faults if fault.on and fault.spot.name == self.spot.name)
        return [(fault.kind.name, fault.values) for fault in there if fault is not self]

    def _elapsed(self) -> None:
        if self.on:
            self.mend()

    def _over(self) -> None:
        if self.on:
            self.state = State.OVER
            self._faults.changes.emit(self, "ends")

    def _stop_waiting(self) -> None:
        unsubscribe, self._unsubscribe = self._unsubscribe, None
        if unsubscribe is not None:
            unsubscribe()


class Faults:
    """All faults of a bench; a finished one stays until the user adds another of its name."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._those: dict[str, Fault] = {}
        self.announced: tuple[str, ...] = ()  # Faults that will be added later; triggers may already name them.
        self.changes: Signal[Fault, str] = Signal()

    def __iter__(self) -> Iterator[Fault]:
        return iter(tuple(self._those.values()))

    def __getitem__(self, name: str) -> Fault:
        """Return the fault with the given name.  Raises UsageError for an unknown name."""
        if name not in self._those:
            raise UsageError(f"unknown fault {name!r}: known faults are {', '.join(self.names) or 'none'}")
        return self._those[name]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all faults, oldest first."""
        return tuple(self._those)

    def add(
        self, kind: str, on: str = "", *, name: str | None = None, at: float | None = None, when: str | None = None,
        nth: int = 1, duration: float | None = None, seed: int | None = None, here: str = "", **parameters: Any,
    ) -> Fault:  # fmt: skip
        """Add a fault to a serial line, pin, axis or controller.

        The fault begins now, or as `at` and `when` specify.  `at`: seconds since the bench was created.  `when`: an
        event such as "X passes 1000" (see `triggers`); the fault begins at its `nth` occurrence after `at`.
        `duration`: seconds until the fault ends; None: until `mend`.  `seed`: for random effects.  `here`: name of the
        controller if `on` has none.  Raises UsageError.
        """
        return self.plan(kind, on, Terms(name, at, when, nth, duration, seed, here), parameters)()

    def plan(self, kind: str, on: str, terms: "Terms", parameters: Mapping[str, Any]) -> Callable[[], Fault]:
        """Check a planned fault; return a function that adds it.  Arguments and errors are those of `add`."""
        chosen = kind_of(kind)
        spot = self.spot(chosen, on, terms.here)
        chosen.check(spot)
        values = chosen.read(parameters)
        _check_chance(chosen, values, terms.seed)
        if chosen.at_once and terms.duration is not None:
            raise UsageError(f"the fault {kind} occurs only once and cannot have a duration: leave out `duration`")
        arm = self.trigger(terms.when, terms.here)

        def do() -> Fault:
            if terms.at is not None and to_ns(terms.at) < (now_ns := self.world.clock.now):
                now_s = to_seconds(now_ns)
                raise UsageError(f"the start time at={terms.at:g} is in the past: expected {now_s:g} s or later")
            fault = Fault(self, self._free_name(terms.name, kind), chosen, spot, values, terms.seed)
            self._those[fault.name] = fault
            self._start(fault, arm, terms)
            return fault

        return do

    def trigger(self, when: str | None, here: str = "") -> triggers.Arm | None:
        """Parse the event `when`; return its trigger, or None without an event.  Raises UsageError."""
        return None if when is None else triggers.read(when, self.world, here)

    def spot(self, kind: Kind, on: str, here: str = "") -> Spot:
        """Return the pin, axis, line or controller that a fault affects.  Raises UsageError for a wrong name."""
        found = self.spots(kind.on, here)
        if not on and here in found:
            on = here
        if not on:
            example = next(iter(found), kind.on.value.partition(",")[0])
            affected_part = with_article(THINGS[kind.on])
            raise UsageError(f"the fault {kind.name} needs the name of {affected_part}: expected e.g. {example}")
        return places.find(found, on, THINGS[kind.on])

    def spots(self, on: On, here: str = "") -> dict[str, places.Find]:
        return places.names(PLACES[on](self.world), here)

    def mend(self, name: str) -> None:
        """End the faults of this name or kind, or "all".  Raises UsageError if there is none."""
        those = [fault for fault in self if name in (fault.name, fault.kind.name, "all")]
        if not those and name != "all":
            raise UsageError(f"unknown fault {name!r}: known faults are {', '.join(self.names) or 'none'}")
        for fault in those:
            fault.mend()

    def subscribe(self, callback: Listener) -> Callable[[], None]:
        """Call `callback(fault, "begins")` and `callback(fault, "ends")`; return an unsubscribe function."""
        return self.changes.subscribe(callback)

    def _start(self, fault: Fault, arm: triggers.Arm | None, terms: "Terms") -> None:
        clock = self.world.clock
        duration_ns = None if terms.duration is None else to_ns(terms.duration)

        def begin() -> None:
            self._make_room(fault)
            fault._begin(duration_ns)

        def wait() -> None:
            if fault.state is not State.WAITING:
                return
            if arm is None:
                begin()
            else:  # The fault begins after all other events that occur at the time of the trigger.
                times = count(1)
                fault._unsubscribe = arm(lambda: clock.call_later(0, begin) if next(times) == terms.nth else None)

        if terms.at is None:
            wait()
        else:
            # The simulation may end before the planned start of a fault.
            clock.call_in_background(to_ns(terms.at) - clock.now, wait)

    def _make_room(self, fault: Fault) -> None:
        """End an earlier fault of the same kind on the same part, except on a line, which can have several."""
        if fault.kind.on is On.LINE or fault.state is not State.WAITING:
            return
        for other in self:
            if other.on and other.kind is fault.kind and other.spot.name == fault.spot.name:
                other.mend()

    def _free_name(self, wanted: str | None, kind: str) -> str:
        taken = {name for name, fault in self._those.items() if fault.state is not State.OVER}
        if wanted is not None and wanted in taken:
            raise UsageError(f"there is a fault {wanted!r} already: end that fault, or choose another name")
        name = wanted or free_name(kind, taken)
        self._those.pop(name, None)
        return name


def free_name(kind: str, taken: Collection[str]) -> str:
    candidates = (kind if n == 1 else f"{kind}-{n}" for n in range(1, len(taken) + 2))
    return next(name for name in candidates if name not in taken)


def _check_seconds(key: str, given: float) -> None:
    if isinstance(given, bool) or not 0 <= given < float("inf"):
        raise UsageError(f"invalid {key}={given!r}: expected a number of seconds, 0 or more")
    try:
        to_ns(given)
    except UsageError:
        raise UsageError(f"`{key}` is out of range: expected less than 9.2e9 s (292 years), e.g. {key}=2.5") from None


def _check_chance(kind: Kind, values: Mapping[str, Any], seed: int | None) -> None:
    """Raise UsageError for a random fault without a seed, because runs must be repeatable."""
    chances: dict[str, Callable[[Any], bool]]
    chances = {"probability": lambda p: p < 1, "jitter": lambda s: s > 0, "mask": lambda bits: bits == 0}
    by_chance = (name for name, is_so in chances.items() if name in values and is_so(values[name]))
    if seed is None and (name := next(by_chance, None)):
        given = f"{name}={values[name]:g}"
        raise UsageError(f"the fault {kind.name} with {given} is random and needs a seed: add e.g. seed=1")
