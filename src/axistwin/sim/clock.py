"""The one clock of a bench: a SimPy environment whose time is an integer number of nanoseconds.

A procedure that takes time is a generator; time passes only where it yields.  Events at the same nanosecond
happen in the order in which they were scheduled, so that two runs of the same bench are identical.
"""

from collections.abc import Callable, Generator
from heapq import heapify
from typing import Any

import simpy
from simpy.core import Infinity
from simpy.events import Event, Process

__all__ = ["Clock", "Event", "Procedure", "Process", "kill"]

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
        """Let everything happen that is due up to and including `end_ns`; the clock then stands there."""
        end = self._last_at(end_ns)
        while end.callbacks is not None:  # until it has happened
            self.step()

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
                self._queue[:] = [entry for entry in self._queue if entry[-1] is not event]
                heapify(self._queue)

        return take_back

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
        """When something happens next, or None while nothing is due."""
        due = self.peek()
        return None if due == Infinity else int(due)

    def call_later(self, delay_ns: int, action: Callable[[], object]) -> None:
        """Do `action` once, `delay_ns` from now."""
        event = self.timeout(delay_ns)
        assert event.callbacks is not None
        event.callbacks.append(lambda _: action())  # type: ignore[arg-type]  # what it returns is nobody's affair


def kill(process: Process) -> None:
    """End a procedure at once, as a power cut does: it is not resumed; only its `finally` clauses run."""
    if not process.is_alive:
        return
    waiting = process.target.callbacks
    if process._resume in (waiting or ()):
        waiting.remove(process._resume)
    process._generator.close()
