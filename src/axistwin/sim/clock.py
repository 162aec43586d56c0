"""The clock of a bench: a SimPy environment whose time is an integer number of nanoseconds.

A procedure that takes time is a generator; time passes only where it yields.  Events at the same nanosecond happen in
the order in which they were scheduled.  Two runs of the same bench are therefore identical.
"""

from collections.abc import Callable, Collection, Generator
from functools import partial
from heapq import heapify, heappush
from inspect import GEN_RUNNING, getgeneratorstate
from typing import Any

from axistwin.core.errors import UsageError
from axistwin.core.units import MOST_NS
from axistwin.sim.engine import NORMAL, URGENT, Environment, Event, Interrupt, Interruption, Process
from axistwin.sim.signal import Signal

__all__ = ["Clock", "Event", "Interrupt", "Moment", "Procedure", "Process", "interrupt", "kill"]

Procedure = Generator[Event, Any, Any]  # Yields events, and is resumed when they have happened.

LAST = 9  # Rank of external events, which come after all events of the bench itself.
_AFTER_EVERYTHING_ELSE = 1_000  # SimPy executes simultaneous events in the order of their priority numbers.


class _Call(Event):
    _ok, _value = True, None
    callbacks = (lambda event: event._action(),)  # type: ignore[assignment]  # never appended to

    def __init__(self, action: Callable[[], object]) -> None:
        self._action = action


