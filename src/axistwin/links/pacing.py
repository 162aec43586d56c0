"""Pacing of virtual time by the wall clock.

At speed N the pacer advances the bench to the time of the wall clock, at least every 5 ms while events are due, and at
once on input.  At full speed (`max`) the pacer executes all due events in slices of 2 ms; sockets are
served between two slices.  An idle bench costs no processor time.

Input always finds the bench at the end of a nanosecond, with all events up to that time executed.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable
from time import perf_counter
from typing import Protocol, TypeVar

from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.numbers import NumberError, real, shortened
from axistwin.core.units import MOST_NS, S
from axistwin.sim.clock import Clock
from axistwin.sim.signal import Signal

T = TypeVar("T")

SLICE_S = 0.002  # Longest time that the bench runs before sockets are served again.
BLOCK_S = 0.005  # Shortest interval between two advances of the bench by the wall clock.
MAX_LAG_S = (
    1.0  # Largest delay in seconds that is caught up; after a larger one, virtual time goes on from where it is.
)
LATE_S = 0.025  # Delay in seconds above which an event counts as an overrun.
MAX_SPEED = 1e6  # Upper limit of the speed, times real time.


def read_speed(text: str) -> float | None:
    """Parse a speed: a number up to 1,000,000, or `"max"`, which becomes None.  Raises UsageError."""
    if text == "max":
        return None
    try:
        speed = real(text)
    except NumberError:
        speed = 0.0
    return checked_speed(speed, text)


def checked_speed(speed: float | None, text: str = "") -> float | None:
    """Return `speed`.  Raises UsageError if it is out of range.  `text`: the speed as the user wrote it."""
    if speed is None or 0 < speed <= MAX_SPEED:
        return speed
    given_speed = shortened(text or f"{speed:g}")
    raise UsageError(f"invalid speed {given_speed}: expected `max` or a number up to 1000000, e.g. 1 for real time")


class Slice:
    """A slice of real time that begins when the object is created."""

    def __init__(self) -> None:
        self._end_s = perf_counter() + SLICE_S

    def over(self) -> bool:
        """True if the slice has ended, so that sockets must be served."""
        return perf_counter() >= self._end_s


class Delays:
    """Counts how often virtual time has fallen behind the wall clock, and records the longest delay."""

    def __init__(self) -> None:
        self.blocks = 0
        self.overruns = 0  # Number of overruns: blocks whose first event was late by more than `LATE_S` seconds.
        self.most_late_s = 0.0

    def count(self, late_s: float) -> None:
        """Record that virtual time was `late_s` seconds behind the wall clock."""
        self.blocks += 1
        if late_s > LATE_S:
            self.overruns += 1
            self.most_late_s = max(self.most_late_s, late_s)

    def report(self) -> str | None:
        """Return one line about the overruns; None if there were none."""
        if not self.overruns:
            return None
        times = "once" if self.overruns == 1 else f"{self.overruns} times"
        return f"fell behind the wall clock {times}, by {self.most_late_s * 1000:.0f} ms at most"


class Port(Protocol):
    """Interface of a port that stores its output while virtual time advances, and sends the output afterwards."""

    def flush(self) -> None: ...


class Pacer:
    """Advances the clock of one bench at `speed` times real time; None: as fast as possible.

    `plan` counts events that start or stop virtual time, or change its speed.
    """

    def __init__(self, clock: Clock, speed: float | None = 1.0) -> None:
        self.clock = clock
        self.advancing = False  # True while the bench advances; an action then is one of the bench itself.
        self.passes = 0  # Number of advances; inputs with the same number arrive at the same time.
        self.on_failure: Callable[[AxistwinError], None] | None = None  # Called if a planned action fails; None: raise.
        self.on_defect: Callable[[Exception], None] | None = None  # Called with any other error, a bug, then raised.
        self._to_flush: list[Port] = []
        self._advanced: Signal[[]] = Signal()
        self.plan = 0
        self.agenda_ns = 0  # At full speed virtual time reaches at least this value, even if no event is due.
        self.delays = Delays()
        self._speed = speed
        self._loop: asyncio.AbstractEventLoop | None = None
        self._drive: RealTime | FullSpeed | None = None  # None while virtual time is stopped.

    @property
    def speed(self) -> float | None:
        """Speed of virtual time: 1 is real time, None is full speed.  An invalid speed raises UsageError."""
        return self._speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        checked_speed(speed)
        if self.running:
            self.sync()
        self._speed = speed
        if self.running:
            self._restart()
            self.work()

    @property
    def running(self) -> bool:
        return self._drive is not None

    def start(self, loop: asyncio.AbstractEventLoop | None = None) -> None:
        """Start virtual time, paced by the clock of `loop`; None: of the running event loop."""
        self.clock.patient = False
        self._loop = loop or asyncio.get_running_loop()
        self._restart()
        self.work()

    def stop(self) -> None:
        """Stop virtual time; during an advance, the other events of this nanosecond are still executed."""
        was_running = self.running
        self._cancel()
        if was_running and not self.advancing:
            self.flush()

    def pace(self, clock: Clock) -> None:
        """Replace this pacer's virtual clock; not to be called while virtual time is advancing."""
        clock.patient = self.clock.patient
        self.clock = clock
        if self.running:
            self._restart()
            self.follow_plan()

    def sync(self) -> None:
        """Advance virtual time to now, and execute all due events; must be called before each input."""
        if self.advancing:
            return
        if self._drive is not None:
            self._drive.sync()
        if not self.clock.done:
            self.run(self.finish)

    def work(self) -> None:
        """Execute all events that are due now; must be called after each input."""
        if self.advancing:
            return
        if self._drive is not None:
            self._drive.work()
        else:
            self.sync()
            self.flush()

    def inspect(self, read: Callable[[], T]) -> T:
        """Advance virtual time to now, call `read`, and plan the next advance again.  Return the result of `read`.

        The pacer sleeps while no event is due, even while a motor moves.  Reading the state of a SmartMotor makes the
        motor plan its block again, so that an event may become due earlier.
        """
        self.work()
        try:
            return read()
        finally:
            self.work()

    def follow_plan(self) -> None:
        """Apply the change that an event has requested: a new speed, or a stop."""
        if self._drive is not None:
            self._drive.resume()

    @property
    def behind_s(self) -> float:
        """Delay of the bench against the wall clock at the last advance, in seconds; 0 at full speed."""
        return 0.0 if self._drive is None else self._drive.behind_s

    def report(self) -> str | None:
        """Return one line about delays against the wall clock; None if there were none."""
        return self.delays.report()

    # Functions that advance the bench, then report failed actions, apply changes of the speed, and send output

    def request_flush(self, port: Port) -> None:
        self._to_flush.append(port)

    def subscribe(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback()` after each advance of virtual time; return an unsubscribe function."""
        return self._advanced.subscribe(callback)

    def advance_slice(self, advance: Callable[[Callable[[], bool]], T]) -> T:
        """Advance the bench by one slice with `advance(over)`, outside the pacer's own advances; then flush the ports.

        `advance` must return at the end of a nanosecond, soon after `over()` is True.  Return the result of `advance`.
        """
        limit = Slice()
        found: list[T] = []
        # Call `advance` until it returns without an error.
        while not found:
            self.run(lambda: found.append(advance(limit.over)))
        self.flush()
        return found[0]

    def run(self, advance: Callable[[], None]) -> None:
        """Advance the bench; then call `follow_plan` if an event has changed `plan`."""
        plan, self.advancing = self.plan, True
        self.passes += 1
        try:
            while not self._succeeds(advance) and plan == self.plan:
                pass
            while plan != self.plan and not self._succeeds(self.finish):
                pass
        except Exception as error:
            if self.on_defect is not None:
                self.on_defect(error)
            raise
        finally:
            self.advancing = False
        if plan != self.plan:
            self.flush()
            self.follow_plan()

    def _succeeds(self, advance: Callable[[], None]) -> bool:
        try:
            advance()
        except AxistwinError as error:
            if self.on_failure is None:
                raise
            self.on_failure(error)
            return False
        return True

    def finish(self) -> None:
        self.clock.run_to(self.clock.now)

    def flush(self) -> None:
        """Send the pending output of all ports, then call the functions registered with `subscribe`."""
        while self._to_flush:
            ports, self._to_flush = self._to_flush, []
            for port in ports:
                port.flush()
        self._advanced.emit()

    def _restart(self) -> None:
        assert self._loop is not None
        self._cancel()
        loop, speed = self._loop, self._speed
        self._drive = FullSpeed(self, loop) if speed is None else RealTime(self, loop, speed, self.delays)

    def _cancel(self) -> None:
        self.plan += 1
        if self._drive is not None:
            self._drive.cancel()
            self._drive = None


class Drive(ABC):
    """Advances a bench; not to be used again after `cancel`."""

    def __init__(self, bench: "Pacer", loop: asyncio.AbstractEventLoop) -> None:
        self._bench, self._clock, self._loop = bench, bench.clock, loop
        self._next: asyncio.Handle | None = None
        self._ended = False

    @property
    def behind_s(self) -> float:
        """Seconds by which virtual time was behind the wall clock at the last advance; 0 at full speed."""
        return 0.0

    def sync(self) -> None:  # noqa: B027  # at full speed there is nothing to catch up with
        """Catch up with the wall clock, for at most one slice of real time."""

    @abstractmethod
    def work(self) -> None:
        """Advance the bench, to the wall clock's time if it paces, send output, and plan the next advance."""

    @abstractmethod
    def _turn(self) -> None: ...

    def resume(self) -> None:
        """Let virtual time advance in the next pass of the event loop."""
        self._next = self._next or self._loop.call_soon(self._turn)

    def cancel(self) -> None:
        self._ended = True
        if self._next is not None:
            self._next.cancel()


class RealTime(Drive):
    """Advances a bench at `speed` times real time, from now."""

    def __init__(self, bench: "Pacer", loop: asyncio.AbstractEventLoop, speed: float, delays: Delays) -> None:
        super().__init__(bench, loop)
        self._speed, self._delays = speed, delays
        self._wall_s, self._virtual_ns = loop.time(), bench.clock.now
        self._last_s = self._wall_s
        self._next_at_s = 0.0

    @property
    def behind_s(self) -> float:
        return max(0.0, self._real_s(self._target_ns(self._last_s) - self._clock.now))

    def sync(self) -> None:
        self._last_s = self._loop.time()
        target_ns, due_ns = self._target_ns(self._last_s), self._clock.next_event_ns()
        if due_ns is not None and due_ns <= target_ns:
            self._delays.count(self._real_s(target_ns - due_ns))
        if target_ns > self._clock.now or due_ns == target_ns:
            self._bench.run(lambda: self._advance(target_ns))

    def work(self) -> None:
        self.sync()
        self._bench.flush()
        self._plan_next()

    def _target_ns(self, wall_s: float) -> int:
        return min(self._virtual_ns + int((wall_s - self._wall_s) * self._speed * S), MOST_NS - 1)

    def _real_s(self, duration_ns: int) -> float:
        return duration_ns / S / self._speed

    def _advance(self, target_ns: int) -> None:
        clock, limit = self._clock, Slice()
        due_ns = clock.next_event_ns()
        while due_ns is not None and due_ns <= target_ns:
            if limit.over():
                # After a long interruption, e.g. sleep mode, virtual time does not catch up with real time.
                if self._real_s(target_ns - clock.now) > MAX_LAG_S:
                    self._wall_s, self._virtual_ns = self._last_s, clock.now
                return
            clock.step()
            if self._ended:
                return
            due_ns = clock.next_event_ns()
        if target_ns > clock.now:
            clock.run_to(target_ns)

    def _plan_next(self) -> None:
        """Plan the next advance for the time of the next event, but not earlier than `BLOCK_S` after the last."""
        due_ns = self._clock.next_event_ns()
        if self._ended or due_ns is None:
            return
        due_s = self._wall_s + self._real_s(due_ns - self._virtual_ns)
        at_s = max(due_s, self._last_s + BLOCK_S) if due_s > self._last_s else self._last_s
        if self._next is not None:
            if self._next_at_s <= at_s:
                return
            self._next.cancel()
        self._next, self._next_at_s = self._loop.call_at(at_s, self._turn), at_s

    def _turn(self) -> None:
        self._next = None
        self.work()


class FullSpeed(Drive):
    """Advances a bench while events are due, in slices of real time; between them, sockets are served."""

    def work(self) -> None:
        """Run a slice, unless the next slice is already planned."""
        if self._next is None:
            self._turn()

    @property
    def _idle(self) -> bool:
        """True if no event is planned, except background events that repeat for ever."""
        clock = self._clock
        return (clock.quiet and clock.now >= self._bench.agenda_ns) or clock.next_event_ns() is None

    def _turn(self) -> None:
        self._next = None
        if not self._idle:
            self._bench.run(self._advance)
        self._bench.flush()
        if not self._ended and not self._idle:
            self.resume()

    def _advance(self) -> None:
        limit, step = Slice(), self._clock.step
        step()
        while not self._idle and not self._ended and not limit.over():
            step()
