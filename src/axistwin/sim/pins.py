"""Pins and the wires between them.

A pin has one level at a time.  What is connected to it (a controller's output stage, a switch, a wire) sets its
`source`; a person with a test lead may `drive` it to another level until they `release` it.

A `UserPin` has volts as well: a TTL terminal with a pull-up resistor that is input or output as its device wishes.
"""

from collections.abc import Callable
from dataclasses import dataclass

from axistwin.errors import UsageError
from axistwin.sim.clock import Clock, Event, Procedure

PULLED_UP_VOLTS = 5.0
"""What an open user pin is at, through its 5 kΩ resistor."""
HIGH_VOLTS, LOW_VOLTS = 2.0, 0.8
"""From here on it is high; up to here it is low.  Between them the level stays as it was."""
LEAST_VOLTS, MOST_VOLTS = -0.5, 5.5
"""Beyond these it would be destroyed."""
FULL_SCALE = 1023
"""What the analog-to-digital converter makes of 5.0 V."""


@dataclass(eq=False)
class _Held:
    """A defect that keeps a terminal at a level."""

    level: bool


class Pin:
    """A digital terminal of a device.  `level` is the electrical level there, as the family defines it."""

    restless = False
    """Whether it changes so often by itself that one looks at it rather than being told."""
    silent = False
    """Whether it changes without telling those who watch."""

    wired = False
    """Whether a wire or a switch is connected to it."""

    def __init__(self, clock: Clock, name: str, level: bool = False, *, output: bool = False) -> None:
        self.clock, self.name = clock, name
        self._output = output
        self._source = level
        self._driven: bool | None = None
        self._holds: list[_Held] = []
        self._watchers: list[Callable[[Pin], None]] = []
        self._lead_watchers: list[Callable[[], None]] = []
        self._changed: Event | None = None
        self._flash_ns = 0
        self._flash_from = 0

    def __repr__(self) -> str:
        return f"<Pin {self.name} {'high' if self.level else 'low'}>"

    @property
    def level(self) -> bool:
        """True: high.  For the opto-isolated inputs of the IF1/IF2: current flows."""
        if self._holds:
            return self._holds[-1].level
        if self._driven is not None:
            return self._driven
        if self._flash_ns:
            return (self.clock.now - self._flash_from) // self._flash_ns % 2 == 0
        return self._source

    @property
    def is_output(self) -> bool:
        """Whether the device gives it its level."""
        return self._output

    @property
    def driven(self) -> bool:
        """Whether it is forced from outside."""
        return self._driven is not None

    @property
    def held(self) -> bool:
        """Whether a defect keeps it at its level."""
        return bool(self._holds)

    @property
    def flashing(self) -> bool:
        """Whether its output stage flashes."""
        return self._flash_ns != 0

    def drive(self, level: bool) -> None:
        """Force the terminal from outside, whatever is connected to it."""
        before = self.level
        self._put_lead(bool(level))
        self._settle(before)

    def release(self) -> None:
        """Take the test lead away: the terminal goes back to what is connected to it."""
        before = self.level
        self._put_lead(None)
        self._settle(before)

    def hold(self, level: bool) -> Callable[[], None]:
        """A defect keeps the terminal at this level, whoever drives it.  Returns what ends that; the latest counts."""
        held = _Held(level)
        before = self.level
        self._holds.append(held)
        self._settle(before)

        def let_go() -> None:
            before = self.level
            self._holds.remove(held)
            self._settle(before)

        return let_go

    def set(self, level: bool) -> None:
        """What is connected to the terminal (an output stage, a switch, a wire) takes this level."""
        before, self._source, self._flash_ns = self.level, level, 0
        self._settle(before)

    def flash(self, half_period_ns: int) -> None:
        """The output stage flashes, high first.  It costs no events while nobody watches."""
        before, self._flash_ns, self._flash_from = self.level, half_period_ns, self.clock.now
        self._settle(before)
        if self._watchers:
            self.clock.process(self._flashing())

    def watch(self, watcher: Callable[["Pin"], None]) -> Callable[[], None]:
        """Call `watcher(pin)` at every change of level.  Returns what ends the watching."""
        self._watchers.append(watcher)
        if self._flash_ns and len(self._watchers) == 1:
            self.clock.process(self._flashing())
        return lambda: self._watchers.remove(watcher)

    def watch_lead(self, watcher: Callable[[], None]) -> Callable[[], None]:
        """Call `watcher()` when a test lead is put on, put at another level or taken away, whatever that changes.

        Returns what ends the watching.
        """
        self._lead_watchers.append(watcher)
        return lambda: self._lead_watchers.remove(watcher)

    @property
    def lead(self) -> bool | float | None:
        """The level, or the voltage of a `UserPin`, at which a test lead forces it; None: there is none."""
        return self._driven

    def _put_lead(self, level: bool | None) -> None:
        if level is not self._driven:
            self._driven = level
            self._tell_lead()

    def _tell_lead(self) -> None:
        for watcher in tuple(self._lead_watchers):
            watcher()

    def changed(self) -> Event:
        """An event that happens at the next change of level."""
        if self._changed is None:
            self._changed = self.clock.event()
        return self._changed

    def _settle(self, before: bool) -> None:
        if self.level is not before:
            self._announce()

    def _announce(self) -> None:
        if self._changed is not None:
            event, self._changed = self._changed, None
            event.succeed()
        for watcher in tuple(self._watchers):
            watcher(self)

    def _flashing(self) -> Procedure:
        began, half_ns = self._flash_from, self._flash_ns
        while self._watchers and self._flash_ns and self._flash_from == began:
            self.clock.background += 1
            yield self.clock.timeout(half_ns - (self.clock.now - began) % half_ns)
            self.clock.background -= 1
            if self._flash_ns and self._flash_from == began and self._driven is None:
                self._announce()


