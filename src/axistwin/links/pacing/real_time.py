"""Virtual time that follows the wall clock: the bench is advanced when an event is due, and on input."""

import asyncio

from axistwin.links.pacing.advancing import Advancer
from axistwin.links.pacing.delays import Delays
from axistwin.links.pacing.slices import Slice
from axistwin.units import MOST_NS, S

BLOCK_S = 0.005
"""Shortest interval between two advances of the bench by the wall clock."""
MAX_LAG_S = 1.0
"""Largest delay in seconds that is caught up; after a larger delay, virtual time continues from its present value."""


class RealTime:
    """Advances a bench at `speed` times real time, from now; not to be used again after `cancel`."""

    def __init__(self, bench: Advancer, loop: asyncio.AbstractEventLoop, speed: float, delays: Delays) -> None:
        self._bench, self._clock, self._loop = bench, bench.clock, loop
        self._speed, self._delays = speed, delays
        self._wall_s, self._virtual_ns = loop.time(), bench.clock.now
        self._last_s = self._wall_s
        self._next: asyncio.Handle | None = None
        self._next_at_s = 0.0
        self._ended = False

    @property
    def behind_s(self) -> float:
        """Seconds by which virtual time was behind the wall clock at the last advance."""
        return max(0.0, self._real_s(self._target_ns(self._last_s) - self._clock.now))

    def sync(self) -> None:
        """Catch up with the wall clock, for at most one slice of real time."""
        self._last_s = self._loop.time()
        target_ns, due_ns = self._target_ns(self._last_s), self._clock.next_event_ns()
        if due_ns is not None and due_ns <= target_ns:
            self._delays.count(self._real_s(target_ns - due_ns))
        if target_ns > self._clock.now or due_ns == target_ns:
            self._bench.run(lambda: self._advance(target_ns))

    def work(self) -> None:
        """Advance virtual time to the wall clock's time, send output, and plan the next advance."""
        self.sync()
        self._bench.flush()
        self._plan_next()

    def resume(self) -> None:
        """Let virtual time advance in the next pass of the event loop."""
        self._next = self._next or self._loop.call_soon(self._tick)

    def cancel(self) -> None:
        """Stop advancing virtual time."""
        self._ended = True
        if self._next is not None:
            self._next.cancel()

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
        self._next, self._next_at_s = self._loop.call_at(at_s, self._tick), at_s

    def _tick(self) -> None:
        self._next = None
        self.work()
