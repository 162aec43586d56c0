"""Terminals whose level the machine sets: pins A and B if an external encoder is connected, and the index line."""

from collections.abc import Callable
from math import ceil, floor

from axistwin.controllers.smartmotor.kernel import state as s
from axistwin.controllers.smartmotor.kernel.position import actual_position
from axistwin.controllers.smartmotor.kernel.trajectory import quadrature
from axistwin.controllers.smartmotor.processor import Processor
from axistwin.plant.master import Master
from axistwin.sim.clock import Clock
from axistwin.sim.pins import PULLED_UP_VOLTS, Pin, UserPin
from axistwin.sim.signal import Signal


class EncoderPin(UserPin):
    """Pin A or B, with the level of the external encoder unless a stronger source sets the level.

    The encoder's level is read on demand.  The edges cause events only while `subscribe_edges` has subscribers.
    """

    def __init__(self, clock: Clock, name: str, master: Master) -> None:
        super().__init__(clock, name)
        self._bit, self._master = s.USER_PINS.index(name), master
        self.levels: Callable[[int], int] = quadrature
        """Function that returns the levels of pins A (1) and B (2) at a count of the external encoder."""
        self.on_wiring: Callable[[], None] = lambda: None  # Called when another source may determine the level.
        self._edges: Signal[Pin] = Signal()
        self._last = True
        self._disarm: Callable[[], object] = lambda: None

    @property
    def shows_encoder(self) -> bool:
        free = not self._holds and self._lead is None and self._stage is None and self._wired is None
        return free and self._master.plugged

    @property
    def restless(self) -> bool:  # type: ignore[override]  # it depends on what is wired to the pin
        return self.shows_encoder

    @property
    def level(self) -> bool:
        return self._level_at(self._master.count) if self.shows_encoder else super().level

    def _level_at(self, count: int) -> bool:
        return bool(self.levels(count) >> self._bit & 1)

    @property
    def volts(self) -> float:
        """The voltage at the terminal: 5 V or 0 V from an encoder."""
        return PULLED_UP_VOLTS * self.level if self.shows_encoder else super().volts

    def unplug(self) -> None:
        """Disconnect the processor, whose power is off; the encoder stays connected."""
        self.levels, self.on_wiring = quadrature, lambda: None
        self.refresh()

    def _find_volts(self, level: bool, before: float) -> None:
        super()._find_volts(level, before)
        self.on_wiring()
        self.refresh()

    def subscribe_edges(self, callback: Callable[[Pin], None]) -> Callable[[], None]:
        """Call `callback(pin)` at every change of the pin's level; return an unsubscribe function."""
        unsubscribe = self._edges.subscribe(callback)
        end_changes = self._master.on_change.subscribe(self.refresh)
        self._last = self.level
        self._arm()

        def end() -> None:
            unsubscribe()
            end_changes()
            self._arm()

        return end

    def refresh(self) -> None:
        if self._edges:
            level = self.level
            changed, self._last = level is not self._last, level
            self._arm()
            if changed:
                self._edges.emit(self)

    def _arm(self) -> None:
        self._disarm()
        self._disarm = lambda: None
        if self._edges and self.shows_encoder:
            if self._master.followed is None:
                self._arm_run()
            else:
                self._arm_axis()

    def _next_count(self, way: int) -> int | None:
        count = self._master.count
        level = self._level_at(count)
        return next((count + way * n for n in (1, 2) if self._level_at(count + way * n) is not level), None)

    def _arm_run(self) -> None:
        run, clock = self._master.run, self.clock
        count = self._next_count(1 if run.counts > 0 else -1)
        if count is None or abs(count - run.base) > abs(run.counts) or clock.now >= run.end_ns:
            return
        edge_ns = run.start_ns - (-abs(count - run.base) * run.duration_ns // abs(run.counts))
        armed = True

        def passed() -> None:
            if armed:
                self.refresh()

        def disarm() -> None:
            nonlocal armed
            armed = False

        self._disarm = disarm
        clock.call_in_background(edge_ns - clock.now, passed)

    def _arm_axis(self) -> None:
        master = self._master
        axis, ratio = master.followed, master.ratio
        up, down = self._next_count(1), self._next_count(-1)
        if axis is None or ratio == 0 or up is None or down is None:
            return
        limits = (up - master.run.base) / ratio, (down + 1 - master.run.base) / ratio
        edges = [ceil(at) if ratio > 0 else floor(at) + 1 for at in limits]
        self._disarm = axis.subscribe_edges(edges, self.refresh)


class IndexLine(Pin):
    """The encoder's index line, which is high at the index mark.  Without subscribers, the level is read on demand."""

    restless = True

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock, "index")
        self._motor: Processor | None = None

    def connect(self, motor: Processor | None) -> None:
        """Connect the index signal to a processor that has just been switched on; None disconnects it."""
        self._motor = motor
        if self._changes:
            self._report_changes()

    def _report_changes(self) -> None:
        """Simulate each level change of the encoder's index line as a separate event."""
        if self._motor is not None:
            self._motor.catch_up()
            self._motor.i[s.OBSERVE_INDEX] = 1

    @property
    def level(self) -> bool:
        """True if the shaft is at the index mark.  A forced level has priority."""
        motor = self._motor
        if self.driven or self._holds or motor is None:
            return super().level
        motor.catch_up(changing=False)
        return bool(motor.i[s.BX])

    def drive(self, level: bool) -> None:
        """Force the index line to a level.  A rising edge captures the position, as an index mark does."""
        before = self.level
        super().drive(level)
        self._force(bool(level), rising=bool(level) and not before)

    def release(self) -> None:
        super().release()
        self._force(False, rising=False)

    def _force(self, on: bool, *, rising: bool) -> None:
        """Force the index line.  A rising edge captures the position and sets Bi, as the index mark does."""
        if self._motor is None:
            return
        self._motor.catch_up()
        i = self._motor.i
        i[s.INDEX_FORCED] = on
        i[s.BX] |= on
        if rising and i[s.INDEX_ARMED]:
            i[s.INDEX], i[s.INDEX_ARMED], i[s.BI] = actual_position(i), 0, 1

    def subscribe(self, callback: Callable[[Pin], None]) -> Callable[[], None]:
        """Call `callback(pin)` at every change of the encoder's index signal; return an unsubscribe function."""
        self._report_changes()
        return super().subscribe(callback)

    def show(self) -> None:
        if not self.driven:
            self._announce()
