"""Pins and the wires between them.

A pin has one level, high or low.  The connected part (a controller's output stage, a switch, a wire) sets this level.
A person with a test lead may `drive` the pin to another level until `release`.

A `UserPin` has a voltage as well: it is a TTL terminal with a pull-up resistor, used by its device as input or output.
"""

from collections.abc import Callable
from dataclasses import dataclass

from axistwin.core.errors import UsageError
from axistwin.sim.clock import Clock, Event, Procedure
from axistwin.sim.signal import Signal

PULLED_UP_VOLTS = 5.0  # Voltage of an open user pin, through its 5 kΩ resistor.
HIGH_VOLTS, LOW_VOLTS = 2.0, 0.8
"""Thresholds: the level is high from the first voltage up, low from the second voltage down, and unchanged in between.
"""
LEAST_VOLTS, MOST_VOLTS = -0.5, 5.5  # The range of voltages that the pin survives.
FULL_SCALE = 1023  # The analog-to-digital converter's reading for 5.0 V.


@dataclass(eq=False)
class _Held:
    level: bool


class Pin:
    """A digital terminal of a device.  Each family defines what `level` means electrically."""

    restless = False  # True if the pin changes so often that it must be read on demand, not observed.
    silent = False  # True if the pin does not report its changes to subscribers.

    wired = False  # True if a wire or a switch is connected.

    def __init__(self, clock: Clock, name: str, level: bool = False, *, output: bool = False) -> None:
        self.clock, self.name = clock, name
        self._output, self._source = output, level
        self._driven: bool | None = None
        self._holds: list[_Held] = []
        self._changes: Signal[Pin] = Signal()
        self.lead_changes: Signal[[]] = Signal()  # Event: the test lead has changed, even to an equal level.
        self._changed: Event | None = None
        self._flash_ns, self._flash_from = 0, 0

    def __repr__(self) -> str:
        return f"<Pin {self.name} {'high' if self.level else 'low'}>"

    @property
    def level(self) -> bool:
        """True if the level is high.  An opto-isolated input of the IF1/IF2 is high if current flows."""
        if self._holds:
            return self._holds[-1].level
        if self._driven is not None:
            return self._driven
        return (self.clock.now - self._flash_from) // self._flash_ns % 2 == 0 if self._flash_ns else self._source

    @property
    def is_output(self) -> bool:
        return self._output

    @property
    def drivable(self) -> bool:
        """True if the level can be set from outside."""
        return not self._output

    @property
    def driven(self) -> bool:
        """True while a test lead forces the level of the terminal."""
        return self._driven is not None

    @property
    def undriven(self) -> bool:
        """The level of the terminal without test lead and defects: that of the connected part."""
        return self._source

    @property
    def held(self) -> bool:
        """True while a defect holds the terminal at a fixed level."""
        return bool(self._holds)

    @property
    def flashing(self) -> bool:
        return self._flash_ns != 0

    def drive(self, level: bool) -> None:
        """Connect a test lead that sets the terminal to `level`."""
        before = self.level
        self._put_lead(bool(level))
        self._update(before)

    def release(self) -> None:
        """Remove the test lead: the connected part sets the level again."""
        before = self.level
        self._put_lead(None)
        self._update(before)

    def hold(self, level: bool) -> Callable[[], None]:
        """Simulate a defect that holds the terminal at `level`.

        A defect overrides a test lead.  The latest of several defects wins.  Return a function that ends the defect.
        """
        held = _Held(level)
        before = self.level
        self._holds.append(held)
        self._update(before)

        def let_go() -> None:
            before = self.level
            self._holds.remove(held)
            self._update(before)

        return let_go

    def set(self, level: bool) -> None:
        """Set the level that an output stage, a switch or a wire applies to the pin."""
        if level is self._source and not self._flash_ns:
            return
        before, self._source, self._flash_ns = self.level, level, 0
        self._update(before)

    def flash(self, half_period_ns: int) -> None:
        """Make the output flash, beginning with the high level.  Without subscribers, the flashing causes no events."""
        before, self._flash_ns, self._flash_from = self.level, half_period_ns, self.clock.now
        self._update(before)
        if self._changes:
            self.clock.process(self._flashing())

    def subscribe(self, callback: Callable[["Pin"], None]) -> Callable[[], None]:
        """Call `callback(pin)` at each change of the pin's level.  Return a function that ends these calls."""
        first = not self._changes
        unsubscribe = self._changes.subscribe(callback)
        if self._flash_ns and first:
            self.clock.process(self._flashing())
        return unsubscribe

    def subscribe_edges(self, callback: Callable[["Pin"], None]) -> Callable[[], None]:
        """Call `callback(pin)` at each change, even of a pin that is read on demand; return an unsubscribe function."""
        return self.subscribe(callback)

    @property
    def lead(self) -> bool | float | None:
        """The level, or the voltage of a `UserPin`, that the test lead forces; None: no test lead."""
        return self._driven

    def _put_lead(self, level: bool | None) -> None:
        if level is not self._driven:
            self._driven = level
            self.lead_changes.emit()

    def changed(self) -> Event:
        """Return an event that happens at the next change of the pin's level."""
        if self._changed is None:
            self._changed = self.clock.event()
        return self._changed

    def _update(self, before: bool) -> None:
        if self.level is not before:
            self._announce()

    def _announce(self) -> None:
        if self._changed is not None:
            event, self._changed = self._changed, None
            event.succeed()
        self._changes.emit(self)

    def _flashing(self) -> Procedure:
        began, half_ns = self._flash_from, self._flash_ns
        while self._changes and self._flash_ns and self._flash_from == began:
            self.clock.background += 1
            yield self.clock.timeout(half_ns - (self.clock.now - began) % half_ns)
            self.clock.background -= 1
            if self._flash_ns and self._flash_from == began and self._driven is None:
                self._announce()


