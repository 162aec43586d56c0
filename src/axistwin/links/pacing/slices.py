"""Slices of real time, for which the bench runs before sockets are served again."""

from time import perf_counter

SLICE_S = 0.002
"""Longest time that the bench runs before sockets are served again."""


class Slice:
    """A timer that expires after 2 ms of real time.  The simulation pauses when the timer expires.

    The 2 ms (`SLICE_S`) begin when the timer is created.
    """

    def __init__(self) -> None:
        self._end_s = perf_counter() + SLICE_S

    def over(self) -> bool:
        """True if `SLICE_S` seconds of real time have passed since this timer was created.

        The simulation then pauses, so that sockets are served.
        """
        return perf_counter() >= self._end_s
