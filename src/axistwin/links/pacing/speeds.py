"""Speeds of virtual time: a multiple of real time, or `max` (as fast as possible)."""

from axistwin.errors import UsageError
from axistwin.numbers import NumberError, real, shortened

MAX_SPEED = 1e6
"""Upper limit of the speed, times real time."""


def read_speed(text: str) -> float | None:
    """Parse a speed: a number up to 1,000,000, or `"max"`, which becomes None.  Raises UsageError."""
    if text == "max":
        return None
    try:
        speed = real(text)
    except NumberError:
        speed = 0.0
    return checked_speed(speed, text)


def checked_speed(speed: float | None, text: str = "") -> float | None:
    """Return `speed`.  Raises UsageError if it is out of range.  `text`: the speed as the user wrote it."""
    if speed is None or 0 < speed <= MAX_SPEED:
        return speed
    given_speed = shortened(text or f"{speed:g}")
    raise UsageError(f"invalid speed {given_speed}: expected `max` or a number up to 1000000, e.g. 1 for real time")
