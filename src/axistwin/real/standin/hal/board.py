"""LinuxCNC HAL as a board: it receives pulses, and reports inputs and stops.  The class HalBoard does no input or
output: `commands` go to the component, and `receive` takes the component's reports.
"""

from collections import deque
from collections.abc import Callable, Mapping
from math import ceil
from typing import Any

from axistwin.core.lazy import NDArray, np
from axistwin.real.standin.board import Board, State
from axistwin.real.standin.events import InputChanged, Ready, Stopped
from axistwin.real.standin.hal.track import DELAY_S, Track
from axistwin.real.standin.hal.wiring import HalWiring
from axistwin.real.standin.wiring import DrivenAxis


class HalBoard(Board):
    """The axes at HAL."""

    wiring: HalWiring

    def __init__(
        self, wiring: HalWiring, horizon_s: float = 0.1, journal: Callable[[str], None] = lambda line: None,
        positions: Mapping[str, int] | None = None,
    ) -> None:  # fmt: skip
        """`positions`: net pulses at the start, by axis; 0 if left out."""
        super().__init__(wiring, horizon_s, journal)
        self.commands: deque[dict[str, Any]] = deque([{"setup": wiring.setup()}])
        """Commands in order; the user of the board sends and removes them."""
        self.positions = {axis.axis: (positions or {}).get(axis.axis, 0) for axis in wiring.axes}  # As reported by HAL.
        self._tracks: dict[str, Track] = {}
        self._origin: dict[str, int] = {}

    # Functions that process messages from the HAL component in LinuxCNC

    def receive(self, report: Mapping[str, Any]) -> None:
        if "error" in report:
            self.fail(report["error"])
        elif "ready" in report:
            self._begin(report["ready"], report["inputs"])
        elif "input" in report:
            self._input(report["input"], report["level"], report["at"])
        elif "stopped" in report:
            self._update(report["positions"])
            self._stopped(report["stopped"], report["by"], report["late"])
        elif "positions" in report and self.state is State.READY:
            self._update(report["positions"])

    def _begin(self, found: Mapping[str, int], inputs: Mapping[str, bool]) -> None:
        for axis, position in found.items():
            self._origin.setdefault(axis, position - self.positions[axis])
        self._update(found)
        self._levels = dict(inputs)
        if open_stop := self._open_stop:
            self.fail(open_stop)
            return
        self._tracks = {axis: Track(position) for axis, position in self.positions.items()}
        self.state = State.READY
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
        reason = self._stopping.pop(group, "")
        if by:
            reason = f"{by} stopped the motion"
        elif late_s:
            reason = f"late by {ceil(late_s * 1e3)} ms, with a horizon of {self.horizon_s * 1e3:.0f} ms"
        positions = {axis.axis: self.positions[axis.axis] for axis in self.wiring.axes if axis.controller == group}
        self.events.append(Stopped(reason, positions, by))
        self._note(f"stopped {group} {reason}")

    # Stopping and resuming the axes of a controller

    def _stop(self, reason: str, groups: tuple[str, ...]) -> None:  # noqa: ARG002  # the component reports the stop
        self.commands.append({"stop": list(groups)})

    def _resume(self, group: str) -> None:
        for axis in self.wiring.axes:
            if axis.controller == group:
                self._tracks[axis.axis] = Track(self.positions[axis.axis])
        self.commands.append({"resume": [group]})

    def restart(self, now_s: float) -> None:
        self._note(f"restart at {now_s:.3f} s")
        self.state = State.CONNECTING
        self.stopped.clear()
        self._stopping.clear()
        self._origin.clear()
        self.commands.clear()
        self.commands.append({"setup": self.wiring.setup()})

    def shut_down(self) -> None:
        self.state = State.FAILED
        self.commands.append({"end": True})

    # Pulses and outputs

    def _add(self, driven: DrivenAxis, direction: int, times_s: "NDArray[np.float64]", tolerance_s: float) -> str:  # noqa: ARG002
        track = self._tracks[driven.axis]
        late_s = track.calculated_s - float(times_s[0])
        if late_s > 0:
            return f"late by {late_s * 1e3:.0f} ms"
        rate = 1 / max(float(np.diff(times_s, prepend=track.last_s).min()), 1e-9)
        refused = driven.refusal(rate, track.position + direction * len(times_s)) or self._blocked(driven, direction)
        if not refused:
            track.add(direction, times_s)
        return refused

    def complete(self, until_s: float) -> None:
        """Send the positions up to this time: all pulses before it have been queued."""
        if self.state is State.READY:
            knots = {}
            for axis, track in self._tracks.items():
                found = track.knots(until_s)
                if found and self._axes[axis].controller not in self.stopped:
                    offset = self._origin[axis]
                    knots[axis] = [(at_s + self.horizon_s, position + offset) for at_s, position in found]
                    self._note(f"knots {axis} {found[0][0]:.3f} " + " ".join(f"{p:g}" for _, p in found))
            self.commands.append({"knots": knots, "upto": until_s - DELAY_S + self.horizon_s})

    def _switch(self, source: str, level: bool, at_s: float) -> None:
        self.commands.append({"output": source, "level": level, "at": at_s + self.horizon_s})
