"""What every motion board does, whatever its output: its state, its events, and which axes are stopped.

CONNECTING ──▶ READY ◀──▶ axes of a controller stopped (by a limit, by late pulses, by the user)
    │            │
    └──▶ FAILED ◀┘        the board has stopped, or does not answer
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from enum import Enum

from axistwin.core.lazy import NDArray, np
from axistwin.real.standin.events import Event, Failed
from axistwin.real.standin.step_stream import TOLERANCE_S
from axistwin.real.standin.wiring import DrivenAxis, Wired, open_input


class State(Enum):
    """State of the connection to a motion board."""

    CONNECTING = "connecting"
    READY = "ready"
    FAILED = "failed"


class Board(ABC):
    """A board with its wiring.  Times are those of the host in seconds; `journal` receives one line per action."""

    def __init__(self, wiring: Wired, horizon_s: float, journal: Callable[[str], None]) -> None:
        self.wiring, self.horizon_s, self._note = wiring, horizon_s, journal
        self.state = State.CONNECTING
        self.events: deque[Event] = deque()  # In order of time; the caller removes those that it has handled.
        self.stopped: set[str] = set()  # Controllers whose axes are stopped; their pulses are discarded.
        self._axes = {axis.axis: axis for axis in wiring.axes}
        self._levels: dict[str, bool] = {}
        self._stopping: dict[str, str] = {}  # Reasons of stops by the host, by controller.

    def fail(self, reason: str, *, gone: bool = False) -> None:
        """Do not use the board until `restart`.  `gone`: nothing serves its port any more."""
        if self.state is not State.FAILED or gone:
            self.state = State.FAILED
            self._drop_pulses(self.wiring.groups)
            self.events.append(Failed(reason, gone))
            self._note(f"failed {reason}")

    @abstractmethod
    def restart(self, now_s: float) -> None:
        """Connect to the board again after a failure, at the user's command."""

    @abstractmethod
    def shut_down(self) -> None: ...

    @property
    def _open_stop(self) -> str:
        """Error message if an emergency stop is open, else ""."""
        for given in self.wiring.inputs:
            if given.stops == 0 and self._levels[given.to] is given.stops_at:
                return f"the contact of the emergency stop {given.to} is open: release the button, then try again"
        return ""

    # Stopping and resuming the axes of a controller

    def stop(self, reason: str, groups: tuple[str, ...] = ()) -> None:
        """Stop the axes of the controllers `groups`, or of all if it is empty, immediately."""
        stopping = tuple(group for group in groups or self.wiring.groups if group not in self._stopping)
        if self.state is State.READY and stopping:
            self._stopping |= dict.fromkeys(stopping, reason)
            self._drop_pulses(stopping)
            self._stop(reason, stopping)
            self._note(f"stop {reason}")

    @abstractmethod
    def _stop(self, reason: str, groups: tuple[str, ...]) -> None: ...

    def _drop_pulses(self, groups: tuple[str, ...]) -> None:
        """Discard all unsent pulses of the given controllers, and all new pulses until `resume` is called."""
        self.stopped |= set(groups)

    def resume(self, group: str) -> None:
        """Accept pulses again for the axes of a stopped controller."""
        if self.state is State.READY and group in self.stopped:
            self.stopped.discard(group)
            self._resume(group)

    @abstractmethod
    def _resume(self, group: str) -> None: ...

    # Pulses and outputs

    def queue(
        self, axis: str, direction: int, times_s: "NDArray[np.float64]", tolerance_s: float = TOLERANCE_S
    ) -> None:
        """Queue the pulses of an axis for output by the board.

        The board outputs each pulse at its time in `times_s` plus the horizon, a constant delay.  `direction` is +1 or
        -1.  Pulses beyond a limit stop the axes of the controller.
        """
        driven = self._axes[axis]
        if self.state is not State.READY or not len(times_s) or driven.controller in self.stopped:
            return
        if refused := self._add(driven, direction, times_s, tolerance_s):
            self.stop(refused, (driven.controller,))

    @abstractmethod
    def _add(self, driven: DrivenAxis, direction: int, times_s: "NDArray[np.float64]", tolerance_s: float) -> str:
        """Queue pulses, unless they are refused; return the reason."""

    def _blocked(self, driven: DrivenAxis, direction: int) -> str:
        return open_input(self.wiring.inputs, self._levels, driven, direction)

    def set_output(self, source: str, level: bool, at_s: float) -> None:
        if self.state is State.READY:
            self._switch(source, level, at_s)

    @abstractmethod
    def _switch(self, source: str, level: bool, at_s: float) -> None: ...
