"""Time inside axistwin is an integer number of nanoseconds; seconds exist at its edges only."""

from fractions import Fraction

US = 1_000
MS = 1_000_000
S = 1_000_000_000


def to_ns(seconds: float | Fraction) -> int:
    """Seconds as the nearest integer number of nanoseconds."""
    return round(seconds * S)


def to_seconds(ns: int) -> float:
    """Nanoseconds as seconds, for people and plots."""
    return ns / S
