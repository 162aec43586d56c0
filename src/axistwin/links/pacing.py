"""The only place where virtual time meets the wall clock.

At speed N the bench is advanced to the time that the wall clock says, in blocks of about 5 ms or when something comes
in.  At full speed (`max`) everything that is due happens at once, in slices of about 2 ms between two looks at the
sockets.  In either case nothing is done while nothing is due.

What comes in finds the bench at the end of a nanosecond: everything has happened that is due by then.  So the run can
be repeated: `run_to` that time, then the same comes in.
"""

import asyncio
from collections.abc import Callable
from time import perf_counter
from typing import Protocol, TypeVar

from axistwin.errors import AxistwinError, UsageError
from axistwin.numbers import NumberError, real, shortened
from axistwin.sim.clock import Clock
from axistwin.units import MOST_NS, S

MOST_SPEED = 1e6
"""Times real time.  No machine is that fast; virtual time would soon end."""
SLICE_S = 0.002
"""So long the bench may work between two looks at the sockets."""
BLOCK_S = 0.005
"""At most this often the bench is advanced by the wall clock."""
LATE_S = 0.025
"""What happens later than this has fallen behind, and is counted."""
GIVEN_UP_S = 1.0
"""More than this is never caught up: virtual time goes on from where it is."""


T = TypeVar("T")


class Port(Protocol):
    """Something that has words for the outside once the bench has been advanced."""

    def flush(self) -> None:
        """Hand them over."""


def read_speed(text: str) -> float | None:
    """`"2.5"` as a number, up to a million, `"max"` as None.  Raises UsageError."""
    if text == "max":
        return None
    try:
        speed = real(text)
    except NumberError:
        speed = 0.0
    return _possible(speed, text)


def _possible(speed: float, text: str) -> float:
    if not 0 < speed <= MOST_SPEED:
        raise UsageError(
            f"no speed {shortened(text)}: give a number such as 1 (real time) or 0.5, up to 1000000, or max"
        )
    return speed