class SensedPin(Pin):
    """An input with a sensor whose level is found when somebody asks; changes are followed while somebody watches.

    So a sensor that the machine passes again and again costs no events unless a device waits for it.
    """

    def __init__(self, clock: Clock, name: str) -> None:
        super().__init__(clock, name)
        self._read: Callable[[], bool] | None = None
        self._follow: Callable[[Callable[[], None]], Callable[[], None]] | None = None
        self._unfollow: Callable[[], None] | None = None
        self._last = False

    def sense(self, read: Callable[[], bool], follow: Callable[[Callable[[], None]], Callable[[], None]]) -> None:
        """Connect a sensor: `read` returns its level, `follow(look)` calls `look` whenever it may have changed.

        `follow` returns what ends the calls.
        """
        self._read, self._follow = read, follow
        self.wired = self.restless = True

    @property
    def level(self) -> bool:
        """That of the sensor, unless it is driven or held."""
        if self._read is None or self._holds or self.driven:
            return super().level
        return self._read()

    def set(self, level: bool) -> None:
        """A switch or a wire is connected to the terminal in the place of the sensor."""
        before = self.level
        self._read, self._source, self.restless = None, level, False
        self._settle(before)

    def watch(self, watcher: Callable[[Pin], None]) -> Callable[[], None]:
        """Call `watcher(pin)` at every change of level.  Returns what ends the watching."""
        end = super().watch(watcher)
        if self._unfollow is None and self._follow is not None:
            self._last = self.level
            self._unfollow = self._follow(self._look)

        def unwatch() -> None:
            end()
            if not self._watchers and self._unfollow is not None:
                self._unfollow()
                self._unfollow = None

        return unwatch

    def changed(self) -> Event:
        """An event that happens at the next change of level."""
        if self._changed is None:
            event = super().changed()
            unwatch = self.watch(lambda pin: unwatch())
            return event
        return self._changed

    def _look(self) -> None:
        self._settle(self._last)

    def _settle(self, before: bool) -> None:
        self._last = self.level
        super()._settle(before)


