"""The computation of each servo sample, in plain Python that Numba can compile."""

from typing import TYPE_CHECKING

from axistwin.lazy import lazy

if TYPE_CHECKING:
    from axistwin.controllers.smartmotor.kernel.core import SAMPLE_NS, Engine
    from axistwin.controllers.smartmotor.kernel.interpreter import (
        COMPUTED,
        FETCH,
        HELD,
        SLOT,
        STACK,
        TRAP,
        VARIABLE,
        evaluate,
        statement,
    )
    from axistwin.controllers.smartmotor.kernel.kernel import ALL_DONE, TRAJECTORY, advance
    from axistwin.controllers.smartmotor.kernel.trajectory import max_stoppable_speed, next_velocity, stopping_distance
else:
    __getattr__ = lazy(
        __name__,
        core="Engine SAMPLE_NS",
        interpreter="COMPUTED FETCH HELD SLOT STACK TRAP VARIABLE evaluate statement",
        kernel="ALL_DONE TRAJECTORY advance",
        trajectory="max_stoppable_speed next_velocity stopping_distance",
    )

__all__ = [
    "ALL_DONE", "COMPUTED", "FETCH", "HELD", "SAMPLE_NS", "SLOT", "STACK", "TRAJECTORY", "TRAP", "VARIABLE",
    "Engine", "advance", "evaluate", "max_stoppable_speed", "next_velocity", "statement", "stopping_distance",
]  # fmt: skip
