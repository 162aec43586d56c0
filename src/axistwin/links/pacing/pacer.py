"""Pacing of virtual time by the wall clock.

At speed N the pacer advances the bench to the time of the wall clock, at least every 5 ms while events are due, and at
once on input (`real_time.py`).  At full speed (`max`) the pacer executes all due events in slices of 2 ms; sockets are
served between two slices (`full_speed.py`).  An idle bench costs no processor time.

Input always finds the bench at the end of a nanosecond, with all events up to that time executed.
"""

import asyncio
from collections.abc import Callable
from typing import TypeVar

from axistwin.links.pacing.advancing import Advancer
from axistwin.links.pacing.delays import Delays
from axistwin.links.pacing.full_speed import FullSpeed
from axistwin.links.pacing.real_time import RealTime
from axistwin.links.pacing.speeds import checked_speed
from axistwin.sim.clock import Clock

T = TypeVar("T")


class Pacer(Advancer):
    """Advances the clock of one bench at `speed` times real time; None: as fast as possible."""

    def __init__(self, clock: Clock, speed: float | None = 1.0) -> None:
        super().__init__(clock)
        self.delays = Delays()
        self._speed = speed
        self._loop: asyncio.AbstractEventLoop | None = None
        self._drive: RealTime | FullSpeed | None = None
        """The object that advances virtual time; None while virtual time is stopped."""

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
        """True while virtual time passes."""
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

    def _restart(self) -> None:
        assert self._loop is not None
        self._cancel()
        if self._speed is None:
            self._drive = FullSpeed(self, self._loop)
        else:
            self._drive = RealTime(self, self._loop, self._speed, self.delays)

    def _cancel(self) -> None:
        self.plan += 1
        if self._drive is not None:
            self._drive.cancel()
            self._drive = None