class CalculatedPin(Pin):
    """An output whose level is calculated at each reading; it causes no event for each pulse."""

    silent = True

    def __init__(self, clock: Clock, name: str, read: Callable[[], bool]) -> None:
        super().__init__(clock, name, output=True)
        self._read = read

    @property
    def level(self) -> bool:
        return super().level if self._holds or self.driven else self._read()


class SensedPin(Pin):
    """An input whose level is read from a sensor on demand.

    The sensor is observed only while the input has subscribers.  A sensor that the machine passes repeatedly therefore
    costs no events unless a device waits for it.
    """

    def __init__(self, clock: Clock, name: str) -> None:
        super().__init__(clock, name)
        self._read: Callable[[], bool] | None = None
        self._follow: Callable[[Callable[[], None]], Callable[[], None]] | None = None
        self._unfollow: Callable[[], None] | None = None
        self._last = False

    def sense(self, read: Callable[[], bool], follow: Callable[[Callable[[], None]], Callable[[], None]]) -> None:
        """Connect a sensor: `read` returns its level, `follow(update)` calls `update` when the level may have changed.

        `follow` must return an unsubscribe function.
        """
        self._read, self._follow = read, follow
        self.wired = self.restless = True

    @property
    def level(self) -> bool:
        return super().level if self._read is None or self._holds or self.driven else self._read()

    @property
    def undriven(self) -> bool:
        return self._source if self._read is None else self._read()

    def set(self, level: bool) -> None:
        before = self.level
        self._read, self._source, self.restless = None, level, False
        self._update(before)

    def subscribe(self, callback: Callable[[Pin], None]) -> Callable[[], None]:
        end = super().subscribe(callback)
        if self._unfollow is None and self._follow is not None:
            self._last = self.level
            self._unfollow = self._follow(lambda: self._update(self._last))

        def unsubscribe() -> None:
            end()
            if not self._changes and self._unfollow is not None:
                self._unfollow()
                self._unfollow = None

        return unsubscribe

    def changed(self) -> Event:
        if self._changed is None:
            event = super().changed()
            unsubscribe = self.subscribe(lambda pin: unsubscribe())
            return event
        return self._changed

    def _update(self, before: bool) -> None:
        self._last = self.level
        super()._update(before)