class UserPin(Pin):
    """A TTL terminal with a 5 kΩ pull-up: open it is at 5 V and high.  It may be read as a voltage, too.

    Who decides about it, the strongest first: a defect (`hold`), a test lead (`drive`), its own output stage
    (`output`), what is wired to it (`set`), the pull-up resistor.
    """

    def __init__(self, clock: Clock, name: str) -> None:
        super().__init__(clock, name, level=True)
        self._lead: float | None = None
        self._stage: float | None = None
        self._wired: float | None = None
        self._volts = PULLED_UP_VOLTS
        self._volts_watchers: list[Callable[[UserPin], None]] = []

    @property
    def volts(self) -> float:
        """The voltage at the terminal."""
        return self._volts

    @property
    def analog(self) -> int:
        """The voltage as a 10-bit converter has it: 0 for 0 V, 1023 for 5.0 V, the nearest number, halves upwards."""
        return min(max(int(self.volts * FULL_SCALE / PULLED_UP_VOLTS + 0.5), 0), FULL_SCALE)

    @property
    def driven(self) -> bool:
        """Whether it is forced from outside."""
        return self._lead is not None

    @property
    def is_output(self) -> bool:
        """Whether its output stage is on."""
        return self._stage is not None

    def drive(self, level: bool | float) -> None:
        """Force the terminal from outside: True is 5 V, False 0 V, a number that many volts.

        Raises UsageError for a voltage that no TTL terminal survives.
        """
        self._attach(_volts(level))

    def release(self) -> None:
        """Take the test lead away."""
        self._attach(None)

    @property
    def lead(self) -> float | None:
        """The voltage at which a test lead forces it; None: there is none."""
        return self._lead

    def _attach(self, volts: float | None) -> None:
        """A test lead is reported before it acts, also where it changes nothing."""
        if volts == self._lead:
            return
        level, before = self.level, self.volts
        self._lead = volts
        self._tell_lead()
        self._find_volts(level, before)

    def set(self, level: bool | float | None) -> None:
        """What is wired to the terminal from outside, a switch or a wire, is at this level or voltage; None: open."""
        self._decide("_wired", None if level is None else _volts(level))

    def output(self, level: bool) -> None:
        """The output stage is on, and gives 5 V or 0 V."""
        self._decide("_stage", PULLED_UP_VOLTS if level else 0.0)

    def input(self) -> None:
        """The output stage is off."""
        self._decide("_stage", None)

    def watch_volts(self, watcher: Callable[["UserPin"], None]) -> Callable[[], None]:
        """Call `watcher(pin)` at every change of voltage.  Returns what ends the watching."""
        self._volts_watchers.append(watcher)
        return lambda: self._volts_watchers.remove(watcher)

    def hold(self, level: bool) -> Callable[[], None]:
        """A defect keeps the terminal at 5 V or 0 V, whoever drives it."""
        volts = self.volts
        let_go = super().hold(level)
        self._find_volts(self.level, volts)

        def ended() -> None:
            volts = self.volts
            let_go()
            self._find_volts(self.level, volts)

        return ended

    def _decide(self, who: str, volts: float | None) -> None:
        """One of those who decide about it gives it a voltage, or lets go of it (None)."""
        level, before = self.level, self.volts
        setattr(self, who, volts)
        self._find_volts(level, before)

    def _find_volts(self, level: bool, before: float) -> None:
        """Find the voltage, and tell those who watch if it or the level is not what it was `before`."""
        held = _volts(self._holds[-1].level) if self._holds else None
        stated = (volts for volts in (held, self._lead, self._stage, self._wired) if volts is not None)
        self._volts = next(stated, PULLED_UP_VOLTS)
        if self._volts >= HIGH_VOLTS:
            self._source = True
        elif self._volts <= LOW_VOLTS:
            self._source = False
        self._settle(level)
        if self.volts != before:
            for watcher in tuple(self._volts_watchers):
                watcher(self)


def _volts(level: bool | float) -> float:
    """A level or a voltage as a voltage.  A bool is a level, though Python takes it for a number."""
    if isinstance(level, bool) or not isinstance(level, int | float):
        return PULLED_UP_VOLTS if level else 0.0
    if not LEAST_VOLTS <= level <= MOST_VOLTS:
        raise UsageError(f"{level!r} V would destroy a user pin: give 0 to 5 V, or True or False")
    return float(level)


def connect(source: Pin, target: Pin, *, invert: bool = False, delay_ns: int = 0) -> None:
    """Wire `source` to `target`: the target follows the source's level, inverted and later if so wished."""

    def follow(pin: Pin) -> None:
        level = pin.level is not invert
        if delay_ns:
            pin.clock.call_later(delay_ns, lambda: target.set(level))
        else:
            target.set(level)

    source.watch(follow)
    target.wired = True
    follow(source)
