"""Time inside axistwin is an integer number of nanoseconds; seconds exist at its edges only."""

from fractions import Fraction

from axistwin.errors import UsageError

US = 1_000
MS = 1_000_000
S = 1_000_000_000
MOST_NS = 1 << 63
"""Times below this, some 292 years, can stand in a trace."""


def to_ns(seconds: float | Fraction) -> int:
    """Seconds as the nearest integer number of nanoseconds.  Raises UsageError for what no bench will ever see."""
    ns = seconds * S
    if not -MOST_NS < ns < MOST_NS:
        raise UsageError(f"{float(seconds):g} s is too long: give less than 292 years, 9.2e9 s")
    return round(ns)


def to_seconds(ns: int) -> float:
    """Nanoseconds as seconds, for people and plots."""
    return ns / S
