"""The one clock of a bench: a SimPy environment whose time is an integer number of nanoseconds.

A procedure that takes time is a generator; time passes only where it yields.  Events at the same nanosecond
happen in the order in which they were scheduled, so that two runs of the same bench are identical.
"""

from collections.abc import Callable, Generator
from functools import partial
from heapq import heapify
from inspect import GEN_RUNNING, getgeneratorstate
from typing import Any

import simpy
from simpy.events import URGENT, Event, Interruption, Process

from axistwin.errors import UsageError
from axistwin.units import MOST_NS

__all__ = ["Clock", "Event", "Procedure", "Process", "interrupt", "kill"]

Procedure = Generator[Event, Any, Any]
"""A device procedure told top to bottom: it yields events and is resumed when they have happened."""

LAST = 9
"""The rank of what comes from outside, after all that the bench does itself."""
_AFTER_EVERYTHING_ELSE = 1_000  # a SimPy priority: 0 urgent, 1 normal


class Clock(simpy.Environment):
    """Virtual time in integer nanoseconds, from 0."""

    now: int  # SimPy also allows floats; here time is an integer

    def __init__(self) -> None:
        super().__init__()
        self.patient = True
        """Whether nobody outside minds if a nanosecond takes seconds to compute; who sees it in real time does."""
        self.background = 0
        """Events to come that only keep up an appearance, such as the next flash of a lamp that somebody watches."""
        self.acting = False
        """Whether somebody outside is doing something right now, of which all that is done meanwhile is part."""
        self.interrupted: set[Process] = set()
        """Procedures with an interrupt on its way."""
        self.by_itself = False
        """Whether what is done to machines right now the bench does by itself: its script, a fault."""
        self._onlookers: list[Callable[[], None]] = []

    @property
    def quiet(self) -> bool:
        """Whether nothing more happens by itself but what goes on in the background for ever."""
        return len(self._queue) <= self.background

    @property
    def done(self) -> bool:
        """Whether all has happened that is due by now."""
        return not self._queue or self._queue[0][0] > self._now

    def run_to(self, end_ns: int) -> None:
        """Let everything happen that is due up to and including `end_ns`; the clock then stands there.

        Raises UsageError for a time after the end of virtual time.
        """
        end = self._last_at(_possible(end_ns))
        try:
            while end.callbacks is not None:  # until it has happened
                self.step()
        finally:
            if end.callbacks is not None:  # something was raised
                self._withdraw(end)

    def later(self, duration_ns: int) -> int:
        """The time so much later than now.  Raises UsageError if that is after the end of virtual time."""
        return _possible(self.now + duration_ns)

    def after_all(self, time_ns: int, action: Callable[[], object], *, rank: int = LAST) -> Callable[[], None]:
        """Do `action` once, at that time, when everything else has happened that is due by then.

        That is where it would be done by who calls `run_to(time_ns)` and then does it.  Of several that come after all
        else those of a lower `rank`, up to LAST, come first.  Returns what takes it back.
        """
        event = self._last_at(time_ns, rank)
        assert event.callbacks is not None
        event.callbacks.append(lambda _: action())  # type: ignore[arg-type]  # what it returns is nobody's affair

        def take_back() -> None:
            if event.callbacks is not None:
                self._withdraw(event)

        return take_back

    def _withdraw(self, event: Event) -> None:
        self._queue[:] = [entry for entry in self._queue if entry[-1] is not event]
        heapify(self._queue)

    def _last_at(self, time_ns: int, rank: int = LAST) -> Event:
        """An event that happens when everything else has that is due by then."""
        event = Event(self)
        event._ok, event._value = True, None  # triggered by the passing of time, as simpy.Timeout does it
        self.schedule(event, priority=_AFTER_EVERYTHING_ELSE + rank, delay=time_ns - self.now)  # type: ignore[arg-type]
        return event

    def look_on(self, onlooker: Callable[[], None]) -> Callable[[], None]:
        """Call `onlooker` at the end of each nanosecond in which something happens.  Returns what ends that.

        It may look at everything and must change nothing.  Until somebody looks on, it costs nothing.
        """
        self._onlookers.append(onlooker)
        self.step = self._watched_step  # type: ignore[method-assign]

        def look_away() -> None:
            self._onlookers.remove(onlooker)
            if not self._onlookers:
                del self.step

        return look_away

    def _watched_step(self) -> None:
        if self._queue and self._queue[0][0] > self.now:
            for onlooker in tuple(self._onlookers):
                onlooker()
        super().step()

    def next_event_ns(self) -> int | None:
        """When something happens next, or None while nothing is due before the end of virtual time."""
        due = self.peek()
        return None if due >= MOST_NS else int(due)

    def call_later(self, delay_ns: int, action: Callable[[], object]) -> None:
        """Do `action` once, `delay_ns` from now."""
        event = self.timeout(delay_ns)
        assert event.callbacks is not None
        event.callbacks.append(lambda _: action())  # type: ignore[arg-type]  # what it returns is nobody's affair

    def soon(self, action: Callable[[], object]) -> None:
        """Do `action` once, in this nanosecond and before all else that is due, when the present procedure waits."""
        event = Event(self)
        event._ok, event._value = True, None
        event.callbacks.append(lambda _: action())  # type: ignore[arg-type]  # what it returns is nobody's affair
        self.schedule(event, priority=URGENT)


def interrupt(process: Process) -> None:
    """Interrupt a procedure where it waits: it is resumed there with `simpy.Interrupt`, in this very nanosecond.

    Nothing happens if the procedure is over, is the one that asks, or has an interrupt on its way already.  Procedures
    are interrupted in no other way.
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
        raise UsageError(
            "virtual time ends after 292 years, at 9.22e9 s: let less time pass, or begin with a new bench"
        )
    return time_ns


def kill(process: Process) -> None:
    """End a procedure at once, as a power cut does: it is not resumed; only its `finally` clauses run.

    It is over then, so that an interrupt on its way reaches nobody.  A procedure that ends itself does so
    where it waits next.
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