class Clock(Environment):
    """Clock that counts virtual time in whole nanoseconds, from 0."""

    now: int  # Virtual time is an integer, although the library SimPy also allows floats.

    def __init__(self) -> None:
        super().__init__()
        self.patient = True  # False if the clock is paced by real time, so that no event may take seconds to compute.
        self.background = 0  # Number of scheduled events for which a run need not wait, e.g. a lamp's next flash.
        self.interrupted: set[Process] = set()
        self.by_itself = False  # True while the bench itself performs an action at a machine, by its script or a fault.
        self._unobserved = False  # True while `run_to` executes events, and nobody observes the clock between.
        self._ends: Signal[[]] = Signal()

    @property
    def quiet(self) -> bool:
        """True if only background events are scheduled, e.g. the flashing of a lamp."""
        return len(self._queue) <= self.background

    @property
    def done(self) -> bool:
        """True if all events up to the present time have been executed."""
        return not self._queue or self._queue[0][0] > self._now

    def run_to(self, end_ns: int) -> None:
        """Execute all events up to `end_ns`, and set the clock.  Raises UsageError beyond virtual time."""
        end = self._last_at(_possible(end_ns))
        self._unobserved = not self._ends
        try:
            while end.callbacks is not None:  # SimPy sets the callbacks of an event to None when the event happens.
                self.step()
        finally:
            self._unobserved = False
            # After an exception, the event `end` is still scheduled and must be cancelled.
            self._withdraw(end)

    @property
    def free_ns(self) -> int:
        """Time in ns from now to the next event.  0 if a subscriber observes the clock event by event."""
        return int(self._queue[0][0]) - self.now if self._unobserved else 0

    def skip(self, duration_ns: int) -> bool:
        """Advance the clock, and return True, if no event is due and nobody observes the clock until then.

        A procedure that waits for its own timeout may skip the time instead; the effect is the same.
        """
        end_ns = self._now + duration_ns
        if self._unobserved and self._queue[0][0] > end_ns:
            self._now = end_ns
            return True
        return False

    def later(self, duration_ns: int) -> int:
        """Return now plus `duration_ns`.  Raises UsageError for a time after 292 years, the end of virtual time."""
        return _possible(self.now + duration_ns)

    def call_last(self, time_ns: int, action: Callable[[], object], *, rank: int = LAST) -> Callable[[], None]:
        """Call `action` once at `time_ns`, after all other events up to this time, as after `run_to(time_ns)`.

        At one time, the lowest `rank` comes first; the highest is LAST.  Return a function that cancels the action.
        """
        event = self._last_at(time_ns, rank)
        assert event.callbacks is not None
        event.callbacks.append(lambda _: action())  # type: ignore[arg-type]  # the result is not used
        return partial(self._withdraw, event)

    def _withdraw(self, event: Event) -> None:
        if event.callbacks is not None:
            self._queue[:] = [entry for entry in self._queue if entry[-1] is not event]
            heapify(self._queue)

    def _last_at(self, time_ns: int, rank: int = LAST) -> Event:
        """Return an event that happens after all other events that are due by then."""
        event = Event(self)
        event._ok, event._value = True, None  # SimPy expects a success flag and a value in each scheduled event.
        self.schedule(event, priority=_AFTER_EVERYTHING_ELSE + rank, delay=time_ns - self.now)  # type: ignore[arg-type]
        return event

    def subscribe(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call `callback` before each advance of virtual time, after all events of the present time.

        The callback may read the bench but must not change it.  Return an unsubscribe function.
        """
        self._unobserved = False
        unsubscribe = self._ends.subscribe(callback)
        self.step = self._observed_step  # type: ignore[method-assign]

        def end() -> None:
            unsubscribe()
            if not self._ends:
                del self.step

        return end

    def _observed_step(self) -> None:
        if self._queue and self._queue[0][0] > self.now:
            self._ends.emit()
        super().step()

    def next_event_ns(self) -> int | None:
        """Return the time of the next event; None: no event is due before the end of virtual time."""
        queue = self._queue
        return None if not queue or queue[0][0] >= MOST_NS else int(queue[0][0])

    def call_later(self, delay_ns: int, action: Callable[[], object]) -> None:
        """Call `action` once, `delay_ns` nanoseconds from now."""
        assert delay_ns >= 0, "an event in the past"
        heappush(self._queue, (self._now + delay_ns, NORMAL, next(self._eid), _Call(action)))

    def call_unless(self, delay_ns: int, action: Callable[[], object]) -> Callable[[], None]:
        """Call `action` once, as `call_later`, unless the returned function is called before; then nothing is left."""
        event = _Call(action)
        heappush(self._queue, (self._now + delay_ns, NORMAL, next(self._eid), event))
        return partial(self._withdraw, event)

    def call_in_background(self, delay_ns: int, action: Callable[[], object]) -> None:
        """Call `action` once, as `call_later`, but let the simulation end before (see `quiet`)."""
        self.background += 1

        def due() -> None:
            self.background -= 1
            action()

        self.call_later(delay_ns, due)

    def soon(self, action: Callable[[], object]) -> None:
        """Call `action` now, before all other events, but after the running procedure's next `yield`."""
        event = Event(self)
        event._ok, event._value = True, None
        event.callbacks.append(lambda _: action())  # type: ignore[arg-type]  # the result is not used
        self.schedule(event, priority=URGENT)

    def call_outside(self, procedures: Collection[Process], action: Callable[[], object]) -> None:
        """Call `action` now; if one of these procedures is running, at its next `yield`, in the same nanosecond."""
        if self.active_process in procedures:
            self.soon(action)
        else:
            action()


class Moment:
    """Something that happens again and again; a call returns the event of the next time.

    Without such an event nothing is scheduled.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._next: Event | None = None

    def __call__(self) -> Event:
        """Return the event of the next time."""
        if self._next is None:
            self._next = self._clock.event()
        return self._next

    def happens(self) -> None:
        """Continue the procedures that wait."""
        if self._next is not None:
            event, self._next = self._next, None
            event.succeed()


def interrupt(process: Process) -> None:
    """Raise `simpy.Interrupt` in a procedure at the `yield` where it waits, in the same nanosecond.

    No effect on a finished procedure, the caller itself, or one with a pending interrupt.  There is no other way.
    """
    clock = process.env
    assert isinstance(clock, Clock), "procedures belong to a clock"
    if not process.is_alive or process is clock.active_process or process in clock.interrupted:
        return
    clock.interrupted.add(process)
    on_its_way = Interruption(process, None)
    on_its_way.callbacks.append(lambda _: clock.interrupted.discard(process))


def _possible(time_ns: int) -> int:
    if time_ns >= MOST_NS:
        raise UsageError("the virtual time is too large: expected less than 9.22e9 s (292 years)")
    return time_ns


def kill(process: Process) -> None:
    """Abort a procedure, e.g. at a power cut: only its `finally` clauses are executed.

    A pending interrupt is lost.  A procedure that aborts itself ends at its next `yield`.
    """
    if not process.is_alive:
        return
    clock = process.env
    assert isinstance(clock, Clock), "procedures belong to a clock"
    if getgeneratorstate(process._generator) == GEN_RUNNING:
        clock.soon(partial(kill, process))
        return
    waiting = process.target.callbacks
    if process._resume in (waiting or ()):
        waiting.remove(process._resume)
    process._ok, process._value = True, None
    process._generator.close()
