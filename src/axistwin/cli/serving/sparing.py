"""Limit repeated log records, so that a client with endless invalid data does not fill the disk."""

import logging
from collections import Counter

IN_FULL = 10  # Number of log records of each logger that are written in full, with their tracebacks.
OURS = "axistwin"


def log_to_stderr(level: int) -> None:
    handler = logging.StreamHandler()
    handler.addFilter(Sparing())
    logging.basicConfig(format="axistwin: %(message)s", level=level, handlers=[handler])


class Sparing(logging.Filter):
    """Log filter that passes the first records of each logger, later only their count at 16, 32, 64, … records.

    Limited are records with a traceback and all records of libraries, but not one-line records of axistwin.
    """

    def __init__(self) -> None:
        super().__init__()
        self._counted: Counter[str] = Counter()

    def filter(self, record: logging.LogRecord) -> bool:
        """Return True to write a log record, or False to discard the record.  Discarded records are counted."""
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
