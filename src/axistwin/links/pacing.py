"""Pacing of virtual time by the wall clock.  No other module of the emulator reads the wall clock.

At speed N the pacer advances the bench to the time of the wall clock, at least every 5 ms while events are due, and at
once on input.  At full speed (`max`) the pacer executes all due events in slices of 2 ms; sockets are served between
two slices.  An idle bench costs no processor time.

Input always finds the bench at the end of a nanosecond, with all events up to that time executed.  A run can therefore
be replayed: `run_to` the same time, then repeat the same input.
"""

import asyncio
from collections.abc import Callable
from time import perf_counter
from typing import Protocol, TypeVar

from axistwin.errors import AxistwinError, UsageError
from axistwin.numbers import NumberError, real, shortened
from axistwin.sim.clock import Clock
from axistwin.units import MOST_NS, S

MAX_SPEED = 1e6
"""Upper limit of the speed, times real time."""
SLICE_S = 0.002
"""Longest time that the bench runs before sockets are served again."""
BLOCK_S = 0.005
"""Shortest interval between two advances of the bench by the wall clock."""
LATE_S = 0.025
"""An event that is executed later than this counts as an overrun."""
MAX_LAG_S = 1.0
"""A larger delay is not made up: virtual time continues from its present value."""


T = TypeVar("T")


class Port(Protocol):
    """A port with output that is sent after the bench has been advanced."""

    def flush(self) -> None:
        """Send pending output."""


def read_speed(text: str) -> float | None:
    """Return the speed as a number up to 1,000,000; `"max"` as None.  Raises UsageError."""
    if text == "max":
        return None
    try:
        speed = real(text)
    except NumberError:
        speed = 0.0
    return _checked_speed(speed, text)


def _checked_speed(speed: float, text: str) -> float:
    if not 0 < speed <= MAX_SPEED:
        raise UsageError(
            f"invalid speed {shortened(text)}: expected a number up to 1000000, e.g. 1 (real time) or 0.5, or max"
        )
    return speed


