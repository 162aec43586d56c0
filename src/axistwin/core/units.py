"""Units of time: an integer number of nanoseconds inside axistwin, seconds at its interfaces."""

from fractions import Fraction

from axistwin.core.errors import UsageError

US = 1_000
MS = 1_000_000
S = 1_000_000_000
MOST_NS = 1 << 63  # End of virtual time, after about 292 years: traces and pulse times are 64-bit integers.


def to_ns(seconds: float | Fraction) -> int:
    """Convert seconds to the nearest whole number of nanoseconds.  Raises UsageError for more than 292 years."""
    ns = seconds * S
    if not -MOST_NS < ns < MOST_NS:
        raise UsageError(f"{_shown(seconds)} is too long: expected less than 292 years (9.2e9 s)")
    return round(ns)


def to_seconds(ns: int) -> float:
    return ns / S


def figures(seconds: float) -> str:
    """Return seconds for a user, with at most three decimals, e.g. `1,234.5`."""
    return f"{seconds:,.3f}".rstrip("0").rstrip(".")


def _shown(seconds: float | Fraction) -> str:
    try:
        return f"{float(seconds):g} s"
    except OverflowError:
        return "a time of more than 300 digits"
