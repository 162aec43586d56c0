"""Slices of real time, for which the bench runs before sockets are served again."""

from time import perf_counter

SLICE_S = 0.002
"""Longest time that the bench runs before sockets are served again."""


class Slice:
    """A slice of real time that begins when the object is created."""

    def __init__(self) -> None:
        self._end_s = perf_counter() + SLICE_S

    def over(self) -> bool:
        """True if the slice has ended, so that sockets must be served."""
        return perf_counter() >= self._end_s
