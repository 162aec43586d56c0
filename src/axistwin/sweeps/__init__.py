"""Sweeps: run a scene many times with varied values, measure each run, and check claims about each run."""

from typing import TYPE_CHECKING

from axistwin.core.lazy import lazy

if TYPE_CHECKING:
    from axistwin.sweeps.designs import points
    from axistwin.sweeps.job import BOUND_NS, Runner
    from axistwin.sweeps.journal import digest, is_sweep, read
    from axistwin.sweeps.paths import Variation
    from axistwin.sweeps.recording import Recording
    from axistwin.sweeps.sentences import CLAIMS, MEASURES, claim, measure
    from axistwin.sweeps.series import Series
    from axistwin.sweeps.study import load
    from axistwin.sweeps.sweep import Design, Sweep
    from axistwin.sweeps.tuning import Tuning
    from axistwin.sweeps.values import read_values
    from axistwin.sweeps.workers import ThisProcess, Workers
else:
    __getattr__ = lazy(
        __name__, designs="points", job="BOUND_NS Runner", journal="digest is_sweep read", paths="Variation",
        recording="Recording", sentences="CLAIMS MEASURES claim measure", series="Series", study="load",
        sweep="Design Sweep", tuning="Tuning", values="read_values", workers="ThisProcess Workers",
    )  # fmt: skip

__all__ = [
    "BOUND_NS", "CLAIMS", "MEASURES", "Design", "Recording", "Runner", "Series", "Sweep", "ThisProcess", "Tuning",
    "Variation", "Workers", "claim", "digest", "is_sweep", "load", "measure", "points", "read", "read_values",
]  # fmt: skip
