"""Virtual time that passes only when somebody says so, for tests of hosts.

What hosts send is taken in when it comes, and they are told what there is to tell; but time stands still.  `advance`
lets it pass, up to the moment when a host has been told something and nothing more has followed it for a while: then
the host has its turn, before more time passes.
"""

import asyncio
from collections.abc import Callable

from axistwin.bench import Bench
from axistwin.links.pacing import Pacer
from axistwin.units import MS, to_seconds

AFTER_NS = 3 * MS
"""Characters that come within this time belong to what has been told already (about 3 of them at 9600 baud)."""
TURNS = 10
"""Turns of the event loop without anything coming in, after which all that has been sent is in: a client that has just
come needs some."""


class ManualPacer(Pacer):
    """Advances a bench when it is told to, and only then."""

    def __init__(self, bench: Bench) -> None:
        super().__init__(bench.clock, None)
        self.bench = bench
        self.arrivals = 0
        """How often something has come from a host."""
        self.told = 0
        """How often hosts have been told something."""

    def start(self, loop: asyncio.AbstractEventLoop | None = None) -> None:
        """Ports may be used; time stands still."""
        self._loop = loop or asyncio.get_running_loop()

    def sync(self) -> None:
        """Something is about to come in."""
        self.arrivals += 1

    def work(self) -> None:
        """Something has come in: what can be told without time passing is told."""
        self._flush()

    async def take_in(self) -> int:
        """Let in all that hosts have sent by now.  Returns how often something has come in, ever."""
        idle = 0
        while idle < TURNS:
            before = self.arrivals
            await asyncio.sleep(0)
            idle = 0 if self.arrivals != before else idle + 1
        return self.arrivals

    def advance(self, end_ns: int, condition: Callable[[], object] | None = None) -> bool:
        """Let time pass until `end_ns`, until `condition()` is true, or until a host has its turn.

        Returns whether it is all over, that is, not stopped for a host's turn.
        """
        stop_ns = end_ns
        while self._run(stop_ns, condition):
            if self._tell():
                stop_ns = min(end_ns, self.clock.now + AFTER_NS)
            if condition is not None and condition():
                return True
        self._tell()
        return stop_ns >= end_ns

    def _run(self, stop_ns: int, condition: Callable[[], object] | None) -> bool:
        """Whether there was something to tell, or the condition was true, before that time."""
        self.advancing = True
        self.passes += 1
        try:
            return self._run_to(stop_ns, condition)
        finally:
            self.advancing = False

    def _run_to(self, stop_ns: int, condition: Callable[[], object] | None) -> bool:
        if condition is not None:
            return self.bench.run_until(lambda: self._dirty or condition(), to_seconds(stop_ns - self.clock.now))
        clock = self.clock
        while not self._dirty:
            due_ns = clock.next_event_ns()
            if due_ns is None or due_ns > stop_ns:
                clock.run_to(max(stop_ns, clock.now))
                return bool(self._dirty)
            clock.step()
        return True

    def _tell(self) -> bool:
        """Whether a host has been told something."""
        if not self._dirty:
            return False
        self.told += 1
        self._flush()
        return True
