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
    """A pacer advances virtual time in proportion to real time, or as fast as the computer can.

    `speed`: ratio of virtual time to real time, e.g. 2; None: as fast as the computer can.
    """

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
        """Start virtual time; an asyncio event loop then advances the simulation.

        `loop`: the event loop; None selects the event loop that calls this method.
        """
        self.clock.patient = False
        self._loop = loop or asyncio.get_running_loop()
        self._restart()
        self.work()

    def stop(self) -> None:
        """Stop virtual time.

        If virtual time is stopped during an advance, the other events of the present nanosecond are still executed.
        """
        was_running = self.running
        self._cancel()
        if was_running and not self.advancing:
            self.flush()

    def pace(self, clock: Clock) -> None:
        """Replace the virtual clock of this pacer by `clock`.

        Do not call this method while virtual time is advancing.
        """
        clock.patient = self.clock.patient
        self.clock = clock
        if self.running:
            self._restart()
            self.follow_plan()

    def sync(self) -> None:
        """Let virtual time catch up with the wall clock, and execute all due events of the simulation.

        Must be called before each input, e.g. before a host's data are passed to a serial port.
        """
        if self.advancing:
            return
        if self._drive is not None:
            self._drive.sync()
        if not self.clock.done:
            self.run(self.finish)

    def work(self) -> None:
        """Execute all events that are due now.

        Must be called after each input, e.g. after a host's data have been passed to a serial port.
        """
        if self.advancing:
            return
        if self._drive is not None:
            self._drive.work()
        else:
            self.sync()
            self.flush()

    def inspect(self, read: Callable[[], T]) -> T:
        """Execute all due events of the simulation.  Then call the function `read` and return its result.

        After the call of `read`, the pacer plans the next advance of virtual time.

        The pacer sleeps while no event is due, even while a motor moves.  A SmartMotor computes a block of samples
        ahead.  After a read of its state, the motor plans this block again, and an event may become due earlier.
        """
        self.work()
        try:
            return read()
        finally:
            self.work()

    def follow_plan(self) -> None:
        """Schedule the next advance of virtual time.

        Called after virtual time has been started or stopped, or after its speed has been changed.
        """
        if self._drive is not None:
            self._drive.resume()

    @property
    def behind_s(self) -> float:
        """Seconds by which virtual time was behind the wall clock at the last advance of virtual time.

        The result is 0 if virtual time does not follow the wall clock.
        """
        return 0.0 if self._drive is None else self._drive.behind_s

    def report(self) -> str | None:
        """Return a text about delays of virtual time, e.g. "fell behind the wall clock once, by 40 ms at most".

        Return None if virtual time has never fallen behind the wall clock.
        """
        return self.delays.report()

    def _restart(self) -> None:
        """Create a new `RealTime` or `FullSpeed` object, which advances virtual time at the present speed."""
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
