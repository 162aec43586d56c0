"""LinuxCNC HAL as a board: it receives pulses, and reports inputs and stops.  The class HalBoard does no input or
output: `commands` go to the component, and `receive` takes the component's reports.
"""

from collections import deque
from collections.abc import Callable, Mapping
from math import ceil
from typing import TYPE_CHECKING, Any

from axistwin.standin.events import Event, Failed, InputChanged, Ready, Stopped
from axistwin.standin.hal.track import DELAY_S, Track
from axistwin.standin.hal.wiring import HalWiring
from axistwin.standin.wiring import open_input

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class HalBoard:
    """The axes at HAL.  Times are those of the host in seconds; `journal` receives one line per action."""

    def __init__(
        self,
        wiring: HalWiring,
        horizon_s: float = 0.1,
        journal: Callable[[str], None] = lambda line: None,
        positions: Mapping[str, int] | None = None,
    ) -> None:
        """`positions`: net pulses at the start, by axis; 0 if left out."""
        self.wiring, self.horizon_s, self._note = wiring, horizon_s, journal
        self.commands: deque[dict[str, Any]] = deque([{"setup": wiring.setup()}])
        """Commands in order; the user of the board sends and removes them."""
        self.events: deque[Event] = deque()
        """Events in order; the user of the board removes them."""
        self.stopped: set[str] = set()
        """Controllers whose axes are stopped: their pulses are dropped."""
        self.ready = self.has_failed = False
        self.positions = {axis.axis: (positions or {}).get(axis.axis, 0) for axis in wiring.axes}
        """Positions of the motors as HAL has reported them."""
        self._axes = {axis.axis: axis for axis in wiring.axes}
        self._tracks: dict[str, Track] = {}
        self._origin: dict[str, int] = {}
        self._levels: dict[str, bool] = {}
        self._reasons: dict[str, str] = {}
        """Reasons of stops by the host that the component has not yet reported, by controller."""

    # Functions that process messages from the HAL component in LinuxCNC

    def receive(self, report: Mapping[str, Any]) -> None:
        """Process a report of the HAL component."""
        if "error" in report:
            self.fail(report["error"])
        elif "ready" in report:
            self._begin(report["ready"], report["inputs"])
        elif "input" in report:
            self._input(report["input"], report["level"], report["at"])
        elif "stopped" in report:
            self._update(report["positions"])
            self._stopped(report["stopped"], report["by"], report["late"])
        elif "positions" in report and self.ready:
            self._update(report["positions"])

    def _begin(self, found: Mapping[str, int], inputs: Mapping[str, bool]) -> None:
        for axis, position in found.items():
            self._origin.setdefault(axis, position - self.positions[axis])
        self._update(found)
        self._levels = dict(inputs)
        for given in self.wiring.inputs:
            if given.stops == 0 and self._levels[given.to] is given.stops_at:
                self.fail(f"the contact of the emergency stop {given.to} is open: release the button, then try again")
                return
        self._tracks = {axis: Track(position) for axis, position in self.positions.items()}
        self.ready = True
        self.events.append(Ready(dict(self.positions), dict(self._levels)))
        self._note("ready LinuxCNC HAL")

    def _update(self, found: Mapping[str, int]) -> None:
        for axis, position in found.items():
            self.positions[axis] = position - self._origin[axis]
            self._note(f"position {axis} {self.positions[axis]}")

    def _input(self, to: str, level: bool, at_s: float) -> None:
        self._levels[to] = level
        self.events.append(InputChanged(to, level, at_s))
        given = next(each for each in self.wiring.inputs if each.to == to)
        if given.stops is not None and level is given.stops_at:
            self.stopped.add(given.controller)
        self._note(f"input {to} {int(level)}")

    def _stopped(self, group: str, by: str, late_s: float) -> None:
        self.stopped.add(group)
        reason = self._reasons.pop(group, "")
        if by:
            reason = f"{by} stopped the motion"
        elif late_s:
            reason = f"late by {ceil(late_s * 1e3)} ms, with a horizon of {self.horizon_s * 1e3:.0f} ms"
        positions = {axis.axis: self.positions[axis.axis] for axis in self.wiring.axes if axis.controller == group}
        self.events.append(Stopped(reason, positions, by))
        self._note(f"stopped {group} {reason}")

    def fail(self, reason: str) -> None:
        """Record and report that HAL has failed for this reason; it is not used until `restart`."""
        if not self.has_failed:
            self.ready, self.has_failed = False, True
            self.stopped |= set(self.wiring.groups)
            self.events.append(Failed(reason))
            self._note(f"failed {reason}")

    # Stopping and resuming the axes of a controller

    def stop(self, reason: str, groups: tuple[str, ...] = ()) -> None:
        """Stop the axes of the controllers `groups`, or of all if it is empty, immediately."""
        stopping = [group for group in groups or self.wiring.groups if group not in self._reasons]
        if self.ready and stopping:
            self._reasons |= dict.fromkeys(stopping, reason)
            self.stopped |= set(stopping)
            self.commands.append({"stop": stopping})
            self._note(f"stop {reason}")

    def resume(self, group: str) -> None:
        """Accept step pulses again for all axes of a stopped controller."""
        if self.ready and group in self.stopped:
            self.stopped.discard(group)
            for axis in self.wiring.axes:
                if axis.controller == group:
                    self._tracks[axis.axis] = Track(self.positions[axis.axis])
            self.commands.append({"resume": [group]})

    def restart(self, now_s: float) -> None:
        """Start a new HAL component after a failure."""
        self._note(f"restart at {now_s:.3f} s")
        self.has_failed = False
        self.stopped.clear()
        self._reasons.clear()
        self._origin.clear()
        self.commands.clear()
        self.commands.append({"setup": self.wiring.setup()})

    def shut_down(self) -> None:
        """Switch all drives off and end the HAL component."""
        self.ready, self.has_failed = False, True
        self.commands.append({"end": True})

    # Pulses and outputs

    def queue(self, axis: str, direction: int, times_s: "NDArray[np.float64]", _tolerance_s: float = 0.0) -> None:
        """Queue the pulses of an axis for output by the board.

        The board outputs each pulse at its time in `times_s` plus the horizon, a constant delay.  `direction` is +1 or
        -1.  Pulses beyond a limit stop the axes of the controller.
        """
        import numpy as np

        driven = self._axes[axis]
        if not self.ready or not len(times_s) or driven.controller in self.stopped:
            return
        track = self._tracks[axis]
        rate = 1 / max(float(np.diff(times_s, prepend=track.last_s).min()), 1e-9)
        refused = driven.refusal(rate, track.position + direction * len(times_s))
        refused = refused or open_input(self.wiring.inputs, self._levels, driven, direction)
        late_s = track.calculated_s - float(times_s[0])
        if late_s > 0:
            refused = f"late by {late_s * 1e3:.0f} ms"
        if refused:
            self.stop(refused, (driven.controller,))
        else:
            track.add(direction, times_s)

    def complete(self, until_s: float) -> None:
        """Send the positions up to this time: all pulses before it have been queued."""
        if self.ready:
            knots = {}
            for axis, track in self._tracks.items():
                found = track.knots(until_s)
                if found and self._axes[axis].controller not in self.stopped:
                    offset = self._origin[axis]
                    knots[axis] = [(at_s + self.horizon_s, position + offset) for at_s, position in found]
                    self._note(f"knots {axis} {found[0][0]:.3f} " + " ".join(f"{p:g}" for _, p in found))
            self.commands.append({"knots": knots, "upto": until_s - DELAY_S + self.horizon_s})

    def set_output(self, source: str, level: bool, at_s: float) -> None:
        """Set an output at `at_s` plus the horizon, a constant delay."""
        if self.ready:
            self.commands.append({"output": source, "level": level, "at": at_s + self.horizon_s})
