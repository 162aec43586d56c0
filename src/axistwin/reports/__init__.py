"""Reports of a run: its messages, moves and refused lines, as text and as JSON."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.reports.run_record import RunRecord, recording_run
    from axistwin.reports.servo_moves import ServoMoves
else:
    __getattr__ = lazy(
        __name__,
        run_record="RunRecord recording_run",
        servo_moves="ServoMoves",
    )

__all__ = ["RunRecord", "ServoMoves", "recording_run"]
