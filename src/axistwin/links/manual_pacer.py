"""A pacer that advances virtual time on request only, for tests of hosts.

Input from hosts is received, and pending output is sent, while virtual time is stopped.  `advance` lets time pass until
a host has received output and no more output follows for 3 ms.  Then the host runs, before more time passes.
"""

import asyncio
from collections.abc import Callable

from axistwin.bench import Bench
from axistwin.core.units import MS, to_seconds
from axistwin.links.pacing import Pacer
from axistwin.sim.signal import Signal

SAME_ANSWER_NS = 3 * MS  # Longest pause within an answer of a controller (about 3 characters at 9600 baud).
IDLE_TURNS = 10  # Turns of the event loop without input after which none is pending; a new client takes several.


class ManualPacer(Pacer):
    """Lets virtual time pass only when a test calls the method `advance`."""

    def __init__(self, bench: Bench) -> None:
        super().__init__(bench.clock, None)
        self.bench = bench
        self.arrivals = 0  # Number of inputs that hosts have sent up to now.
        self.deliveries = 0  # Number of times that output was sent to hosts.
        self.settling: Signal[[]] = Signal()  # A port then hurries what the system still has between both ends.

    def start(self, loop: asyncio.AbstractEventLoop | None = None) -> None:
        """Leave virtual time stopped until a test calls the method `advance`."""

    def sync(self) -> None:
        self.arrivals += 1

    def work(self) -> None:
        self.flush()

    async def receive_all(self) -> int:
        """Receive all data that hosts have sent so far.  Returns the number of inputs so far."""
        idle = 0
        self.settling.emit()
        while idle < IDLE_TURNS:
            before = self.arrivals
            await asyncio.sleep(0)
            idle = 0 if self.arrivals != before else idle + 1
        return self.arrivals

    def advance(self, end_ns: int, condition: Callable[[], object] | None = None) -> bool:
        """Advance to `end_ns`, or until `condition()`; return False if a host must run before."""
        stop_ns = end_ns
        while self._advance_to(stop_ns, condition):
            if self._deliver():
                stop_ns = min(end_ns, self.clock.now + SAME_ANSWER_NS)
            if condition is not None and condition():
                return True
        self._deliver()
        return stop_ns >= end_ns

    def _advance_to(self, stop_ns: int, condition: Callable[[], object] | None) -> bool:
        self.advancing = True
        self.passes += 1
        try:
            return self._run_to(stop_ns, condition)
        finally:
            self.advancing = False

    def _run_to(self, stop_ns: int, condition: Callable[[], object] | None) -> bool:
        if condition is not None:
            return self.bench.run_until(lambda: self._to_flush or condition(), to_seconds(stop_ns - self.clock.now))
        clock = self.clock
        while not self._to_flush:
            due_ns = clock.next_event_ns()
            if due_ns is None or due_ns > stop_ns:
                clock.run_to(max(stop_ns, clock.now))
                return bool(self._to_flush)
            clock.step()
        return True

    def _deliver(self) -> bool:
        if not self._to_flush:
            return False
        self.deliveries += 1
        self.flush()
        self.settling.emit()
        return True