class Pacer:
    """Advances the clock of one bench: `speed` times real time, or as fast as it goes (None)."""

    def __init__(self, clock: Clock, speed: float | None = 1.0) -> None:
        self.clock = clock
        self.advancing = False
        """Whether the bench is being advanced right now: what is done to it then, it does itself."""
        self.passes = 0
        """How often it has been advanced.  What comes in twice with no pass in between comes in together."""
        self.blocks = 0
        """How often something was due when it was advanced by the wall clock."""
        self.overruns = 0
        """In how many of these blocks it happened too late."""
        self.most_late_s = 0.0
        self.troubled: Callable[[AxistwinError], None] | None = None
        """Who is told when something that was planned on the bench cannot be done; all else goes on.

        None: that is raised.
        """
        self.broken: Callable[[Exception], None] | None = None
        """Called with an error that the bench has raised while it was advanced, a defect; then it is raised."""
        self.agenda_ns = 0
        """As fast as it goes, it goes on at least up to here, though nothing happens by itself."""
        self._speed = speed
        self._dirty: list[Port] = []
        self._watchers: list[Callable[[], None]] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._next: asyncio.Handle | None = None
        self._next_at_s = 0.0
        self._last_s = 0.0
        self._wall_s, self._virtual_ns = 0.0, 0
        self._plan = 0  # which plan to advance is the present one; who finds another one ends

    @property
    def speed(self) -> float | None:
        """Times real time, or None: as fast as it goes.  Set at any time, it counts from then on.

        Raises UsageError for what is no speed.
        """
        return self._speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        speed = None if speed is None else _possible(speed, f"{speed:g}")
        if self._loop is None:
            self._speed = speed
        else:
            self.sync()
            self._speed = speed
            self._begin(self._loop)

    @property
    def running(self) -> bool:
        """Whether virtual time passes."""
        return self._loop is not None

    def start(self, loop: asyncio.AbstractEventLoop | None = None) -> None:
        """From now on virtual time passes, by the clock of this event loop or the one that is running."""
        self.clock.patient = False
        self._begin(loop or asyncio.get_running_loop())

    def stop(self) -> None:
        """Virtual time stands still.  Called while something happens: as soon as all has that is due by now."""
        was_running, self._loop = self._loop is not None, None
        self._forget_plan()
        if was_running and not self.advancing:
            self._flush()

    def exchange(self, clock: Clock) -> None:
        """Advance this clock from now on, from where it is, and the one before no more.  Not while it is advanced."""
        clock.patient = self.clock.patient
        self.clock = clock
        if self._loop is not None:
            self._begin_again(self._loop)
            self._next = self._loop.call_soon(self._tick)

    def mark(self, port: Port) -> None:
        """This port wants to be flushed when the bench has been advanced."""
        self._dirty.append(port)

    def watch(self, watcher: Callable[[], None]) -> Callable[[], None]:
        """Call `watcher` whenever the bench has been advanced.  Returns what ends the watching."""
        self._watchers.append(watcher)
        return lambda: self._watchers.remove(watcher)

    def sync(self) -> None:
        """Something is about to come in: bring virtual time to the moment of its arrival, and all to happen by then."""
        if self.advancing:
            return
        if self._speed is not None and self._loop is not None:
            self._advance(self._loop.time())
        if not self.clock.done:
            self._pass(self._finish)

    def work(self) -> None:
        """Something has come in: let happen what is due now."""
        if self.advancing:
            return
        if self._loop is None:
            self.sync()
            self._flush()
        elif self._speed is not None:
            self._advance(self._loop.time())
            self._flush()
            self._sleep()
        elif self._next is None:  # else a slice is coming anyway, and the sockets have their turn first
            self._slice()

    def look(self, looking: Callable[[], object]) -> None:
        """Bring virtual time to now and have somebody look into the bench.

        It sleeps while nothing is due, also while a motor runs; and whoever looks into a motor has it plan anew, so
        that something may be due earlier than it was.
        """
        self.work()
        looking()
        self.work()

    def by_hand(self, advance: Callable[[Callable[[], bool]], T]) -> T:
        """While virtual time stands still: have the bench advanced by `advance(over)`, and hand over its words.

        It ends with a nanosecond, and soon after `over()` says that it is the sockets' turn.  Returns what it returns.
        """
        end_s = perf_counter() + SLICE_S
        found: list[T] = []
        while not found:  # again if something went wrong
            self._pass(lambda: found.append(advance(lambda: perf_counter() >= end_s)))
        self._flush()
        return found[0]

    @property
    def behind_s(self) -> float:
        """Seconds by which the bench has fallen behind the wall clock when it was advanced last; 0 at full speed."""
        if self._speed is None or self._loop is None:
            return 0.0
        return max(0.0, (self._target_ns(self._last_s) - self.clock.now) / S / self._speed)

    def report(self) -> str | None:
        """What there is to tell about falling behind, in one line."""
        if not self.overruns:
            return None
        times = "once" if self.overruns == 1 else f"{self.overruns} times"
        return f"fell behind the wall clock {times}, by {self.most_late_s * 1000:.0f} ms at most"

    def _begin(self, loop: asyncio.AbstractEventLoop) -> None:
        """From now on, from where virtual time is."""
        self._begin_again(loop)
        self.work()

    def _begin_again(self, loop: asyncio.AbstractEventLoop) -> None:
        self._forget_plan()
        self._loop = loop
        self._wall_s, self._virtual_ns = loop.time(), self.clock.now

    def _forget_plan(self) -> None:
        self._plan += 1
        if self._next is not None:
            self._next.cancel()
            self._next = None

    # Advancing the bench

    def _pass(self, advance: Callable[[], None]) -> None:
        """Have the bench advanced; if the plan is another one afterwards, go on with that."""
        plan, self.advancing = self._plan, True
        self.passes += 1
        try:
            while not self._done(advance) and plan == self._plan:
                pass
            while plan != self._plan and not self._done(self._finish):
                pass
        except Exception as error:
            if self.broken is not None:
                self.broken(error)
            raise
        finally:
            self.advancing = False
        if plan != self._plan:
            self._renew()

    def _done(self, advance: Callable[[], None]) -> bool:
        """Have the bench advanced; returns whether nothing went wrong."""
        try:
            advance()
        except AxistwinError as error:
            if self.troubled is None:
                raise
            self.troubled(error)
            return False
        return True

    def _finish(self) -> None:
        """Let happen what is due by now."""
        self.clock.run_to(self.clock.now)

    def _renew(self) -> None:
        """Somebody has stopped or started it, or set its speed, in the middle of something."""
        self._flush()
        if self._loop is not None:
            self._next = self._next or self._loop.call_soon(self._tick)

    def _tick(self) -> None:
        self._next = None
        self.work()

    # As fast as it goes

    @property
    def _idle(self) -> bool:
        """Whether nothing is to be done."""
        clock = self.clock
        return (clock.quiet and clock.now >= self.agenda_ns) or clock.next_event_ns() is None

    def _slice(self) -> None:
        self._next = None
        if not self._idle:
            self._pass(self._rush)
        self._flush()
        self._go_on()

    def _go_on(self) -> None:
        if self._next is None and self._loop is not None and not self._idle:
            self._next = self._loop.call_soon(self._slice)

    def _rush(self) -> None:
        clock, plan, end_s = self.clock, self._plan, perf_counter() + SLICE_S
        clock.step()
        while not self._idle and plan == self._plan and perf_counter() < end_s:
            clock.step()

    # By the wall clock

    def _advance(self, wall_s: float) -> None:
        """Bring virtual time to `wall_s`, or as near as a slice allows."""
        assert self._speed is not None
        self._last_s = wall_s
        target_ns = self._target_ns(wall_s)
        due_ns = self.clock.next_event_ns()
        if due_ns is not None and due_ns <= target_ns:
            self._account((target_ns - due_ns) / S / self._speed)
        if target_ns > self.clock.now or due_ns == target_ns:
            self._pass(lambda: self._follow(target_ns, wall_s))

    def _target_ns(self, wall_s: float) -> int:
        """The virtual time that belongs to this time of the wall clock."""
        assert self._speed is not None
        return min(self._virtual_ns + int((wall_s - self._wall_s) * self._speed * S), MOST_NS - 1)

    def _follow(self, target_ns: int, wall_s: float) -> None:
        clock, plan, end_s = self.clock, self._plan, perf_counter() + SLICE_S
        due_ns = clock.next_event_ns()
        while due_ns is not None and due_ns <= target_ns:
            if perf_counter() >= end_s:
                self._give_up(target_ns, wall_s)
                return
            clock.step()
            if plan != self._plan:
                return
            due_ns = clock.next_event_ns()
        if target_ns > clock.now:
            clock.run_to(target_ns)

    def _account(self, late_s: float) -> None:
        self.blocks += 1
        if late_s > LATE_S:
            self.overruns += 1
            self.most_late_s = max(self.most_late_s, late_s)

    def _give_up(self, target_ns: int, wall_s: float) -> None:
        """Forget what cannot be caught up: the bench was too slow, or the machine was asleep."""
        assert self._speed is not None
        if (target_ns - self.clock.now) / S / self._speed > GIVEN_UP_S:
            self._wall_s, self._virtual_ns = wall_s, self.clock.now

    def _sleep(self) -> None:
        """Wake up when something is due, but not more often than once in a block."""
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

    # Out

    def _flush(self) -> None:
        while self._dirty:
            dirty, self._dirty = self._dirty, []
            for port in dirty:
                port.flush()
        for watcher in tuple(self._watchers):
            watcher()
