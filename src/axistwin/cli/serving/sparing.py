"""Limit repeated log records: a client that sends nonsense for ever must not fill a disk."""

import logging
from collections import Counter

IN_FULL = 10
"""Number of records of one logger that are written in full, with their tracebacks."""
OURS = "axistwin"


class Sparing(logging.Filter):
    """Pass the first records of each logger in full, then only counts at 16, 32, 64, … records, one line each.

    Records with a traceback are limited, and all records of libraries.  One-line records of axistwin itself are not
    limited.
    """

    def __init__(self) -> None:
        super().__init__()
        self._counted: Counter[str] = Counter()

    def filter(self, record: logging.LogRecord) -> bool:
        """Return False for a record that is only counted; shorten a record that reports a count."""
        if record.name.partition(".")[0] == OURS and not record.exc_info:
            return True
        self._counted[record.name] += 1
        count = self._counted[record.name]
        if count <= IN_FULL:
            return True
        if count & (count - 1):
            return False
        record.msg, record.args = f"{record.name} has reported {count} errors; later ones are only counted", ()
        record.exc_info = record.exc_text = record.stack_info = None
        return True