class Pacer:
    """Advances the clock of one bench at `speed` times real time; None: as fast as possible."""

    def __init__(self, clock: Clock, speed: float | None = 1.0) -> None:
        self.clock = clock
        self.advancing = False
        """True while the bench is being advanced.  An act in this state comes from the bench itself."""
        self.passes = 0
        """Number of advances so far.  Inputs with the same number arrive together."""
        self.blocks = 0
        """Number of advances by the wall clock in which an event was due."""
        self.overruns = 0
        """Number of these blocks in which the event was executed too late."""
        self.most_late_s = 0.0
        self.on_failure: Callable[[AxistwinError], None] | None = None
        """Called with the error when a planned act on the bench fails; the run continues.  None: raise the error."""
        self.on_defect: Callable[[Exception], None] | None = None
        """Called with any other error that the bench raises, a defect of axistwin, before the error is raised."""
        self.agenda_ns = 0
        """At full speed virtual time reaches at least this value, even if no event is due."""
        self._speed = speed
        self._to_flush: list[Port] = []
        self._observers: list[Callable[[], None]] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._next: asyncio.Handle | None = None
        self._next_at_s = 0.0
        self._last_s = 0.0
        self._wall_s, self._virtual_ns = 0.0, 0
        self._plan = 0  # number of the present plan; a loop that was started under another plan ends

    @property
    def speed(self) -> float | None:
        """Times real time; None: as fast as possible.  Settable at any time.  Raises UsageError if invalid."""
        return self._speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        speed = None if speed is None else _checked_speed(speed, f"{speed:g}")
        if self._loop is None:
            self._speed = speed
        else:
            self.sync()
            self._speed = speed
            self._restart(self._loop)

    @property
    def running(self) -> bool:
        """True while virtual time passes."""
        return self._loop is not None

    def start(self, loop: asyncio.AbstractEventLoop | None = None) -> None:
        """Start virtual time, paced by the clock of `loop`; None: of the running event loop."""
        self.clock.patient = False
        self._restart(loop or asyncio.get_running_loop())

    def stop(self) -> None:
        """Stop virtual time.  While the bench is being advanced: after all events of the present nanosecond."""
        was_running, self._loop = self._loop is not None, None
        self._cancel_plan()
        if was_running and not self.advancing:
            self._flush()

    def replace_clock(self, clock: Clock) -> None:
        """Pace another clock, from its present time.  Not allowed while the bench is being advanced."""
        clock.patient = self.clock.patient
        self.clock = clock
        if self._loop is not None:
            self._reset_origin(self._loop)
            self._next = self._loop.call_soon(self._tick)

    def request_flush(self, port: Port) -> None:
        """Flush this port after the bench has been advanced."""
        self._to_flush.append(port)

    def subscribe(self, observer: Callable[[], None]) -> Callable[[], None]:
        """Call `observer` after each advance of the bench.  Returns an unsubscribe function."""
        self._observers.append(observer)
        return lambda: self._observers.remove(observer)

    def sync(self) -> None:
        """Call before an input: advance virtual time to now and execute all events due by then."""
        if self.advancing:
            return
        if self._speed is not None and self._loop is not None:
            self._advance(self._loop.time())
        if not self.clock.done:
            self._run(self._finish)

    def work(self) -> None:
        """Call after an input: execute all events due now."""
        if self.advancing:
            return
        if self._loop is None:
            self.sync()
            self._flush()
        elif self._speed is not None:
            self._advance(self._loop.time())
            self._flush()
            self._schedule_advance()
        elif self._next is None:  # else a slice is coming anyway, and the sockets have their turn first
            self._slice()

    def inspect(self, read: Callable[[], object]) -> None:
        """Advance virtual time to now, call `read`, and plan the next advance again.

        The pacer sleeps while no event is due, even while a motor moves.  Reading the state of a SmartMotor makes the
        motor plan its block again, so that an event may become due earlier.
        """
        self.work()
        read()
        self.work()

    def advance_slice(self, advance: Callable[[Callable[[], bool]], T]) -> T:
        """While virtual time is stopped: advance the bench by one slice with `advance(over)`, and flush its ports.

        `advance` must return at the end of a nanosecond, soon after `over()` is True.  Returns the result of `advance`.
        """
        end_s = perf_counter() + SLICE_S
        found: list[T] = []
        while not found:  # repeat after a failed act
            self._run(lambda: found.append(advance(lambda: perf_counter() >= end_s)))
        self._flush()
        return found[0]

    @property
    def behind_s(self) -> float:
        """Delay of the bench against the wall clock at the last advance, in seconds; 0 at full speed."""
        if self._speed is None or self._loop is None:
            return 0.0
        return max(0.0, (self._target_ns(self._last_s) - self.clock.now) / S / self._speed)

    def report(self) -> str | None:
        """One line about delays against the wall clock; None if there were none."""
        if not self.overruns:
            return None
        times = "once" if self.overruns == 1 else f"{self.overruns} times"
        return f"fell behind the wall clock {times}, by {self.most_late_s * 1000:.0f} ms at most"

    def _restart(self, loop: asyncio.AbstractEventLoop) -> None:
        """Pace from now on, from the present virtual time."""
        self._reset_origin(loop)
        self.work()

    def _reset_origin(self, loop: asyncio.AbstractEventLoop) -> None:
        self._cancel_plan()
        self._loop = loop
        self._wall_s, self._virtual_ns = loop.time(), self.clock.now

    def _cancel_plan(self) -> None:
        self._plan += 1
        if self._next is not None:
            self._next.cancel()
            self._next = None

    # Advancing the bench

    def _run(self, advance: Callable[[], None]) -> None:
        """Advance the bench; then follow the new plan if an event has changed the plan."""
        plan, self.advancing = self._plan, True
        self.passes += 1
        try:
            while not self._succeeds(advance) and plan == self._plan:
                pass
            while plan != self._plan and not self._succeeds(self._finish):
                pass
        except Exception as error:
            if self.on_defect is not None:
                self.on_defect(error)
            raise
        finally:
            self.advancing = False
        if plan != self._plan:
            self._follow_plan()

    def _succeeds(self, advance: Callable[[], None]) -> bool:
        """Advance the bench.  Returns False after a failed act."""
        try:
            advance()
        except AxistwinError as error:
            if self.on_failure is None:
                raise
            self.on_failure(error)
            return False
        return True

    def _finish(self) -> None:
        """Execute all events due by now."""
        self.clock.run_to(self.clock.now)

    def _follow_plan(self) -> None:
        """Follow a start, a stop or a new speed that an event has caused."""
        self._flush()
        if self._loop is not None:
            self._next = self._next or self._loop.call_soon(self._tick)

    def _tick(self) -> None:
        self._next = None
        self.work()

    # Full speed

    @property
    def _idle(self) -> bool:
        """True if no work is left."""
        clock = self.clock
        return (clock.quiet and clock.now >= self.agenda_ns) or clock.next_event_ns() is None

    def _slice(self) -> None:
        self._next = None
        if not self._idle:
            self._run(self._run_slice)
        self._flush()
        self._schedule_slice()

    def _schedule_slice(self) -> None:
        if self._next is None and self._loop is not None and not self._idle:
            self._next = self._loop.call_soon(self._slice)

    def _run_slice(self) -> None:
        clock, plan, end_s = self.clock, self._plan, perf_counter() + SLICE_S
        clock.step()
        while not self._idle and plan == self._plan and perf_counter() < end_s:
            clock.step()

    # Paced by the wall clock

    def _advance(self, wall_s: float) -> None:
        """Advance virtual time to `wall_s`, or as near as one slice allows."""
        assert self._speed is not None
        self._last_s = wall_s
        target_ns = self._target_ns(wall_s)
        due_ns = self.clock.next_event_ns()
        if due_ns is not None and due_ns <= target_ns:
            self._count_block((target_ns - due_ns) / S / self._speed)
        if target_ns > self.clock.now or due_ns == target_ns:
            self._run(lambda: self._follow(target_ns, wall_s))

    def _target_ns(self, wall_s: float) -> int:
        """Virtual time that corresponds to this time of the wall clock."""
        assert self._speed is not None
        return min(self._virtual_ns + int((wall_s - self._wall_s) * self._speed * S), MOST_NS - 1)

    def _follow(self, target_ns: int, wall_s: float) -> None:
        clock, plan, end_s = self.clock, self._plan, perf_counter() + SLICE_S
        due_ns = clock.next_event_ns()
        while due_ns is not None and due_ns <= target_ns:
            if perf_counter() >= end_s:
                self._drop_delay(target_ns, wall_s)
                return
            clock.step()
            if plan != self._plan:
                return
            due_ns = clock.next_event_ns()
        if target_ns > clock.now:
            clock.run_to(target_ns)

    def _count_block(self, late_s: float) -> None:
        self.blocks += 1
        if late_s > LATE_S:
            self.overruns += 1
            self.most_late_s = max(self.most_late_s, late_s)

    def _drop_delay(self, target_ns: int, wall_s: float) -> None:
        """Drop a delay that is too large: the bench was too slow, or the computer was suspended."""
        assert self._speed is not None
        if (target_ns - self.clock.now) / S / self._speed > MAX_LAG_S:
            self._wall_s, self._virtual_ns = wall_s, self.clock.now

    def _schedule_advance(self) -> None:
        """Schedule the next advance: when an event is due, but at most once per block."""
        if self._loop is None or self._speed is None:
            return
        due_ns = self.clock.next_event_ns()
        if due_ns is None:
            return
        due_s = self._wall_s + (due_ns - self._virtual_ns) / S / self._speed
        at_s = max(due_s, self._last_s + BLOCK_S) if due_s > self._last_s else self._last_s
        if self._next is not None:
            if self._next_at_s <= at_s:
                return
            self._next.cancel()
        self._next, self._next_at_s = self._loop.call_at(at_s, self._tick), at_s

    # Output

    def _flush(self) -> None:
        while self._to_flush:
            ports, self._to_flush = self._to_flush, []
            for port in ports:
                port.flush()
        for observer in tuple(self._observers):
            observer()
