"""Numbers in texts: functions that read numbers in scenes, conversations, programs, traces and on the command line.

Python reads very long numbers slowly, and raises its own error for thousands of digits.  These functions accept plain
ASCII, finite numbers within limits, and at most `MOST_CHARACTERS` characters; otherwise they raise NumberError.
"""

from collections.abc import Mapping
from decimal import Decimal, InvalidOperation

from axistwin.core.errors import UsageError

MOST_CHARACTERS = 100  # Maximum length of a number; a 64-bit number in binary has 64 characters, the longest float 24.
LOWEST, HIGHEST = -(1 << 63), (1 << 63) - 1
"""The range of whole numbers: 64 bits, as in TOML, in traces and in Parquet."""
_SHOWN = 40
Path = tuple[str | int, ...]


class NumberError(UsageError, ValueError):
    """Raised for a text that is not a number, or for a number out of range."""

    def __init__(self, message: str, path: Path = ()) -> None:
        super().__init__(message)
        self.path = path  # Place of the number in a table: its keys and list indexes.


def clipped(text: str) -> str:
    """Shorten a text of more than 40 characters for an error message, and append the length of the full text."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}… ({len(text)} characters)"


def shortened(text: str) -> str:
    """Return a text in quotes for use in an error message; after 40 characters it is cut off, with its length."""
    return repr(text) if len(text) <= _SHOWN else f"{text[:_SHOWN]!r}… ({len(text)} characters)"


def whole(text: str, low: int = LOWEST, high: int = HIGHEST, *, base: int = 10) -> int:
    """Parse a text that must be a whole number in the range `low` to `high`.

    `base`: 2, 10, 16, or 0 for a number whose prefix `0x` or `0b` selects its base.  Raises NumberError for an invalid
    text.
    """
    words = _bounded(text, "whole number")
    try:
        number = int(words, base)
    except ValueError:
        raise NumberError(f"{shortened(text)} is not a whole number: expected e.g. 12") from None
    if not low <= number <= high:
        raise NumberError(f"{shortened(text)} is out of range: expected a whole number from {low} to {high}")
    return number


def real(text: str) -> float:
    """Parse a finite number.  Raises NumberError for any other text."""
    words = _bounded(text, "number")
    try:
        number = float(words)
    except ValueError:
        raise NumberError(f"{shortened(text)} is not a number: expected e.g. 12.5") from None
    if not abs(number) < float("inf"):
        raise NumberError(f"{shortened(text)} is not a number: expected e.g. 12.5")
    return number


def decimal(text: str) -> Decimal:
    """Parse a decimal number below 1e30 without rounding.  Raises NumberError for any other text."""
    words = _bounded(text, "number")
    try:
        number = Decimal(words)
    except InvalidOperation:
        raise NumberError(f"{shortened(text)} is not a number: expected e.g. 12.5") from None
    if not number.is_finite():
        raise NumberError(f"{shortened(text)} is not a number: expected e.g. 12.5")
    exponent = number.as_tuple().exponent
    assert isinstance(exponent, int), "it is finite"
    if number.adjusted() >= 30 or not -MOST_CHARACTERS <= exponent <= 30:
        raise NumberError(f"{shortened(text)} is out of range: expected a number below 1e30")
    return number


def check_values(value: object, path: Path = ()) -> None:
    """Raise NumberError with the `path` of a whole number of more than 64 bits in a table."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            check_values(inner, (*path, key))
    elif isinstance(value, list | tuple):
        for at, inner in enumerate(value):
            check_values(inner, (*path, at))
    elif isinstance(value, int) and not LOWEST <= value <= HIGHEST:
        raise NumberError(
            "a whole number has more than 64 bits: expected -9223372036854775808 to 9223372036854775807", path
        )


def _bounded(text: str, kind_of_number: str) -> str:
    if len(text) > MOST_CHARACTERS:
        raise NumberError(
            f"{shortened(text)} is too long for a {kind_of_number}: expected at most {MOST_CHARACTERS} characters"
        )
    if not text.isascii():
        raise NumberError(f"{shortened(text)} is not a {kind_of_number}: expected the digits 0 to 9")
    return text
