"""The HAL component `axistwin`: commands positions, reports inputs, and stops the motion without axistwin.

This file is a program for the Python that has LinuxCNC's module `hal`; it imports nothing of axistwin.  Commands come
on standard input and reports go to standard output, one JSON object in each line.  Times are those of the monotonic
clock in seconds, positions are in pulses.

Commands: `setup` (first), `begin`, `knots` with `upto`, `output`, `stop`, `resume`, `end`.
Reports: `created`, `error`, `ready`, `input`, `stopped`, `positions`.
"""

import json
import os
import select
import sys
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

PERIOD_S = 0.001  # Interval at which commands, pins and positions are handled.
STILL_S = 0.02  # A motor whose feedback has not changed for this long is at rest.
MOST_STILL_S = 1.0  # Longest time to wait for the rest of a motor that has been stopped.
REPORT_S = 0.1  # Interval at which the positions are reported, if they have changed.


class Axis:
    """An axis that interpolates its commanded position between points; each point is a time and a position."""

    def __init__(self, name: str) -> None:
        self.name, self.position = name, 0.0
        self.knots: deque[tuple[float, float]] = deque()

    def move(self, now_s: float) -> float:
        """Update the position; return the velocity in pulses/s."""
        knots, velocity = self.knots, 0.0
        while len(knots) > 1 and knots[1][0] <= now_s:
            knots.popleft()
        if knots and knots[0][0] <= now_s:
            at_s, self.position = knots[0]
            if len(knots) > 1:
                velocity = (knots[1][1] - self.position) / (knots[1][0] - at_s)
                self.position += velocity * (now_s - at_s)
        return velocity


class Group:
    """The axes of one controller, which always stop together."""

    def __init__(self, name: str) -> None:
        self.name, self.axes, self.running = name, [], True  # type: str, list[Axis], bool
        self.by, self.late_s, self.reported = "", 0.0, True
        self.stopped_s = self.changed_s = 0.0
        self.feedback: list[float] = []


class Motion:
    """The component alone.  `pins`: values by name, as of a HAL component; `reports` receives its output."""

    def __init__(self, setup: dict[str, Any], pins: Any) -> None:
        self.pins, self.reports = pins, deque()  # type: Any, deque[dict[str, Any]]
        self.axes = {name: Axis(name) for name in setup["axes"]}
        self.groups: dict[str, Group] = {}
        for axis in self.axes.values():
            name = axis.name.rpartition(".")[0]
            self.groups.setdefault(name, Group(name)).axes.append(axis)
        self.inputs = dict.fromkeys(setup["inputs"], False)
        self.stops: dict[str, bool] = setup["stops"]  # Level of each input that stops the motion, at which it does.
        self.safe: dict[str, bool] = setup["outputs"]
        self.outputs: deque[tuple[float, str, bool]] = deque()
        self.upto_s: float | None = None  # All knots before this time have come; None: before the first knots.
        self.begun = self.ended = False
        self._known: dict[str, int] = {}
        self._report_s = 0.0

    def positions(self, axes: "list[Axis] | None" = None) -> dict[str, int]:
        chosen = self.axes.values() if axes is None else axes
        return {axis.name: round(self.pins[f"{axis.name}.position-fb"]) for axis in chosen}

    def command(self, given: dict[str, Any], now_s: float) -> None:
        if "begin" in given:
            self.begun = True
            for axis in self.axes.values():
                self._set(axis, self.positions([axis])[axis.name])
            self.inputs = {name: bool(self.pins[name]) for name in self.inputs}
            self.reports.append({"ready": self.positions(), "inputs": self.inputs})
        if "knots" in given:
            if self.upto_s is None:
                for group in self.groups.values():
                    self._enable(group, True)
            self.upto_s = given["upto"]
            for name, knots in given["knots"].items():
                if self.groups[name.rpartition(".")[0]].running:
                    self.axes[name].knots.extend((at_s, position) for at_s, position in knots)
        if "output" in given:
            self.outputs.append((given["at"], given["output"], given["level"]))
        for name in given.get("stop", ()):
            self._stop(self.groups[name], now_s)
        for name in given.get("resume", ()):
            self.groups[name].running = True
            self._enable(self.groups[name], True)
        self.ended = self.ended or "end" in given

    def turn(self, now_s: float) -> None:
        if self.begun:
            self._read(now_s)
        while self.outputs and self.outputs[0][0] <= now_s:
            _, name, level = self.outputs.popleft()
            self.pins[name] = level
        late_s = 0.0 if self.upto_s is None else now_s - self.upto_s
        for group in self.groups.values():
            if not group.running:
                self._settle(group, now_s)
            elif late_s > 0:
                self._stop(group, now_s, late_s=late_s)
            else:
                for axis in group.axes:
                    self._follow(axis, now_s)
        self.pins["heartbeat"] = not self.pins["heartbeat"]
        if now_s >= self._report_s:
            self._report_s, found = now_s + REPORT_S, self.positions()
            if found != self._known:
                self._known = found
                self.reports.append({"positions": found})

    def end(self) -> None:
        for group in self.groups.values():
            self._enable(group, False)
        for name, level in self.safe.items():
            self.pins[name] = level

    def _read(self, now_s: float) -> None:
        for name, known in self.inputs.items():
            level = bool(self.pins[name])
            if level is not known:
                self.inputs[name] = level
                self.reports.append({"input": name, "level": level, "at": now_s})
                group = self.groups.get(name.rpartition(".")[0])
                if self.upto_s is not None and group is not None and self.stops.get(name) is level:
                    self._stop(group, now_s, by=name)

    def _follow(self, axis: Axis, now_s: float) -> None:
        velocity = axis.move(now_s)
        self.pins[f"{axis.name}.velocity-cmd"] = velocity
        self.pins[f"{axis.name}.plus"] = velocity > 0
        self.pins[f"{axis.name}.minus"] = velocity < 0
        self.pins[f"{axis.name}.position-cmd"] = axis.position

    def _set(self, axis: Axis, position: float) -> None:
        axis.position = position
        axis.knots.clear()
        self.pins[f"{axis.name}.position-cmd"] = position
        self.pins[f"{axis.name}.velocity-cmd"] = 0.0
        self.pins[f"{axis.name}.plus"] = self.pins[f"{axis.name}.minus"] = False

    def _enable(self, group: Group, on: bool) -> None:
        for axis in group.axes:
            self.pins[f"{axis.name}.enable"] = on

    def _stop(self, group: Group, now_s: float, *, by: str = "", late_s: float = 0.0) -> None:
        if group.running or not by:
            group.by, group.late_s = by, late_s
        if group.running:
            group.stopped_s = group.changed_s = now_s
        group.running = group.reported = False
        self._enable(group, False)
        for axis in group.axes:
            self._set(axis, axis.position)

    def _settle(self, group: Group, now_s: float) -> None:
        feedback = [self.pins[f"{axis.name}.position-fb"] for axis in group.axes]
        if feedback != group.feedback:
            group.feedback, group.changed_s = feedback, now_s
        still = now_s >= min(group.changed_s + STILL_S, group.stopped_s + MOST_STILL_S)
        if still and not group.reported:
            group.reported, found = True, self.positions(group.axes)
            for axis in group.axes:
                self._set(axis, found[axis.name])
            self.reports.append({"stopped": group.name, "by": group.by, "late": group.late_s, "positions": found})