class UserPin(Pin):
    """A TTL terminal with a 5 kΩ pull-up resistor, used as input, output or analog input.

    Priority, highest first: a defect (`hold`), a test lead (`drive`), the output stage (`output`), external wiring
    (`set`), the pull-up resistor.
    """

    def __init__(self, clock: Clock, name: str) -> None:
        super().__init__(clock, name, level=True)
        self._lead: float | None = None
        self._stage: float | None = None
        self._wired: float | None = None
        self._volts = PULLED_UP_VOLTS
        self.volts_changes: Signal[UserPin] = Signal()  # Event: the voltage has changed.

    @property
    def volts(self) -> float:
        """Voltage at the terminal, in V."""
        return self._volts

    @property
    def analog(self) -> int:
        """Result of a 10-bit A/D conversion of the voltage: 0 for 0 V, 1023 for 5 V."""
        return min(max(int(self.volts * FULL_SCALE / PULLED_UP_VOLTS + 0.5), 0), FULL_SCALE)

    @property
    def driven(self) -> bool:
        return self._lead is not None

    @property
    def is_output(self) -> bool:
        return self._stage is not None

    @property
    def undriven(self) -> bool:
        volts = next((volts for volts in (self._stage, self._wired) if volts is not None), PULLED_UP_VOLTS)
        return volts >= HIGH_VOLTS or (volts > LOW_VOLTS and self._source)

    @property
    def drivable(self) -> bool:
        """Always True: a test lead can set the level of every terminal, even of an output."""
        return True

    def drive(self, level: bool | float) -> None:
        """Connect a test lead that applies the voltage `level` to the terminal.

        `level`: True means 5 V, and False means 0 V.  Raises UsageError for a voltage that no TTL terminal survives.
        """
        self._attach(_volts(level))

    def release(self) -> None:
        self._attach(None)

    @property
    def lead(self) -> float | None:
        return self._lead

    def _attach(self, volts: float | None) -> None:
        """Report a change of the test lead before its effect, even if the voltage stays the same."""
        if volts == self._lead:
            return
        level, before = self.level, self.volts
        self._lead = volts
        self.lead_changes.emit()
        self._find_volts(level, before)

    def set(self, level: bool | float | None) -> None:
        """Set the level or voltage of the external wiring; None: open."""
        self._set_source("_wired", None if level is None else _volts(level))

    def output(self, level: bool) -> None:
        """Switch the output stage on, at 5 V or 0 V."""
        self._set_source("_stage", PULLED_UP_VOLTS if level else 0.0)

    def input(self) -> None:
        self._set_source("_stage", None)

    def hold(self, level: bool) -> Callable[[], None]:
        """Simulate a defect that holds the terminal at 5 V or 0 V.  Return a function that ends the defect."""
        volts = self.volts
        let_go = super().hold(level)
        self._find_volts(self.level, volts)

        def ended() -> None:
            volts = self.volts
            let_go()
            self._find_volts(self.level, volts)

        return ended

    def _set_source(self, source: str, volts: float | None) -> None:
        level, before = self.level, self.volts
        setattr(self, source, volts)
        self._find_volts(level, before)

    def _find_volts(self, level: bool, before: float) -> None:
        held = _volts(self._holds[-1].level) if self._holds else None
        stated = (volts for volts in (held, self._lead, self._stage, self._wired) if volts is not None)
        self._volts = next(stated, PULLED_UP_VOLTS)
        if self._volts >= HIGH_VOLTS:
            self._source = True
        elif self._volts <= LOW_VOLTS:
            self._source = False
        self._update(level)
        if self.volts != before:
            self.volts_changes.emit(self)


def _volts(level: bool | float) -> float:
    if isinstance(level, bool) or not isinstance(level, int | float):
        return PULLED_UP_VOLTS if level else 0.0
    if not LEAST_VOLTS <= level <= MOST_VOLTS:
        raise UsageError(f"a voltage of {level!r} V would destroy a user pin: expected 0 to 5 V, e.g. 3.3")
    return float(level)


def connect(source: Pin, target: Pin, *, invert: bool = False, delay_ns: int = 0) -> None:
    """Connect a wire: `target` follows the level of `source`, optionally inverted or delayed."""

    def follow(pin: Pin) -> None:
        level = pin.level is not invert
        if delay_ns:
            pin.clock.call_later(delay_ns, lambda: target.set(level))
        else:
            target.set(level)

    source.subscribe(follow)
    target.wired = True
    follow(source)
