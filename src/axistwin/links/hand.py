"""The clock of a served bench in the hands of a test: `advance` and `run_until`, and hosts that are given their time.

With a `ManualPacer` time passes in these calls only.  Before it does, all that hosts have sent is taken in, and those
that run in a thread of ours (`start`) have come to wait for something.  So a run is the same every time, on however
slow a machine: a host's time to think is no virtual time.
"""

import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from axistwin.errors import LinkError, UsageError
from axistwin.links.host_thread import LOOKS, HostThread, pause
from axistwin.links.manual import ManualPacer
from axistwin.links.pacing import Pacer
from axistwin.links.thread import LoopThread
from axistwin.units import to_ns, to_seconds

SILENT_S = 10.0
"""A host that waits for so long by its own clock, with nothing to come, waits for ever."""
LOOK_S = 0.01
A_HOST = "a host cannot let time pass: it passes while the host waits for an answer, or for the end of a sleep"


class ServedClock:
    """Virtual time of a bench whose ports are served by an event loop in a thread, at the pacer's speed."""

    def __init__(self, loop: LoopThread, pacer: Pacer) -> None:
        self._loop, self._pacer = loop, pacer

    @property
    def now(self) -> int:
        """Virtual time in nanoseconds, brought to now by the wall clock where that paces it."""
        if self._pacer.running:
            self._loop.do(self._bring_to_now)
        return self._pacer.clock.now

    @property
    def seconds(self) -> float:
        """Virtual time in seconds."""
        return to_seconds(self.now)

    def advance(self, seconds: float) -> None:
        """Let virtual time pass.  Raises UsageError where it does so by itself."""
        raise UsageError(f'time passes by itself here, so not by {seconds:g} s: serve with speed="manual"')

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Wait until `condition()` is true or `timeout` seconds of real time have passed; tells which.

        What `condition()` raises is raised here.
        """
        over = threading.Event()
        raised: list[Exception] = []

        def look() -> None:
            try:
                found = not over.is_set() and condition()
            except Exception as error:  # noqa: BLE001  # it belongs to the caller, not to the loop
                raised.append(error)
                found = True
            if found:
                over.set()

        unwatch = self._loop.do(lambda: self._pacer.watch(look))
        try:
            self._loop.do(lambda: self._pacer.look(look))
            found = over.wait(timeout)
        finally:
            self._loop.do(unwatch)
        if raised:
            raise raised[0]
        return found

    def attend(self, host: HostThread, timeout: float) -> Any:
        """Wait for a host, `timeout` seconds at most.  Returns what it has returned, raises what it has raised."""
        host.join(timeout)
        if not host.done:
            raise LinkError(f"the host is not done after {timeout:g} s: give it a longer timeout")
        return host.outcome()

    def add(self, host: HostThread) -> None:
        """A host that has its turn before time passes."""

    def _bring_to_now(self) -> None:
        self._pacer.sync()
        self._pacer.work()


class ManualClock(ServedClock):
    """Virtual time that passes in these calls only; calls of several threads pass theirs one after the other."""

    def __init__(self, loop: LoopThread, pacer: ManualPacer) -> None:
        super().__init__(loop, pacer)
        self._by_hand = pacer
        self._hosts: list[HostThread] = []
        self._turn = threading.RLock()

    @property
    def now(self) -> int:
        """Virtual time in nanoseconds."""
        return self._by_hand.clock.now

    def add(self, host: HostThread) -> None:
        """A host that has its turn before time passes."""
        self._hosts.append(host)

    def advance(self, seconds: float) -> None:
        """Let virtual time pass.  What hosts have sent before is heard first."""
        if not 0 <= seconds < math.inf:
            raise UsageError(f"time runs forwards only, and not for ever: advance({seconds!r})")
        with self._alone():
            end_ns = self._pacer.clock.later(to_ns(seconds))
            self._settle()
            while not self._pass(end_ns):
                self._settle()

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Let time pass until `condition()` is true or `timeout` virtual seconds have passed; tells which.

        It is asked as `Bench.run_until` does, and whenever hosts have had their turn.
        """
        if not timeout < math.inf:  # nor nan
            raise UsageError(f"one cannot wait for ever: run_until(…, timeout={timeout!r})")
        with self._alone():
            end_ns = self._pacer.clock.later(to_ns(timeout))
            over = False
            while not over:
                self._settle()
                if condition():
                    return True
                over = self._pass(end_ns, condition)
            return bool(condition())

    def attend(self, host: HostThread, timeout: float) -> Any:
        """Let time pass until a host is done.  Returns what it has returned, raises what it has raised.

        Raises LinkError if it waits though nobody has said anything for `timeout` virtual seconds.
        """
        with self._alone():
            while self._still_at_work(host):
                seen = self._words
                if self._pass(self.now + to_ns(timeout)) and self._words == seen:
                    self._wait_for_word(host, timeout)
        return host.outcome()

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Nobody else lets time pass meanwhile.

        Raises UsageError in the bench's own thread, and in that of a host, whose turn is over before time passes.
        """
        self._loop.check_outside()
        if any(host.current for host in self._hosts):
            raise UsageError(A_HOST)
        with self._turn:
            yield

    @property
    def _words(self) -> tuple[int, int]:
        return self._by_hand.arrivals, self._by_hand.told

    def _pass(self, end_ns: int, condition: Callable[[], object] | None = None) -> bool:
        return self._loop.do(lambda: self._by_hand.advance(end_ns, condition))

    def _still_at_work(self, host: HostThread) -> bool:
        self._settle()
        return not host.done

    def _settle(self) -> None:
        """Take in what hosts have sent, until those of ours wait for something."""
        self._hosts = [host for host in self._hosts if not host.done]
        seen, calm = (-1, -1), 0
        while calm < LOOKS:
            self._loop.run(self._by_hand.take_in())
            waiting = self._words == seen and all(host.asleep() for host in self._hosts)
            seen, calm = self._words, calm + 1 if waiting else 0
            if not self._hosts:
                break
            pause()

    def _wait_for_word(self, host: HostThread, timeout: float) -> None:
        """Nothing is to come; perhaps the host waits by its own clock, and goes on."""
        seen = self._words
        for _ in range(round(SILENT_S / LOOK_S)):
            host.join(LOOK_S)
            self._loop.run(self._by_hand.take_in())
            if host.done or self._words != seen:
                return
        raise LinkError(f"the host waits for something that has not come within {timeout:g} s of virtual time")