def make_pins(hal: Any, component: Any, setup: dict[str, Any]) -> None:
    component.newpin("heartbeat", hal.HAL_BIT, hal.HAL_OUT)
    for axis in setup["axes"]:
        for pin in ("position-cmd", "velocity-cmd"):
            component.newpin(f"{axis}.{pin}", hal.HAL_FLOAT, hal.HAL_OUT)
        for pin in ("enable", "plus", "minus"):
            component.newpin(f"{axis}.{pin}", hal.HAL_BIT, hal.HAL_OUT)
        component.newpin(f"{axis}.position-fb", hal.HAL_FLOAT, hal.HAL_IN)
    for name in setup["inputs"]:
        component.newpin(name, hal.HAL_BIT, hal.HAL_IN)
    for name in setup["outputs"]:
        component.newpin(name, hal.HAL_BIT, hal.HAL_OUT)


def lines(pipe: int) -> Iterator[str | None]:
    """Yield the lines received from a pipe.  Yield None while no data are available."""
    pending = b""
    while True:
        ready, _, _ = select.select([pipe], [], [], 0)
        if ready:
            data = os.read(pipe, 65536)
            if not data:
                return
            *complete, pending = (pending + data).split(b"\n")
            for line in complete:
                yield line.decode()
        else:
            yield None


def report(given: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(given) + "\n")
    sys.stdout.flush()


def main() -> None:
    try:
        import hal
    except ImportError:
        report({"error": f"{sys.executable} has no module hal: install LinuxCNC (Debian: linuxcnc-uspace)"})
        return
    commands = lines(sys.stdin.fileno())
    for line in commands:
        if line is not None:
            setup = json.loads(line)["setup"]
            break
        select.select([sys.stdin], [], [])
    else:
        return  # axistwin has ended
    try:
        component = hal.component("axistwin")
        make_pins(hal, component, setup)
        component.ready()
    except hal.error as error:
        report({"error": f"{error}: end another axistwin, or HAL by `halrun -U`"})
        return
    report({"created": True})
    motion = Motion(setup, component)
    try:
        serve(motion, commands)
    finally:
        motion.end()
        component.exit()


def serve(motion: Motion, commands: Iterator[str | None]) -> None:
    while not motion.ended:
        for line in commands:
            if line is None:
                break
            motion.command(json.loads(line), time.monotonic())
        else:
            return  # axistwin has ended
        motion.turn(time.monotonic())
        while motion.reports:
            report(motion.reports.popleft())
        select.select([sys.stdin], [], [], PERIOD_S)


if __name__ == "__main__":
    main()
