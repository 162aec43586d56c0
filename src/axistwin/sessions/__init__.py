"""Interactive sessions: run, pause and step a bench, and go back in time by replaying all external input."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.sessions.external_input import ExternalInput
    from axistwin.sessions.journal import Cursor, Journal, Moment
    from axistwin.sessions.recorded_port import RecordedBus, RecordedPort
    from axistwin.sessions.session import DRAIN_EVERY, Session
else:
    __getattr__ = lazy(
        __name__,
        external_input="ExternalInput",
        journal="Cursor Journal Moment",
        recorded_port="RecordedBus RecordedPort",
        session="DRAIN_EVERY Session",
    )

__all__ = [
    "DRAIN_EVERY", "Cursor", "ExternalInput", "Journal", "Moment", "RecordedBus", "RecordedPort", "Session",
]  # fmt: skip
