"""The output of a board, for the thread of the bench: another thread or process serves the board."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from threading import Lock
from typing import Any

from axistwin.core.lazy import NDArray, np
from axistwin.real.standin.board import Board
from axistwin.real.standin.events import Event
from axistwin.real.standin.step_stream import TOLERANCE_S

Deliver = Callable[["Output", Event], None]


class Output(ABC):
    """Serves one board, and calls `deliver` in another thread with each of its events."""

    def __init__(self, board: Board, deliver: Deliver) -> None:
        self.wiring = board.wiring
        self._board, self._deliver = board, deliver
        self._lock = Lock()

    def _act(self, act: Callable[..., None], *values: Any) -> None:
        with self._lock:
            act(*values)

    def _report(self) -> None:
        while self._board.events:
            self._deliver(self, self._board.events.popleft())

    @abstractmethod
    def start(self) -> None: ...

    @abstractmethod
    def close(self) -> None: ...

    def queue(
        self, axis: str, direction: int, times_s: "NDArray[np.float64]", tolerance_s: float = TOLERANCE_S
    ) -> None:
        """Queue an axis's pulses; the board outputs each at its time in `times_s` plus the horizon."""
        self._act(self._board.queue, axis, direction, times_s, tolerance_s)

    def set_output(self, source: str, level: bool, at_s: float) -> None:
        """Set an output at `at_s` plus the horizon, a constant delay."""
        self._act(self._board.set_output, source, level, at_s)

    def stop(self, reason: str, groups: tuple[str, ...] = ()) -> None:
        """Stop the axes of the controllers `groups`, or of all if it is empty, immediately."""
        self._act(self._board.stop, reason, groups)

    @property
    def stopped(self) -> frozenset[str]:
        """Names of the controllers whose axes are stopped.  Any thread may read this property."""
        return frozenset(tuple(self._board.stopped))

    def resume(self, group: str) -> None:
        """Accept pulses of a stopped controller again."""
        self._act(self._board.resume, group)

    def restart(self, now_s: float) -> None:
        self._act(self._board.restart, now_s)

    def shut_down(self) -> None:
        """Stop all axes and switch all drives off."""
        self._act(self._board.shut_down)
