"""The Python side of an FMU: a bench that advances from one communication point to the next.

An FMU contains this module's caller, the scene, and pythonfmu3.  axistwin is a package of the user's Python.
"""

import json
from collections.abc import Mapping
from functools import partial
from math import inf, isfinite
from pathlib import Path
from typing import Any

from pythonfmu3 import Boolean, Float64, Fmi3Causality, Fmi3Slave, Fmi3Status, Fmi3StepResult, Fmi3Variability, Unit

from axistwin.core.errors import AxistwinError, UsageError
from axistwin.core.units import to_ns
from axistwin.core.version import VERSION
from axistwin.devices.loading import load_text
from axistwin.real.integrations.fmu.archive import FOLDER, SCENE, SETTINGS
from axistwin.real.integrations.fmu.variables import ANGLE, SPEED, TIME, TORQUE, Input, Output, inputs, outputs
from axistwin.scenes.scene import Scene

ROUNDING_S, ROUNDING = 1e-9, 1e-12  # Largest gap between a step's end and the next begin: absolute, relative.
UNITS = {TORQUE: {"kg": 1, "m": 2, "s": -2}, ANGLE: {"rad": 1}, SPEED: {"rad": 1, "s": -1}, "s": {"s": 1}}


class Machine(Fmi3Slave):
    """The running scene of an FMU; inputs act at communication points, in the order of their list."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        folder = Path(options["resources"])
        settings: Mapping[str, Any] = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
        _check_version(settings["version"])
        for number, (name, text) in enumerate(settings["devices"]):
            load_text(folder / str(number) / name, text)
        scene = Scene.load(folder / FOLDER / SCENE)
        self.bench = scene.build()
        self.guid, self.description = settings["token"], settings["description"]
        self.version, self.author = settings["version"], "axistwin"
        self._begin_s: float | None = None  # The simulation tool's time at 0 s of the bench; None before the first.
        self._time_s = 0.0  # End of the last step, which is the begin of the next one.
        self.register_units([Unit(name, **base) for name, base in UNITS.items()])
        self._add_time()
        self._values: dict[str, float] = {}  # Values of the inputs, as set by the simulation tool.
        self._inputs = inputs(self.bench, settings["commands"])
        self._applied = {each.name: each.first for each in self._inputs}
        for each in self._inputs:
            self._add_input(each)
        for one in outputs(self.bench):
            self._add_output(one)

    def _add_time(self) -> None:
        options = {"causality": Fmi3Causality.independent, "variability": Fmi3Variability.continuous, "unit": "s"}
        self.register_variable(Float64(TIME, description="Time", getter=lambda: self._time_s, **options))

    def _add_input(self, each: Input) -> None:
        self._values[each.name] = each.first
        options = {
            "causality": Fmi3Causality.input, "description": each.doc,
            "getter": partial(self._values.__getitem__, each.name),
            "setter": partial(self._values.__setitem__, each.name),
        }  # fmt: skip
        if each.unit:
            options |= {"variability": Fmi3Variability.continuous, "unit": each.unit}
            self.register_variable(Float64(each.name, **options))
        else:
            self.register_variable(Boolean(each.name, variability=Fmi3Variability.discrete, **options))

    def _add_output(self, one: Output) -> None:
        options = {"causality": Fmi3Causality.output, "description": one.doc, "getter": one.get}
        if one.level:
            self.register_variable(Boolean(one.name, variability=Fmi3Variability.discrete, **options))
        else:
            self.register_variable(Float64(one.name, unit=one.unit or None, **options))

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        """Apply all changed inputs, and advance virtual time to the next communication point.

        The first communication point is 0 s of the bench, because pythonfmu3 does not pass on the start time.
        """
        try:
            end_ns = self._end_ns(current_time, step_size)
            for each in self._inputs:
                value = self._values[each.name]
                if value != self._applied[each.name]:
                    each.set(value)
                    self._applied[each.name] = value
            if self._begin_s is None:
                self._begin_s = current_time
            self._time_s = current_time + step_size
            self.bench.clock.run_to(max(self.bench.now, end_ns))
        except AxistwinError as error:
            self.log(str(error), Fmi3Status.error)
            return Fmi3StepResult(status=Fmi3Status.error)
        return Fmi3StepResult(status=Fmi3Status.ok)

    def _end_ns(self, begin_s: float, step_s: float) -> int:
        if not isfinite(begin_s):
            raise UsageError(f"invalid communication point {begin_s:g}: expected a finite number of seconds")
        if not 0 < step_s < inf:
            raise UsageError(f"invalid step size {step_s:g}: expected a finite number of seconds above 0")
        if self._begin_s is not None and abs(begin_s - self._time_s) > ROUNDING_S + ROUNDING * abs(self._time_s):
            raise UsageError(
                f"invalid communication point {begin_s:.9g} s: expected {self._time_s:.9g} s, the end of the last step"
            )
        return to_ns(begin_s + step_s - (begin_s if self._begin_s is None else self._begin_s))


def _check_version(needed_version: str) -> None:
    if needed_version != VERSION:
        raise UsageError(
            f"this FMU needs axistwin {needed_version}, but {VERSION} is installed: "
            f"install {needed_version}, or export the FMU again"
        )
