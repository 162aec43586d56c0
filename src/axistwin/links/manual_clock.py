"""The clock of a served bench, controlled by a test: `advance` and `run_until`.

With a `ManualPacer`, virtual time passes only in these calls.  Before time passes, all data from hosts are received,
and every host thread (`Twin.start`) must be blocked.  The computing time of a host takes no virtual time, so every run
is the same on fast and slow computers.
"""

import math
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

from axistwin.core.errors import LinkError, UsageError
from axistwin.core.units import to_ns, to_seconds
from axistwin.links.host_thread import POLLS, HostThread, pause
from axistwin.links.loop_thread import LoopThread
from axistwin.links.manual_pacer import ManualPacer
from axistwin.links.pacing import Pacer

IDLE_S = 10.0  # Seconds of real time after which a silent host without pending data counts as blocked for ever.
POLL_S = 0.01
SLEPT = (
    "the host sleeps by the wall clock, and virtual time has advanced by {:g} s: "
    "call `time.sleep` as an attribute of `time`, which takes virtual time in a host's thread, or use speed=1.0"
)


class ServedClock:
    """Clock that returns the virtual time of a simulation in another thread."""

    def __init__(self, loop: LoopThread, pacer: Pacer) -> None:
        self._loop, self._pacer = loop, pacer

    @property
    def now(self) -> int:
        """Virtual time in nanoseconds.  If the wall clock paces the bench, virtual time is first advanced to now."""
        if self._pacer.running:
            self._loop.do(self._advance_to_now)
        return self._pacer.clock.now

    @property
    def seconds(self) -> float:
        return to_seconds(self.now)

    def advance(self, seconds: float) -> None:
        """Raise UsageError: only a `ManualClock` can advance; the time of a `ServedClock` passes by itself."""
        raise UsageError(
            f"cannot advance virtual time by {seconds:g} s without a manual clock: "
            'expected speed="manual", e.g. serve("if1", speed="manual")'
        )

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Wait until `condition()` is true (returns True), or for `timeout` seconds of real time (returns False).

        An exception of `condition()` is raised.
        """
        over = threading.Event()
        raised: list[Exception] = []

        def check() -> None:
            try:
                found = not over.is_set() and condition()
            except Exception as error:  # noqa: BLE001  # raised again in the caller's thread
                raised.append(error)
                found = True
            if found:
                over.set()

        unsubscribe = self._loop.do(lambda: self._pacer.subscribe(check))
        try:
            self._loop.do(lambda: self._pacer.inspect(check))
            found = over.wait(timeout)
        finally:
            self._loop.do(unsubscribe)
        if raised:
            raise raised[0]
        return found

    def wait_for(self, host: HostThread, timeout: float) -> Any:
        """Return a host's result, or raise its exception.  Raises LinkError if it has not ended in `timeout` s."""
        host.join(timeout)
        if not host.done:
            raise LinkError(
                f"the function {host.name} of the host program did not return within {timeout:g} s: "
                "use a longer timeout, e.g. result(timeout=60)"
            )
        return host.outcome()

    def add(self, host: HostThread) -> None:
        """Do nothing: only a `ManualClock` waits for hosts; the time of a `ServedClock` passes by itself."""

    def _advance_to_now(self) -> None:
        self._pacer.sync()
        self._pacer.work()


