"""Real-time priority for this process, so that a busy computer does not delay the pulses."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

PRIORITY = 10  # Real-time priority of all threads; drivers of the operating system have 50.


@contextmanager
def real_time_priority() -> Iterator[bool]:
    """Run all threads of this process at real-time priority (SCHED_RR).

    Yields False if real-time priority is not permitted.  A niceness is not enough: with automatic groups, Linux applies
    it within one terminal session only.
    """
    granted = _schedule(PRIORITY)
    try:
        yield granted
    finally:
        if granted:
            _schedule(0)


def _schedule(priority: int) -> bool:
    """Set the real-time priority of all threads, and return False if real-time priority is not permitted.

    Priority 0 is that of an ordinary process.  Threads that these threads start later have the same priority.
    """
    if sys.platform != "linux":
        return False
    policy = os.SCHED_RR if priority else os.SCHED_OTHER
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except OSError:
        return False
    for thread in os.listdir("/proc/self/task"):
        with suppress(OSError):  # A thread of the process may end before its priority is set.
            os.sched_setscheduler(int(thread), policy, os.sched_param(priority))
    return True
