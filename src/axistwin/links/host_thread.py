"""A host program in a thread.  Virtual time may pass only while the thread is blocked.

The operating system reports a thread that waits for characters, a lock or a timer as sleeping.  The state is polled
several times, because a thread that waits for Python's interpreter lock also sleeps for a moment.

`time.sleep` in the thread of a host takes virtual time: while hosts run, it is replaced by a function that calls the
original in all other threads.
"""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any, SupportsIndex

from axistwin.core.units import to_ns

POLLS, POLL_S = 3, 0.0003  # Number of polls in which a blocked thread must be sleeping, and seconds between two polls.
REACTION_S = 0.02  # Seconds without activity after which a host counts as blocked, without reported states.


class HostThread:
    """Runs a host program, i.e. a Python function, in a separate thread."""

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...], keywords: dict[str, Any]) -> None:
        self._call = partial(function, *arguments, **keywords)
        self._virtual, self._sleeps = False, False
        self.wakes_ns: int | None = None  # Virtual time at which its present `time.sleep` ends, if it sleeps.
        self.slept_ns = 0  # Length of the latest sleep.
        self._due, self._awake = threading.Event(), threading.Event()
        self._outcome: Any = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="host", daemon=True)

    def sleep_virtually(self) -> None:
        """Let `time.sleep` of the host program take virtual time."""
        self._virtual = True

    def sleep(self, seconds: float) -> None:
        """Block the host's thread for a number of seconds of virtual time.  Called by the host's own thread."""
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        self.slept_ns = to_ns(seconds)
        self._due.clear()
        self._awake.clear()
        self._sleeps = True
        self._due.wait()
        self._awake.set()

    def sleep_from(self, now_ns: int) -> None:
        """Begin a new sleep at a virtual time.

        The host does not do this, because it may already run while the rest of an answer is on its way.
        """
        if self._sleeps and self.wakes_ns is None:
            self.wakes_ns = now_ns + self.slept_ns

    def wake(self) -> None:
        """End the host's `time.sleep`, in virtual time; return when its thread has resumed."""
        self.wakes_ns, self._sleeps = None, False
        self._due.set()
        self._awake.wait()

    def sleeps_by_the_wall_clock(self) -> bool:
        return "nanosleep" in (self._reported("wchan") or "")

    def start(self) -> None:
        self._thread.start()

    @property
    def name(self) -> str:
        return str(getattr(self._call.func, "__name__", self._call.func))

    @property
    def done(self) -> bool:
        return self._thread.ident is not None and not self._thread.is_alive()

    @property
    def current(self) -> bool:
        return threading.current_thread() is self._thread

    def outcome(self) -> Any:
        """Wait until the function has finished.  Return its result, or raise its exception."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._outcome

    def join(self, seconds: float) -> None:
        self._thread.join(seconds)

    def blocked(self) -> bool:
        if self.done or self._sleeps:
            return True
        if self._thread.native_id is None:  # The host's thread has not started yet.
            return False
        stat = self._reported("stat")
        if stat is None:  # Without a report about the thread, wait briefly and treat the thread as blocked.
            self.join(REACTION_S)
            return True
        return stat.rpartition(")")[2].split()[0] == "S"

    def _reported(self, file: str) -> str | None:
        path = Path(f"/proc/self/task/{self._thread.native_id}/{file}")
        try:
            return path.read_text(encoding="ascii", errors="replace")
        except OSError:
            return None

    def _run(self) -> None:
        try:
            with _sleeping(self) if self._virtual else nullcontext():
                self._outcome = self._call()
        except BaseException as error:  # noqa: BLE001  # `outcome` raises the error again
            self._error = error


_hosts: dict[int, HostThread] = {}  # The hosts whose sleeps take virtual time, by the identifiers of their threads.
_lock = threading.Lock()
_real_sleep = time.sleep


def _sleep(seconds: float | SupportsIndex, /) -> None:
    host = _hosts.get(threading.get_ident())
    if host is None:
        _real_sleep(seconds)
    else:
        host.sleep(float(seconds))


@contextmanager
def _sleeping(host: HostThread) -> Iterator[None]:
    with _lock:
        _hosts[threading.get_ident()] = host
        time.sleep = _sleep
    try:
        yield
    finally:
        with _lock:
            del _hosts[threading.get_ident()]
            if not _hosts:
                time.sleep = _real_sleep


def pause() -> None:
    time.sleep(POLL_S)