class ManualClock(ServedClock):
    """Clock that stands still except in `advance`, `run_until`, `wait_for`; threads take turns."""

    def __init__(self, loop: LoopThread, pacer: ManualPacer) -> None:
        super().__init__(loop, pacer)
        self._manual_pacer = pacer
        self._hosts: list[HostThread] = []
        self._turn = threading.RLock()

    @property
    def now(self) -> int:
        return self._manual_pacer.clock.now

    def add(self, host: HostThread) -> None:
        """Register a host: time passes only while it waits for an answer, or sleeps (in virtual time)."""
        host.sleep_virtually()
        self._hosts.append(host)

    def advance(self, seconds: float) -> None:
        """Receive all data that hosts have sent, then advance virtual time by `seconds`."""
        if not 0 <= seconds < math.inf:
            raise UsageError(f"cannot advance virtual time by {seconds!r} s: expected 0 or more seconds, e.g. 0.5")
        with self._exclusive("advance"):
            end_ns = self._pacer.clock.later(to_ns(seconds))
            self._run_hosts()
            while not self._advance(end_ns):
                self._run_hosts()

    def run_until(self, condition: Callable[[], object], timeout: float) -> bool:
        """Advance until `condition()`, for at most `timeout` seconds; return True if it is true at the end.

        It is checked at every event, as in `Bench.run_until`, and after hosts have run.
        """
        if not timeout < math.inf:  # nor nan
            raise UsageError(f"invalid timeout {timeout!r}: expected a number of seconds, e.g. 10")
        with self._exclusive("run_until"):
            end_ns = self._pacer.clock.later(to_ns(timeout))
            over = False
            while not over:
                self._run_hosts()
                if condition():
                    return True
                over = self._advance(end_ns, condition)
            return bool(condition())

    def wait_for(self, host: HostThread, timeout: float) -> Any:
        """Advance until a host has ended; return its result, or raise its exception.

        Raises LinkError if the host waits and nothing is sent or received for `timeout` virtual seconds, not counting
        the host's latest sleep.
        """
        with self._exclusive("result"):
            self._run_hosts()
            seen, silent_since = self._traffic, self.now
            while not host.done:
                end_ns = max(self.now + to_ns(timeout), host.wakes_ns or 0)
                if self._advance(end_ns) and self._traffic == seen:
                    self._wait_for_silent_host(host, timeout)
                self._run_hosts()
                if self._traffic != seen or host.done:
                    seen, silent_since = self._traffic, self.now
                elif self.now - silent_since > to_ns(timeout) + host.slept_ns:
                    _fail(timeout)
        return host.outcome()

    @contextmanager
    def _exclusive(self, function: str) -> Iterator[None]:
        """Keep other threads from advancing time.  Raises UsageError in the bench's own thread and in a host's."""
        self._loop.check_outside()
        if any(host.current for host in self._hosts):
            raise UsageError(
                f"cannot call {function} in a host program, because the test controls virtual time: "
                "expected time.sleep, e.g. time.sleep(0.5)"
            )
        with self._turn:
            yield

    @property
    def _traffic(self) -> tuple[int, int]:
        return self._manual_pacer.arrivals, self._manual_pacer.deliveries

    def _advance(self, end_ns: int, condition: Callable[[], object] | None = None) -> bool:
        """Advance until `condition()`, at most to `end_ns`; return False if a host must run earlier."""
        sleepers = [host for host in self._hosts if host.wakes_ns is not None]
        wake_ns = min((host.wakes_ns for host in sleepers if host.wakes_ns is not None), default=end_ns + 1)
        over = self._loop.do(lambda: self._manual_pacer.advance(min(wake_ns, end_ns), condition))
        if not over or self.now < wake_ns:
            return over
        for host in sleepers:
            if host.wakes_ns == wake_ns:
                host.wake()
        return False

    def _run_hosts(self) -> None:
        self._hosts = [host for host in self._hosts if not host.done]
        seen, quiet_polls = (-1, -1), 0
        while quiet_polls < POLLS:
            self._loop.run(self._manual_pacer.receive_all())
            waiting = self._traffic == seen and all(host.blocked() for host in self._hosts)
            seen, quiet_polls = self._traffic, quiet_polls + 1 if waiting else 0
            if not self._hosts:
                break
            pause()
        for host in self._hosts:
            host.sleep_from(self.now)

    def _wait_for_silent_host(self, host: HostThread, timeout: float) -> None:
        if host.sleeps_by_the_wall_clock():
            warnings.warn(SLEPT.format(timeout), stacklevel=2)
        seen = self._traffic
        for _ in range(round(IDLE_S / POLL_S)):
            host.join(POLL_S)
            self._loop.run(self._manual_pacer.receive_all())
            if host.done or self._traffic != seen:
                return
        _fail(timeout)


def _fail(timeout: float) -> NoReturn:
    raise LinkError(
        f"the host program has neither sent nor received data for {timeout:g} s of virtual time: "
        "check which answer the program expects, or use a longer timeout"
    )
