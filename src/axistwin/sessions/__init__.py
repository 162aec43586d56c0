"""Interactive sessions: run, pause and step a bench, and go back in time by replaying all external input."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.sessions.journal import Cursor, Journal, Moment
    from axistwin.sessions.session import DRAIN_EVERY, Session
else:
    __getattr__ = lazy(
        __name__,
        journal="Cursor Journal Moment",
        session="DRAIN_EVERY Session",
    )

__all__ = ["DRAIN_EVERY", "Cursor", "Journal", "Moment", "Session"]
